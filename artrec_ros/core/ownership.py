"""Which candidates become objects: the best takes its pixels, the others are judged by what is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .acceptance import Verdict, verdict_of
from .claims import claims_of, corners_of, silhouette
from .datatypes import Camera
from .evidence import LabelField
from .spatial import Poses
from .transforms import Array
from .whole_object import WholeObjectFinder

_MARGIN_PX, _MARGIN_SHARE = 3.0, 0.1  # around an object's corners: rings of its contours, and what a lens bends out


def share_out(
    found: Sequence[tuple[WholeObjectFinder, Poses]],
    field: LabelField,
    camera: Camera,
    least: float,
    trust: Callable[[Verdict], float],
) -> tuple[list[Verdict], list[Verdict]]:
    """Accepted claims of all targets together, best first, and the best of the others at each place.

    The claim with the most trusted votes takes its pixels; the others are judged again without them.

    :param least: claims with fewer votes are dropped.
    :param trust: what a claim's votes count, 0 to 1; 0: it is not acceptable.
    """
    accepted: list[Verdict] = []
    alive = [s for finder, poses in found for s in _standing(_Group(finder, poses, camera), field, least)]
    while True:
        trusted = [(weight, s) for s in alive if (weight := trust(s.verdict))]
        if not trusted:
            return accepted, _best_of_each_place([s.verdict for s in alive], camera)
        best = max(trusted, key=lambda t: t[0] * t[1].verdict.claim.votes)[1]
        accepted.append(best.verdict)
        alive.remove(best)
        if alive:
            field = field.without(silhouette(best.group.finder.surface, camera, best.verdict.claim.poses))
            alive = _judged_again(alive, best, field, least)


class _Group:
    """One target's hypotheses."""

    def __init__(self, finder: WholeObjectFinder, poses: Poses, camera: Camera) -> None:
        self.finder, self.poses, self.camera = finder, poses, camera

    @cached_property
    def boxes(self) -> Array:
        """(H, 2, 2) least and greatest pixels of all that the votes for each look at."""
        corners = corners_of(self.finder.surface, self.camera, self.poses)
        low, high = corners.min(axis=1), corners.max(axis=1)
        margin = _MARGIN_PX + _MARGIN_SHARE * (high - low)
        return np.stack([low - margin, high + margin], axis=1)


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


def _standing(group: _Group, field: LabelField, least: float, rows: Sequence[int] | None = None) -> list[_Standing]:
    """Claims of some hypotheses, or of all, with votes enough."""
    rows = range(len(group.poses)) if rows is None else rows
    claims = claims_of(group.finder, group.poses[list(rows)], field, group.camera)
    return [_Standing(group, row, verdict_of(c)) for row, c in zip(rows, claims, strict=True) if c.votes > least]


def _judged_again(alive: list[_Standing], owner: _Standing, field: LabelField, least: float) -> list[_Standing]:
    """Those that stand where some pixels have found an owner."""
    out = [s for s in alive if not s.meets(owner)]
    for group in dict.fromkeys(s.group for s in alive):
        out += _standing(group, field, least, [s.row for s in alive if s.group is group and s.meets(owner)])
    return out


def _best_of_each_place(verdicts: list[Verdict], camera: Camera) -> list[Verdict]:
    out: list[Verdict] = []
    for verdict in sorted(verdicts, key=lambda v: -v.claim.votes):
        claim = verdict.claim
        near = (v.claim for v in out if v.claim.finder is claim.finder)
        if not any(claim.finder.same_place(camera, claim.poses, c.poses)[0] for c in near):
            out.append(verdict)
    return out
