"""Looks at blobs that nothing sure explains, three at a time: for objects whose markers lie too far apart for others.

What comes of it is a candidate beside what was found: the pixels are shared out anew, and the one with more votes
stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import compress

import numpy as np

from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .memory.recall import Recall
from .pose.climber import Climb
from .pose.finder import WholeObjectFinder
from .pose.surface_model import Poses
from .pose.three_blobs import ThreeBlobs
from .verdict.acceptance import Verdict
from .verdict.claims import left_by, unexplained
from .verdict.judge import Judge


class ThreeBlobLooks:
    """Those for some targets. :param climb: on the votes, of what was found."""

    def __init__(self, finders: Sequence[WholeObjectFinder], judge: Judge, climb: Climb) -> None:
        of = {finder: ThreeBlobs(finder.surface, finder.config) for finder in finders}
        self._of = {finder: three for finder, three in of.items() if three.labels}
        self._judge, self._climb = judge, climb

    def candidates(
        self, frame: ImageFrame, accepted: Sequence[Verdict], blobs: Sequence[Blob], recall: Recall | None = None
    ) -> dict[WholeObjectFinder, Poses]:
        """Poses that may be objects, on blobs that sure ones leave.

        :param blobs: of the frame. :param recall: what earlier frames say of it: one of three blobs is new, or its turn
            has come.
        """
        out, recall = dict[WholeObjectFinder, Poses](), recall or Recall()
        for finder, three in self._of.items():
            mine = [b for b in blobs if b.label in three.labels]
            if len(mine) < 3 or frame.deadline.expired or recall.patience.is_late:
                continue
            left = left_by(frame, [v.claim for v in accepted if v.probability > finder.config.search.beyond_doubt])
            mine = list(compress(mine, unexplained(left, mine, finder.config.search.explained)))
            asked = ~recall.waits(finder.target.name, mine)
            if asked.any():
                found = self._climbed(finder, left, three.of(left, mine, asked))
                out |= {finder: found} if len(found) else {}
        return out

    def _climbed(self, finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Poses:
        """The few with most votes that may be objects, after a climb."""
        if not len(poses) or frame.deadline.expired:
            return poses[:0]
        found = finder.with_joints(frame, poses).best(finder.config.middles.keep, finder.config.search)
        if len(found):
            verdicts = self._judge.verdicts(finder, found.poses, frame)
            found = found[np.flatnonzero(verdicts.probability >= finder.config.search.hopeless)]
        if len(found):
            found = finder.polished(frame, found, self._climb)
        return found.poses[np.flatnonzero(found.votes > 0)]
