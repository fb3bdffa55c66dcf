"""Profile `paper`: the method as published, with its values. The baseline for ever; known faults are kept.

What differs from the default profile: the first pose that matches 0.4 of the contour is accepted unrefined; the
tolerance area is each blob's own; T_ij is in pixels and checked against the examples' bare axis-parallel box, one
for each pair of components; angles are numbers and not circular; groups grow greedily, one torso after another.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from ..alignment.contour_map import ContourMap
from ..alignment.hypotheses import anchor_couples
from ..alignment.matching import Matches, concatenate_matches
from ..alignment.placements import Placements, evidence, matched_share
from ..alignment.refinement import suppress
from ..alignment.shapes import Shape
from ..base.config import RecognizerConfig
from ..base.deadline import Deadline
from ..constraints.constraint_set import ConstraintSet
from ..constraints.pairs import configuration
from ..image.blobs import Blob, blob_anchors
from .candidates import Candidates, Roles, candidates_of
from .group_search import Group

Box = dict[str, tuple[float, float]]
_DIMENSIONS = ("distance_px", "bearing_rad", "turn_rad")


def align_literally(
    blobs: tuple[Blob, ...],
    size: tuple[int, int],
    shapes: list[Shape],
    wanted: set[tuple[int, int]],
    config: RecognizerConfig,
    deadline: Deadline,
) -> Matches:
    """Steps 2 to 5: couples of consecutive anchors, tolerance area per blob, threshold 0.4, first match in a place."""
    config = _without_symmetry(config)  # the paper knows no symmetry
    found = []
    for n, blob in enumerate(blobs):
        if deadline.expired:
            break
        cmap = ContourMap.build((blob,), size)
        anchors = blob_anchors(blob, config)[0] @ np.array([1, 1j])
        for s in sorted(s for s, label in wanted if label == blob.label):
            placed = _all_couples(anchors, shapes[s], s, n)
            share = matched_share(cmap, shapes, placed, config.paper.tolerance_px, deadline)
            index = np.flatnonzero(share > config.paper.match)
            # The first in the order of the couples stands, however good the later ones are.
            placed = placed.take(index).replace(score=-np.arange(len(index), dtype=float))
            one, most = np.zeros(len(placed), int), np.full(len(placed), config.alignment.max_instances)
            kept = suppress(placed, one, shapes, most, config, config.alignment.same_start)
            placed = placed.take(kept).replace(score=share[index][kept])
            labels = np.full(len(placed), blob.label)
            found.append(Matches(shapes, placed, labels, evidence(cmap, shapes, placed, config)))
    return _first(concatenate_matches(shapes, found), config.alignment.max_instances)


def _without_symmetry(config: RecognizerConfig) -> RecognizerConfig:
    return dataclasses.replace(config, alignment=dataclasses.replace(config.alignment, symmetry_px=0.0))


def _first(matches: Matches, most: int) -> Matches:
    """No more than so many instances of a shape and class, in the order they were found."""
    group = matches.labels * len(matches.shapes) + matches.placed.shape
    kept = [np.flatnonzero(group == g)[:most] for g in np.unique(group)]
    return matches.take(np.sort(np.concatenate(kept))) if kept else matches


def _all_couples(anchors: np.ndarray, shape: Shape, s: int, blob: int) -> Placements:
    p1, p2 = anchor_couples(anchors, (1,))
    q1, q2 = anchor_couples(shape.anchors, (1,))
    z = ((p2 - p1)[:, None] / (q2 - q1)[None]).ravel()
    t = (p1[:, None] - z.reshape(len(p1), len(q1)) * q1[None]).ravel()
    n = len(z)
    slot = np.zeros(n, np.int32)
    return Placements.similarities(t, z, np.full(n, s, np.int32), np.full(n, blob, np.int32), slot)


def group_literally(roles: Roles, matches: Matches, config: RecognizerConfig, deadline: Deadline) -> list[Group]:
    """Steps 6 to 8: from each torso in turn a group grows with backtracking; what it uses is gone for the next."""
    target, candidates = roles.target, candidates_of(roles, matches, _without_symmetry(config))
    components = [c.name for c in target.model.components]
    boxes = _boxes(target.constraints) if isinstance(target.constraints, ConstraintSet) else {}
    required = components.index(target.model.required.name)
    growth = _Growth(candidates, _holds(candidates, components, boxes, config), deadline)
    groups = []
    for seed in np.flatnonzero(candidates.component == required):
        if int(candidates.match[seed]) in growth.used or deadline.expired:
            continue
        members = growth.grow([int(seed)], [c for c in range(len(components)) if c != required])
        if len(members) >= min(config.min_in_plane, len(components)):
            groups.append(_group(candidates, members, len(components)))
            growth.used.update(groups[-1].matches)
    return groups


def _boxes(constraints: ConstraintSet) -> dict[tuple[str, str], Box]:
    """P_ij of step 7: the smallest box around all examples, whichever markers showed the components."""
    boxes: dict[tuple[str, str], Box] = {}
    for p in constraints.pairs:
        box = boxes.setdefault((p.first[0], p.second[0]), {})
        for d in _DIMENSIONS:
            if d in p.seen:
                low, high = box.get(d, (np.inf, -np.inf))
                box[d] = (min(low, p.seen[d].low), max(high, p.seen[d].high))
    return boxes


def _holds(
    c: Candidates, names: list[str], boxes: dict[tuple[str, str], Box], config: RecognizerConfig
) -> NDArray[np.bool_]:
    """(n, n) whether two candidates may be in one group: T_ij in P_ij, and nearly one scale."""
    holds = np.zeros((len(c), len(c)), bool)
    for (first, second), box in boxes.items():
        i = np.flatnonzero(c.component == names.index(first))
        j = np.flatnonzero(c.component == names.index(second))
        T = configuration(c.poses.at(i).at((slice(None), None)), c.poses.at(j).at((None, slice(None))))
        ratio = np.exp(np.abs(np.log(T["scale_ratio"])))
        good = ratio <= config.paper.scale_ratio
        for d, (low, high) in box.items():
            good &= (low <= T[d]) & (T[d] <= high)
        holds[np.ix_(i, j)] = good
        holds[np.ix_(j, i)] = good.T
    return holds


class _Growth:
    """A group grows: each component in turn takes the first instance that fits, and gives it back if that is worse."""

    def __init__(self, candidates: Candidates, holds: NDArray[np.bool_], deadline: Deadline) -> None:
        self._candidates, self._holds, self._deadline = candidates, holds, deadline
        self.used: set[int] = set()  # instances of earlier groups

    def grow(self, members: list[int], left: list[int]) -> list[int]:
        """The largest group found from these members with components of `left`, by the deadline."""
        c, best = self._candidates, members
        while left and not self._deadline.expired and len(best) < len(members) + len(left):
            taken = self.used | {int(c.match[m]) for m in members}
            for n in np.flatnonzero((c.component == left[0]) & self._holds[members].all(axis=0)):
                if int(c.match[n]) not in taken:
                    grown = self.grow([*members, int(n)], left[1:])
                    best = grown if len(grown) > len(best) else best
                    if len(best) == len(members) + len(left):
                        return best
            left = left[1:]  # this component missing
        return best


def _group(candidates: Candidates, members: list[int], count: int) -> Group:
    pairs = len(members) * (len(members) - 1) // 2
    matches = tuple(int(m) for m in candidates.match[members])
    score = float(np.mean(candidates.score[members])) * (0.5 + 0.5 * len(members) / count)
    return Group(candidates, tuple(members), matches, float(candidates.weight[members].sum()), score, pairs, pairs)
