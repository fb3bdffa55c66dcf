"""Which candidates become objects: the best takes its pixels, the others are judged by what is left."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.deferred import Deferred
from ..geometry.camera import Camera
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from .claims import Seen, widened
from .contenders import Contenders
from .judge import Judge
from .looks import Judged, Looks, Owner, Owners
from .other_objects import rivals_of
from .verdicts import Verdict, Verdicts

_AT_ONCE = 64  # claims between two looks at the clock


class Shared(NamedTuple):
    """What becomes of candidates: verdicts on those of all targets that are objects, best first, and on the best of the
    others at each place.

    :ivar rivals: of each of the former candidates in its place, the best of each other target and those of its own
        that show something else, which would be objects if nobody owned any pixels.
    """

    accepted: list[Verdict]
    others: Sequence[Verdict]
    rivals: Mapping[Verdict, Sequence[Verdict]] = {}


def share_out(
    found: Sequence[tuple[WholeObjectFinder, Poses]],
    frame: ImageFrame,
    judge: Judge,
    looks: Looks | None = None,
) -> Shared:
    """Verdicts on the claims of all targets together; those that are no objects are sorted out when they are looked at.

    The claim with the most trusted votes of all that it meets takes its pixels; others that stand there are judged
    again without them. One that is not told, for its required component is out of sight, or looks more like another,
    takes its pixels, too: laid otherwise, they would make an object that is not there. When the time is over, only what
    was judged is shared out, and what stands in an accepted one's place is dropped instead; of what was turned down
    nothing is told.

    :param looks: at those of these candidates that were shared out before.
    """
    field, accepted = _Field(found, frame.camera, judge, looks or Looks()), []
    field.judge_all(frame)
    while len(best := field.best()):
        accepted += field.accepted(best)
        met = field.taken(best)
        if frame.deadline.expired:
            field.worth[met] = -np.inf
        elif len(met):
            frame = field.left(frame, best)
            field.judge(met, frame)
    accepted.sort(key=lambda both: -both[0])
    told, untold = list[Verdict](), list[Verdict]()
    for _, verdict in accepted:
        (told if judge.tells(verdict) else untold).append(verdict)
    if frame.deadline.expired:
        return Shared(told, ())
    left = [*untold, *map(field.verdict, field.standing)]
    return Shared(told, Deferred(lambda: _best_of_each_place(left, frame.camera)), field.rivals())


class _Field:
    """N hypotheses of all targets, one target's after the other's.

    :param worth: (N,) their trusted votes, 0 of what is no object; -inf: it does not stand, or no longer.
    """

    def __init__(
        self, found: Sequence[tuple[WholeObjectFinder, Poses]], camera: Camera, judge: Judge, looks: Looks
    ) -> None:
        self._judge, self._groups = judge, [Contenders.of(finder, poses, camera) for finder, poses in found]
        self._looks, self._owners = looks, Owners()
        self._taking: dict[int, Verdict] = {}  # who took pixels, by their rows
        self._first = np.cumsum([0, *(len(g.poses) for g in self._groups)])
        self._boxes = np.concatenate([np.zeros((0, 2, 2)), *(g.boxes for g in self._groups)])
        self._last: list[tuple[Verdicts, int] | None] = [None] * len(self._boxes)
        self._seen = [
            Seen(np.empty((len(g.poses), len(g.finder.surface.patches))), np.empty(len(g.poses))) for g in self._groups
        ]
        self._swells = [False] * len(self._groups)  # by what most of an image's objects show
        self.worth, self._swollen_px = np.full(len(self._boxes), -np.inf), np.zeros(len(self._boxes))
        # how probable each is where nobody owns pixels, what it is worth, and its verdict
        self._alone, self._worth_alone = np.zeros(len(self._boxes)), np.zeros(len(self._boxes))
        self._first_look: list[tuple[Verdicts, int] | None] = [None] * len(self._boxes)
        self._in_place = np.zeros(len(self._boxes), bool)  # of an object of their own target, or it

    def judge_all(self, frame: ImageFrame) -> None:
        """Judge some of each target in turn until all are, or the time is over: some in any case."""
        looks: list[list[tuple[NDArray[np.int64], Verdicts]]] = [[] for _ in self._groups]
        for first in range(0, max((len(g.poses) for g in self._groups), default=0), _AT_ONCE):
            if first and frame.deadline.expired:
                return
            for g, (begin, end) in enumerate(pairwise(self._first)):
                rows = np.arange(min(begin + first, end), min(begin + first + _AT_ONCE, end))
                if len(rows):
                    looks[g].append((rows, self._note(g, rows, self._judged(g, rows, frame))))
        for g, mine in enumerate(looks):
            if mine and self._groups[g].may_swell and not frame.deadline.expired:
                self._look_swollen(g, mine)

    def judge(self, rows: NDArray[np.int64], frame: ImageFrame) -> None:
        """Judge some again, by the pixels that nobody owns in a frame."""
        for g, mine in self._by_group(rows):
            verdicts = self._note(g, mine, self._judged(g, mine, frame))
            if self._swells[g]:
                self._swell(mine, self._judge.swollen(verdicts))

    def _judged(self, g: int, rows: NDArray[np.int64], frame: ImageFrame) -> Judged:
        """Verdicts on some of a target's, and what each is worth: once for the same owners."""
        group, own = self._groups[g], rows - self._first[g]

        def look() -> Judged:
            seen = self._seen[g].of(own) if self._owners else None
            verdicts = self._judge.verdicts(group.finder, group.poses[own], frame, seen)
            return verdicts, self._judge.worth(verdicts)

        return self._looks.at(self._owners, group.finder, group.poses, own, look)

    def _note(self, g: int, rows: NDArray[np.int64], judged: Judged) -> Verdicts:
        """Have verdicts be the last ones on some of a target's."""
        (verdicts, worth), seen, own = judged, self._seen[g], rows - self._first[g]
        if not self._owners:
            seen.full_px[own], seen.even[own] = verdicts.claims.seen
            self._alone[rows], self._worth_alone[rows] = verdicts.probability, worth
        self.worth[rows], self._swollen_px[rows] = worth, 0.0
        for i, row in enumerate(rows.tolist()):
            self._last[row] = verdicts, i
            if not self._owners:
                self._first_look[row] = verdicts, i
        return verdicts

    def _look_swollen(self, g: int, looks: Sequence[tuple[NDArray[np.int64], Verdicts]]) -> None:
        """Have one target's be worth what they are with markers as large as they look, if most of the image's look
        larger.

        Else a wrong one takes their place, at a scale as large as they seem to be, or what they leave of their blobs
        does; and of small markers that look a pixel larger all of the outline lies amid their class.
        """
        rows = np.concatenate([mine for mine, _ in looks])
        larger = [(mine, list(self._judge.swollen(verdicts))) for mine, verdicts in looks]
        full = np.concatenate([again[-1][1] if again else np.zeros(len(mine)) for mine, again in larger])
        self._swells[g] = self._of_the_best(rows, full) > self._of_the_best(rows, self.worth[rows])
        for mine, again in larger if self._swells[g] else ():
            self._swell(mine, again)

    def _swell(self, rows: NDArray[np.int64], larger: Iterable[tuple[Verdicts, Array, float]]) -> None:
        for verdicts, worth, by_px in larger:
            better = np.flatnonzero(worth > self.worth[rows])
            self.worth[rows[better]], self._swollen_px[rows[better]] = worth[better], by_px
            if not self._owners:
                self._alone[rows] = np.maximum(self._alone[rows], verdicts.probability)
                self._worth_alone[rows] = np.maximum(self._worth_alone[rows], worth)
            for i in better.tolist():
                self._last[int(rows[i])] = verdicts, i

    def _of_the_best(self, rows: NDArray[np.int64], worth: Array) -> float:
        """What those of some that meet no better one are worth together."""
        order = np.argsort(-worth, kind="stable")
        rows, worth = rows[order], worth[order]
        return float(worth[(worth > 0) & ~np.tril(self._meet(rows, rows), -1).any(axis=1)].sum())

    def verdict(self, row: int) -> Verdict:
        """The last one on a hypothesis that was judged."""
        last = self._last[row]
        assert last is not None  # the caller's condition
        return last[0][last[1]]

    @property
    def standing(self) -> list[int]:
        """Those that were judged, and that nobody took the place of."""
        return [int(row) for row in np.flatnonzero(self.worth > -np.inf)]

    def best(self) -> NDArray[np.int64]:
        """Objects of which each one has more trusted votes than any other object that it meets."""
        rows = np.flatnonzero(self.worth > 0)
        worth = self.worth[rows]
        rows = rows[np.argsort(-worth, kind="stable")]
        return rows[~np.tril(self._meet(rows, rows), -1).any(axis=1)]

    def accepted(self, rows: NDArray[np.int64]) -> list[tuple[float, Verdict]]:
        """What some that take their pixels are worth, and verdicts on them that tell whose they were judged without."""
        taking = np.array(list(self._taking), np.int64)
        for row, met in zip(rows.tolist(), self._meet(rows, taking), strict=True):
            owners = tuple(self._taking[other] for other in taking[met].tolist())
            alone, wider_px = float(self._alone[row]), float(self._swollen_px[row])
            self._taking[row] = replace(self.verdict(row), owners=owners, alone=alone, wider_px=wider_px)
        return [(float(self.worth[row]), self._taking[row]) for row in rows.tolist()]

    def rivals(self) -> Mapping[Verdict, Sequence[Verdict]]:
        """See `Shared.rivals`."""
        lost = np.flatnonzero((self._worth_alone > 0) & ~self._in_place).tolist()
        beside = {n for n in lost if self.worth[n] == 0 and any(self.verdict(n).confirmed)}
        beside |= {n for n, v in self._taking.items() if v.owners and self._may_not_be_beside(n)}
        stood = [*lost, *beside.difference(lost)]
        if not beside and len({g.finder for g in self._groups}) < 2:
            return {}
        looks = ((n, self._first_look[n]) for n in stood)
        others = {n: look[0][look[1]] for n, look in looks if look is not None}
        return rivals_of(self._taking, others, beside, self._boxes, self._worth_alone)

    def _may_not_be_beside(self, row: int) -> bool:
        """Whether one that took pixels lacks by its owners what it would show without them, and is not told so, or
        faces the camera: there nothing lies beneath another object."""
        last, first = self.verdict(row), self._first_look[row]
        if first is None or all(last.confirmed[c] for c in np.flatnonzero(first[0].confirmed[first[1]]).tolist()):
            return False
        return last.finder.facing or not self._judge.tells(last)

    def taken(self, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """Have some stand no longer, nor what would stand in their very places. Who meets one of them."""
        self.worth[rows], self._in_place[rows] = -np.inf, True
        for g, mine in self._by_group(rows):
            self._clear(g, mine)
        left = np.flatnonzero(self.worth > -np.inf)
        return left[self._meet(left, rows).any(axis=1)]

    def _by_group(self, rows: NDArray[np.int64]) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Those of each target that has some."""
        for g, (begin, end) in enumerate(pairwise(self._first)):
            mine = rows[(rows >= begin) & (rows < end)]
            if len(mine):
                yield g, mine

    def _clear(self, g: int, rows: NDArray[np.int64]) -> None:
        """Where objects of one target stand there is no other one of it: what they leave of their rims is none."""
        group, first = self._groups[g], self._first[g]
        left = np.flatnonzero(self.worth[first : self._first[g + 1]] > 0)
        turn = group.finder.config.search.niche_rad
        same = group.finder.required.is_in_place_of(group.poses[left], group.poses[rows - first], turn).any(axis=1)
        self.worth[first + left[same]], self._in_place[first + left[same]] = -np.inf, True

    def _meet(self, rows: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(n, m) whether what one owns can matter to the other."""
        mine, theirs = self._boxes.take(rows, 0)[:, None], self._boxes.take(others, 0)
        meet = (mine[..., 0, :] <= theirs[:, 1]) & (theirs[:, 0] <= mine[..., 1, :])  # along x and along y
        return np.asarray(meet[..., 0] & meet[..., 1])

    def left(self, frame: ImageFrame, rows: NDArray[np.int64]) -> ImageFrame:
        """A frame without the pixels of some that take theirs."""
        g = np.searchsorted(self._first, rows, side="right") - 1
        self._owners += tuple(
            Owner(id(self._groups[i].poses), int(row - self._first[i]), float(self._swollen_px[row]))
            for i, row in zip(g.tolist(), rows, strict=True)
        )
        return self._looks.left(self._owners, frame, partial(self._silhouettes, rows))

    def _silhouettes(self, rows: NDArray[np.int64]) -> list[NDArray[np.float32]]:
        """Convex hulls of these points (n, 2) cover some hypotheses, each for itself."""
        g = np.searchsorted(self._first, rows, side="right") - 1
        return [
            widened(hull, float(self._swollen_px[row]))
            for i, row in zip(g, rows, strict=True)
            for hull in self._groups[i].hulls(row - self._first[i])
        ]


def _best_of_each_place(verdicts: list[Verdict], camera: Camera) -> list[Verdict]:
    """Of each target those that lie over none with more votes, of those that do not themselves; most votes first."""
    order, gone = sorted(verdicts, key=lambda v: -v.votes), set[int]()
    for finder in dict.fromkeys(v.finder for v in order):
        rows = [n for n, v in enumerate(order) if v.finder is finder]
        poses = Poses.concatenate([order[n].poses for n in rows])
        over, left = finder.required.are_over(camera, poses, poses), np.ones(len(rows), bool)
        for n, below in enumerate(over):
            if left[n]:
                left[n + 1 :] &= ~below[n + 1 :]
        gone.update(np.array(rows)[~left].tolist())
    return [v for n, v in enumerate(order) if n not in gone]
