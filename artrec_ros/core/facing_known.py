"""Objects that face the camera where earlier frames say that they may be: judged by the same evidence as any other."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .base.config import RecognizerConfig
from .facing_sizes import FacingSizes
from .image.image_frame import ImageFrame
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .pose.ranked import Ranked, first_of_each
from .verdict.claims import left_by
from .verdict.judge import Judge
from .verdict.verdicts import Verdict


class FacingKnown:
    """One target's."""

    def __init__(self, finder: WholeObjectFinder, sizes: FacingSizes, config: RecognizerConfig) -> None:
        self._finder, self._sizes, self._search = finder, sizes, config.search
        self._judge, self._lacking = Judge.of(config), math.log1p(config.guesses.small_px)

    def found(self, frame: ImageFrame, known: Poses) -> Ranked:
        """What becomes of objects where they are expected.

        :param known: (2 K,) of K objects, each in two places, see `Known.at`: the better one is gone on with.
        """
        if not len(known):
            return self._finder.ranked(frame, known)
        finder, kin = self._finder, self._finder.surface.kinematics
        expected = finder.climber.within_limits(frame.camera, replace(known, q=kin.bound(known.q)))
        found = finder.ranked(frame, expected)
        found = found[first_of_each(np.arange(len(found)) // 2, found.votes, 1)]
        found = found[np.flatnonzero(found.votes > 0)]
        rested = finder.polished(frame, found, finder.last_climb)
        found += rested + self._sizes.larger(frame, rested, finder.last_climb)
        return found.best(len(found), self._search)

    def left(self, frame: ImageFrame, known: Ranked) -> ImageFrame:
        """A frame without the pixels of known objects that are sure, and lack nothing: what lacks a part may be another
        one, which has it."""
        verdicts = self._judge.verdicts(self._finder, known.poses, frame)
        return left_by(frame, [v.claim for v in (verdicts[n] for n in range(len(known))) if self._is_sure(v)])

    def _is_sure(self, verdict: Verdict) -> bool:
        trust, complete = self._judge.trust(verdict), -verdict.evidence.missing <= self._lacking
        return trust > self._search.sure and complete and self._judge.tells(verdict)

    def better(self, known: Ranked, found: Ranked) -> Ranked:
        """Those of known objects that a search did not come to, or to what has fewer votes: others would be judged for
        nothing."""
        there = self._finder.required.is_in_place_of(known.poses, found.poses, self._search.niche_rad)
        return known[np.flatnonzero(~(there & (found.votes >= known.votes[:, None])).any(axis=1))]
