"""Looks at blobs that nothing sure explains, a few together: for objects whose markers lie too far apart for others.
Of what two blobs show at all blobs besides.

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
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .pose.ranked import Ranked
from .pose.three_points import ThreePoints
from .verdict.claims import left_by, unexplained
from .verdict.judge import Judge
from .verdict.verdicts import Verdict

_TWO = 2  # blobs that tell a pose, of a long marker and another one: few pairs, beside threes


class ThreePointLooks:
    """Those for some targets."""

    def __init__(self, finders: Sequence[WholeObjectFinder], judge: Judge) -> None:
        of = {finder: ThreePoints(finder.surface, finder.config) for finder in finders}
        self._of = {finder: three for finder, three in of.items() if three.labels}
        self._judge = judge

    def candidates(
        self, frame: ImageFrame, accepted: Sequence[Verdict], blobs: Sequence[Blob], recall: Recall | None = None
    ) -> dict[WholeObjectFinder, Poses]:
        """Poses that may be objects, on blobs that sure ones leave; of what two blobs show, of which none is known from
        frames before, on all blobs besides. Both its parts may have been found on one of them, one behind the other:
        that has all of its pixels, and the other one's place is where nobody sees it.

        :param blobs: of the frame. :param recall: what earlier frames say of it: one of the blobs is new, or its turn
            has come.
        """
        out, recall = dict[WholeObjectFinder, Poses](), recall or Recall()
        for finder, three in self._of.items():
            mine = [b for b in blobs if b.label in three.labels]
            if len(mine) < three.least or frame.deadline.expired or recall.patience.is_late:
                continue
            left = left_by(frame, [v.claim for v in accepted if v.probability > finder.config.search.beyond_doubt])
            looks = [(left, list(compress(mine, unexplained(left, mine, finder.config.search.explained))))]
            if three.least == _TWO and len(looks[0][1]) < len(mine) and not recall.known(finder.target.name):
                looks.append((frame, mine))
            asked = [~recall.waits(finder.target.name, of) for _, of in looks]
            found = [
                self._climbed(finder, look, three.of(look, of, yes))
                for (look, of), yes in zip(looks, asked, strict=True)
                if yes.any()
            ]
            out |= {finder: Poses.concatenate(found)} if any(map(len, found)) else {}
        return out

    def _climbed(self, finder: WholeObjectFinder, frame: ImageFrame, by_blobs: Sequence[Poses]) -> Poses:
        """The few with most votes that may be objects, after a climb; of those on the same blobs the best one, for what
        is found already is found here, too.

        :param by_blobs: poses on the same blobs together.
        """
        found, config = Ranked(finder.surface.no_poses, np.zeros(0)), finder.config
        for poses in self._most_likely(finder, frame, by_blobs):
            if frame.deadline.expired:
                break
            found += finder.with_joints(frame, poses).best(1, config.search)
        if len(found):
            verdicts = self._judge.verdicts(finder, found.poses, frame)
            found = found[np.flatnonzero(verdicts.probability >= finder.config.search.hopeless)]
        if len(found):
            found = finder.polished(frame, found, finder.last_climb)
        return found.poses[np.flatnonzero(found.votes > 0)]

    def _most_likely(self, finder: WholeObjectFinder, frame: ImageFrame, by_blobs: Sequence[Poses]) -> list[Poses]:
        """The few that have most votes as they are."""
        if not by_blobs:
            return []
        votes = finder.voter.votes(frame, Poses.concatenate(list(by_blobs)), occlusion=False)
        first = np.cumsum([0, *(len(poses) for poses in by_blobs[:-1])])
        order = np.argsort(-np.maximum.reduceat(votes, first), kind="stable")
        return [by_blobs[n] for n in order[: finder.config.middles.triples_looks]]
