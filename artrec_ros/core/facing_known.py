"""Objects that face the camera where earlier frames say that they may be: judged by the same evidence as any other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from .base.config import RecognizerConfig
from .facing_sizes import FacingSizes
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .memory.recall import Recall
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .pose.ranked import Ranked, first_of_each
from .verdict.claims import left_by, unexplained
from .verdict.judge import Judge
from .verdict.verdicts import Verdict


class FacingKnown:
    """One target's."""

    def __init__(self, finder: WholeObjectFinder, sizes: FacingSizes, config: RecognizerConfig) -> None:
        self._finder, self._sizes, self._search = finder, sizes, config.search
        self._labels = finder.root_labels
        self._judge = Judge.of(config)

    def beside(
        self, frame: ImageFrame, blobs: Sequence[Blob], recall: Recall, search: Callable[[Sequence[Blob]], Ranked]
    ) -> Ranked:
        """Candidates of a search in blobs, and known objects. Blobs that sure ones explain are searched in their turn.

        :param recall: what earlier frames say of this one, and where it is noted which blobs were searched.
        """
        known, mine = self._found(frame, recall.expected(self._finder)), [b for b in blobs if b.label in self._labels]
        turns = recall.turns(self._finder.target.name, mine)
        free = unexplained(self._left(frame, known, recall), mine, self._search.explained)
        waiting = {id(b) for b, open_ in zip(mine, free.tolist(), strict=True) if not open_ and turns.waits(b)}
        found = search([b for b in blobs if id(b) not in waiting])
        for blob in mine if not frame.deadline.expired else ():
            if id(blob) not in waiting:
                turns.search(blob)
                turns.explain(blob)  # what nothing explains is searched in any case
        return found + self._better(known, found)

    def _found(self, frame: ImageFrame, known: Poses) -> Ranked:
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
        if finder.surface.is_lone_marker:  # a climb on few votes may lead away from where it lies
            found += finder.fit_all(frame, found.poses)
        return found.best(len(found), self._search)

    def _left(self, frame: ImageFrame, known: Ranked, recall: Recall) -> ImageFrame:
        """A frame without the pixels of known objects that are sure, have about as many votes as before, and lack
        nothing: what lacks a part may be another one, which has it, and what changed so much lie otherwise."""
        verdicts = self._judge.verdicts(self._finder, known.poses, frame)
        claims = [v.claim for v in (verdicts[n] for n in range(len(known))) if self._is_sure(v)]
        return left_by(frame, [c for c in claims if recall.keeps(self._finder, c.poses, c.votes)])

    def _is_sure(self, verdict: Verdict) -> bool:
        judge = self._judge
        return judge.trust(verdict) > self._search.sure and judge.is_complete(verdict) and judge.tells(verdict)

    def _better(self, known: Ranked, found: Ranked) -> Ranked:
        """Those of known objects that a search did not come to, or to what has fewer votes: others would be judged for
        nothing."""
        there = self._finder.required.is_in_place_of(known.poses, found.poses, self._search.niche_rad)
        return known[np.flatnonzero(~(there & (found.votes >= known.votes[:, None])).any(axis=1))]
