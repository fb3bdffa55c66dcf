"""Objects that face the camera where earlier frames say that they may be: judged by the same evidence as any other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .base.config import RecognizerConfig
from .facing_sizes import FacingSizes
from .image.image_frame import ImageFrame
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .pose.ranked import Ranked, first_of_each


class FacingKnown:
    """One target's."""

    def __init__(self, finder: WholeObjectFinder, sizes: FacingSizes, config: RecognizerConfig) -> None:
        self._finder, self._sizes, self._search = finder, sizes, config.search

    def found(self, frame: ImageFrame, known: Poses) -> Ranked:
        """What becomes of objects where they are expected.

        :param known: (2 K,) of K objects, each in two places, see `Known.at`: the better one is gone on with.
        """
        finder, kin = self._finder, self._finder.surface.kinematics
        expected = finder.climber.within_limits(frame.camera, replace(known, q=kin.bound(known.q)))
        found = finder.ranked(frame, expected)
        found = found[first_of_each(np.arange(len(found)) // 2, found.votes, 1)]
        rested = finder.polished(frame, found, finder.last_climb)
        found += rested + self._sizes.larger(frame, rested, finder.last_climb)
        return found.best(len(found), self._search)

    def better(self, known: Ranked, found: Ranked) -> Ranked:
        """Those of known objects that a search did not come to, or to what has fewer votes: others would be judged for
        nothing."""
        there = self._finder.required.is_in_place_of(known.poses, found.poses, self._search.niche_rad)
        return known[np.flatnonzero(~(there & (found.votes >= known.votes[:, None])).any(axis=1))]
