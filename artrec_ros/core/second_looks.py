"""Objects that were found, bent anew once it is known what the others are.

While blobs are looked at one after the other, an object whose joints carry joints may take the end of a neighbour that
crosses it, or go astray where that took some of its own. When all are found, what does not lie on its labels is sought
anew: in what the others leave, and in all of the image, as if they had taken too much. What comes of it is a candidate
beside those that the search has found: the pixels are shared out anew.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

from .base.config import SearchConfig
from .image.image_frame import ImageFrame
from .memory.recall import Recall
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .spatial_looks import SpatialLooks
from .verdict.claims import left_by, silhouette
from .verdict.judge import Judge
from .verdict.looks import Looks
from .verdict.ownership import Shared, share_out
from .verdict.verdicts import Verdict

_ROUNDS = 3  # what an object gives back in one its neighbour may take in the next
_Found = Sequence[tuple[WholeObjectFinder, Poses]]


class SecondLooks:
    """Those of one frame. :param recall: what earlier frames say of it; a known object is looked at in its turn."""

    def __init__(self, frame: ImageFrame, judge: Judge, config: SearchConfig, recall: Recall | None = None) -> None:
        self._frame, self._judge, self._recall = frame, judge, recall or Recall()
        self._hurried, self._looks = frame.hurried(config.search_share), SpatialLooks(judge, config)
        self._seen: set[tuple[int, bytes, bytes]] = set()  # of a finder poses, and the labels in which these were bent
        self._of: dict[WholeObjectFinder, Poses] = {}  # all candidates so far
        self._shared = Shared([], ())
        self._first = Looks()

    def shared(self, found: _Found) -> Shared:
        """What `share_out` makes of candidates, and of what second looks add to them."""
        self._of = dict(found)
        self._shared = share_out(found, self._frame, self._judge, self._first)
        self._bend_all()
        return self._shared

    def beside(self, more: _Found) -> Shared:
        """The same with some more candidates."""
        if self._take(more):
            self._bend_all()
        return self._shared

    @property
    def candidates(self) -> _Found:
        """All of them so far."""
        return list(self._of.items())

    def again(self, found: _Found) -> Shared | None:
        """What `share_out` makes of what is left of them; None: too late."""
        shared = share_out(found, self._frame, self._judge)
        return None if self._frame.deadline.expired else shared

    def _bend_all(self) -> None:
        for _ in range(_ROUNDS):
            told = self._shared.accepted
            more = [(v.claim.finder, poses) for v in told for poses in self._bent(v, told)]
            if not (more and self._take(more)):
                break

    def _take(self, more: _Found) -> bool:
        """Whether there was time to share the pixels out anew: what is shared out late leaves objects out."""
        for finder, poses in more:
            self._of[finder] = Poses.concatenate([self._of[finder], poses]) if finder in self._of else poses
        anew = share_out(list(self._of.items()), self._frame, self._judge, self._first)
        in_time = not self._frame.deadline.expired
        self._shared = anew if in_time else self._shared
        return in_time

    def _bent(self, one: Verdict, told: Sequence[Verdict]) -> Iterator[Poses]:
        """One object bent otherwise, where that explains more."""
        finder, poses = one.claim.finder, one.claim.poses
        if not (finder.bending.any and finder.bending.may_win(one.claim.scores, one.claim.votes)):
            return
        if self._recall.rests(finder, poses):
            return
        patience, others = self._recall.patience, [v.claim for v in told if v is not one]
        reach = _reach(silhouette(finder.surface, self._frame.camera, poses), self._frame.size)
        for frame in (left_by(self._hurried, others), self._hurried)[: 1 + bool(others)]:
            # what others do beyond its reach changes nothing
            key = id(finder), poses.key, sha256(frame.field.labels[reach].tobytes()).digest()
            if key in self._seen or frame.deadline.expired or patience.is_late:
                continue
            self._seen.add(key)
            again = partial(self._looks.again, frame, finder, poses)
            bent = patience.spent_on(again, self._recall.config.doubt_share)
            if bent is not None:
                yield bent


def _reach(hulls: Sequence[NDArray[np.float32]], size: tuple[int, int]) -> tuple[slice, slice]:
    """Rows and columns of an image of `size` (width, height) where an object may be, bent otherwise: as far around it
    as it is long."""
    points = np.concatenate(hulls)
    low, high = points.min(axis=0), points.max(axis=0)
    length = float(np.linalg.norm(high - low))
    first, last = np.maximum(low - length, 0).astype(int), np.minimum(high + length + 1, size).astype(int)
    return slice(int(first[1]), int(last[1])), slice(int(first[0]), int(last[0]))
