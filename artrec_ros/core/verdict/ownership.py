"""Which candidates become objects: the best takes its pixels, the others are judged by what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..geometry.camera import Camera
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..pose.finder import WholeObjectFinder
from ..pose.surface_model import Poses
from .acceptance import Verdict
from .claims import corners_of, silhouette
from .judge import Judge

_ROUNDED_PX = 1.0  # a pixel that is looked up, and one that an owner's silhouette fills, are rounded


def share_out(
    found: Sequence[tuple[WholeObjectFinder, Poses]], frame: ImageFrame, judge: Judge
) -> tuple[list[Verdict], list[Verdict]]:
    """Verdicts on accepted claims of all targets together, best first, and on the best of the others at each place.

    The claim with the most trusted votes takes its pixels; others that stand there are judged again without them. When
    the time is over these are dropped instead, and what was turned down is told of as far as it is sorted.
    """
    accepted: list[Verdict] = []
    groups = [_Group(finder, poses, frame.camera, judge) for finder, poses in found]
    alive = [s for group in groups for s in group.judged(range(len(group.poses)), frame) if s is not None]
    while True:
        best = _best(alive, judge)
        if best is None:
            return accepted, _best_of_each_place([s.verdict for s in alive], frame)
        accepted.append(best.verdict)
        alive.remove(best)
        if frame.deadline.expired:
            alive = [s for s in alive if not s.meets(best)]
        elif alive:
            frame = frame.without(silhouette(best.group.finder.surface, frame.camera, best.verdict.claim.poses))
            alive = _judged_again(alive, best, frame)


def _best(alive: list[_Standing], judge: Judge) -> _Standing | None:
    """The one with the most trusted votes; None where none is an object. Who has fewer votes at all is not asked."""
    best, most = None, 0.0
    for standing in sorted(alive, key=lambda s: -s.verdict.claim.votes):
        if standing.verdict.claim.votes <= most:
            break
        trusted = judge.trust(standing.verdict) * standing.verdict.claim.votes
        if trusted > most:
            best, most = standing, trusted
    return best


@dataclass(frozen=True, eq=False)
class _Group:
    """One target's H hypotheses."""

    finder: WholeObjectFinder
    poses: Poses
    camera: Camera
    judge: Judge

    @cached_property
    def boxes(self) -> Array:
        """(H, 2, 2) least and greatest x, y of all pixels that the votes for each look at: those of its corners, of the
        rings around its contours, and what a lens bends out."""
        corners = corners_of(self.finder.surface, self.camera, self.poses)
        low, high = corners.min(axis=1), corners.max(axis=1)
        margin = self.finder.config.votes.ring_px + _ROUNDED_PX
        if self.camera.bent:  # what lies between corners is moved otherwise, by no more than they differ
            plain = replace(self.camera, distortion=np.zeros(0))
            moved = np.subtract(corners, corners_of(self.finder.surface, plain, self.poses))
            margin = margin + np.linalg.norm(np.ptp(moved, axis=1), axis=1, keepdims=True)
        return np.stack([low - margin, high + margin], axis=1)

    def judged(self, rows: Sequence[int], frame: ImageFrame) -> list[_Standing | None]:
        """Claims of some of the hypotheses; None for those without votes enough."""
        verdicts = self.judge.verdicts(self.finder, self.poses[list(rows)], frame)
        return [_Standing(self, row, v) if v is not None else None for row, v in zip(rows, verdicts, strict=True)]


@dataclass(frozen=True, eq=False)
class _Standing:
    """A claim that may still become an object."""

    group: _Group
    row: int
    verdict: Verdict

    def meets(self, other: _Standing) -> bool:
        """Whether what one owns can matter to the other."""
        (low, high), (other_low, other_high) = self.group.boxes[self.row], other.group.boxes[other.row]
        return bool((low <= other_high).all() and (other_low <= high).all())


def _judged_again(alive: list[_Standing], owner: _Standing, frame: ImageFrame) -> list[_Standing]:
    """Claims, in their order, after some pixels have found an owner: those that stand elsewhere are as they were."""
    met: dict[_Group, list[_Standing]] = {}
    for standing in alive:
        if standing.meets(owner):
            met.setdefault(standing.group, []).append(standing)
    anew: dict[_Standing, _Standing | None] = {}
    for group, mine in met.items():
        anew.update(zip(mine, group.judged([s.row for s in mine], frame), strict=True))
    return [now for now in (anew.get(s, s) for s in alive) if now is not None]


def _best_of_each_place(verdicts: list[Verdict], frame: ImageFrame) -> list[Verdict]:
    left, out = sorted(verdicts, key=lambda v: -v.claim.votes), []
    while left and not frame.deadline.expired:
        best, left = left[0], left[1:]
        out.append(best)
        mine = [v for v in left if v.claim.finder is best.claim.finder]
        if mine:
            poses = Poses.concatenate([v.claim.poses for v in mine])
            near = best.claim.finder.same_place(frame.camera, poses, best.claim.poses)
            gone = {id(v) for v, there in zip(mine, near, strict=True) if there}
            left = [v for v in left if id(v) not in gone]
    return out
