"""Instances made into candidates, and those kept that could be part of an object (paper, steps 6 and 8)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..alignment.thinning_kernels import symmetry_order
from ..base.jit import jit
from ..constraints.pair_kernels import PoseArrays, check_pairs, wrapped


class RoleArrays(NamedTuple):
    """(R,) arrays of `candidates.Roles`."""

    component: np.ndarray
    marker: np.ndarray
    shape: np.ndarray
    label: np.ndarray
    axis_angle: np.ndarray


@jit
def _count(found: Any, roles: Any, residual: Any, symmetry_px: float) -> int:
    n = 0
    for r in range(len(roles.shape)):
        for k in range(len(found.t)):
            if found.shape[k] == roles.shape[r] and found.label[k] == roles.label[r]:
                scale = abs(found.z[k]) + abs(found.w[k])
                n += max(symmetry_order(residual[found.shape[k]], scale, symmetry_px), 1)
    return n


@jit
def candidates(found: Any, roles: Any, shapes: Any, symmetry_px: float, noise_px: float, noise_share: float) -> Any:
    """(poses, role, marker, share, score, weight) of every (instance, role, turn).

    :param noise_px, noise_share: `contour_noise_px` and `model_noise`.
    """
    n = _count(found, roles, shapes.residual, symmetry_px)
    real, whole = np.empty((10, n)), np.empty((4, n), np.int64)
    i = 0
    for r in range(len(roles.shape)):
        for k in range(len(found.t)):
            s = found.shape[k]
            if s != roles.shape[r] or found.label[k] != roles.label[r]:
                continue
            scale = abs(found.z[k]) + abs(found.w[k])
            order = symmetry_order(shapes.residual[s], scale, symmetry_px)
            axis = complex(math.cos(roles.axis_angle[r]), math.sin(roles.axis_angle[r]))
            along = found.z[k] * axis + found.w[k] * np.conj(axis)
            radius_px = shapes.radius[s] * scale
            place = math.hypot(noise_px, noise_share * radius_px)
            relative = place / max(radius_px, 1e-9)
            turns = max(order, 1)
            for turn in range(turns):
                theta = math.atan2(along.imag, along.real) + 2 * math.pi * turn / turns
                real[0, i], real[1, i] = found.t[k].real, found.t[k].imag
                real[2, i], real[3, i] = wrapped(theta, 2 * math.pi), scale
                real[4, i], real[5, i], real[6, i] = place, relative if order > 0 else math.pi, relative
                real[7, i], real[8, i] = found.share[k], found.score[k]
                real[9, i] = found.score[k] * found.in_view[k]
                whole[0, i], whole[1, i], whole[2, i], whole[3, i] = roles.component[r], r, k, roles.marker[r]
                i += 1
    poses = PoseArrays(real[0], real[1], real[2], real[3], real[4], real[5], real[6], whole[0], whole[1], whole[2])
    return poses, whole[3], real[7], real[8], real[9]


@jit
def _near(component: Any, others: Any, checked: Any, forbidden: Any, violation: Any) -> Any:
    """(others,) which go with a seed, or come nearest to one of all that could be their component."""
    near = np.zeros(len(others), np.bool_)
    for s in range(len(violation)):
        best, least = np.full(component.max() + 1, -1, np.int64), np.full(component.max() + 1, np.inf)
        for o in range(len(others)):
            c = component[others[o]]
            if not forbidden[s, o] and violation[s, o] <= 0:
                near[o] = True
            miss = violation[s, o] if checked[s, o] else np.inf
            if best[c] < 0 or miss < least[c]:
                best[c], least[c] = o, miss
        for o in best:
            if o >= 0:
                near[o] = True
    return near


@jit
def _joined(of_seeds: Any, of_partners: Any, seeds_alone: Any) -> Any:
    """(n, n) values of seeds and partners: (s, p) between them, (p, p) among partners, one value among seeds."""
    split, n = of_seeds.shape[0], of_seeds.shape[0] + of_seeds.shape[1]
    whole = np.empty((n, n), of_partners.dtype)
    whole[:split, :split] = seeds_alone
    whole[:split, split:] = of_seeds
    whole[split:, :split] = of_seeds.T
    whole[split:, split:] = of_partners
    return whole


@jit
def relate(c: Any, weight: Any, required: int, boxes: Any, overlap: Any, max_overlap: float, max_ratio: float,
           most: int) -> Any:  # fmt: skip
    """Seeds, and of the other candidates at most so many that matter to one, the heaviest.

    :return: their numbers, seeds first; how many seeds; (n, n) forbidden, checked, violation.
    """
    seeds, others = np.flatnonzero(c.component == required), np.flatnonzero(c.component != required)
    limits = (overlap, max_overlap, max_ratio)
    forbidden, checked, violation = check_pairs(c, seeds, others, boxes, *limits, False)
    partners = np.flatnonzero(_near(c.component, others, checked, forbidden, violation))
    if len(partners) > most:
        partners = np.sort(partners[np.argsort(-weight[others[partners]], kind="mergesort")[:most]])
    kept = np.concatenate((seeds, others[partners]))
    among = check_pairs(c, kept[len(seeds) :], kept[len(seeds) :], boxes, *limits, True)
    return (
        kept,
        len(seeds),
        _joined(forbidden[:, partners], among[0], True),
        _joined(checked[:, partners], among[1], False),
        _joined(violation[:, partners], among[2], 0.0),
    )
