"""Choosing among hypotheses: suppression modulo symmetry and batched robust refinement."""

from __future__ import annotations

import numpy as np

from .alignment import ContourMap, Placements
from .config import RecognizerConfig
from .deadline import Deadline
from .shapes import Shape
from .symmetry import ANY_ANGLE

_GATES_PX = (8.0, 1.5)  # Tukey gates from the first to the last step
_NORMAL_AGREEMENT = 0.6
_POINT_STEP = 2  # every second of a shape's 120 points
_DAMPING = 1e-3
_BATCH = 512  # placements between looks at the clock


def ranks_in_group(group: np.ndarray, score: np.ndarray) -> np.ndarray:
    """(H,) rank of each entry within its group, best score 0; ties keep their order."""
    if not len(group):
        return np.zeros(0, int)
    order = np.lexsort((np.arange(len(group)), -score, group))
    sorted_group = group[order]
    first = np.concatenate([[True], sorted_group[1:] != sorted_group[:-1]])
    start = np.maximum.accumulate(np.where(first, np.arange(len(group)), 0))
    ranks = np.empty(len(group), int)
    ranks[order] = np.arange(len(group)) - start
    return ranks


def pose_distance_px(t: np.ndarray, z: np.ndarray, t0: complex, z0: complex, radius_m: float, order: int) -> np.ndarray:
    """(n,) rms distance in pixels between a shape placed by (t, z) and by (t0, z0), modulo its symmetry.

    For points p about the centroid with rms radius r: |t - t0|^2 + r^2 |z - z0|^2.
    """
    if order == ANY_ANGLE:
        turn = np.abs(np.abs(z) - abs(z0))
    else:
        turns = np.exp(2j * np.pi * np.arange(order) / order)
        turn = np.min(np.abs(z[:, None] - z0 * turns[None]), axis=1)
    return np.sqrt(np.abs(t - t0) ** 2 + (radius_m * turn) ** 2)


def suppress(
    placed: Placements,
    group: np.ndarray,
    shapes: list[Shape],
    quota: np.ndarray,
    config: RecognizerConfig,
    same_place: float,
    deadline: Deadline,
) -> np.ndarray:
    """Indices of placements that are the best of their place, at most `quota` a group; groups by the deadline.

    :param group: (H,) only placements of one group, which share a shape, suppress each other.
    :param quota: (H,) the most that may be kept of the entry's group.
    :param same_place: poses closer than this share of the shape's radius, or 1 px, are one.
    """
    kept: list[int] = []
    order = np.lexsort((-placed.score, group))
    for block in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
        if len(block) and not deadline.expired:
            kept += _suppress_group(
                placed, block, shapes[placed.shape[block[0]]], int(quota[block[0]]), config.symmetry_px, same_place
            )
    return np.array(kept, int)


def _suppress_group(
    placed: Placements, block: np.ndarray, shape: Shape, quota: int, symmetry_px: float, same_place: float
) -> list[int]:
    kept: list[int] = []
    while len(block) and len(kept) < quota:
        best = int(block[0])
        kept.append(best)
        k = abs(placed.z[best])
        order = shape.symmetry.order(k, symmetry_px)
        d = pose_distance_px(
            placed.t[block], placed.z[block], placed.t[best], placed.z[best], shape.rms_radius_m, order
        )
        block = block[d > max(1.0, same_place * shape.rms_radius_m * k)]
    return kept


def refine(
    cmap: ContourMap, shapes: list[Shape], placed: Placements, config: RecognizerConfig, deadline: Deadline
) -> Placements:
    """All placements moved onto the contours in batches: Tukey-weighted point-to-line least squares.

    A similarity is linear in (z, t), so each step is one exact 4x4 solve per placement. Those whose scale
    runs away by more than `max_refined_scale` keep their hypothesis, as do those the deadline leaves.
    """
    parts = []
    for start in range(0, len(placed), _BATCH):
        part = placed.take(np.arange(start, min(start + _BATCH, len(placed))))
        parts.append(part if deadline.expired else _refine_batch(cmap, shapes, part, config))
    return Placements.concatenate(parts)


def _refine_batch(cmap: ContourMap, shapes: list[Shape], placed: Placements, config: RecognizerConfig) -> Placements:
    radius = np.array([s.rms_radius_m for s in shapes])[placed.shape]  # (K,)
    points = np.stack([s.points[::_POINT_STEP] for s in shapes])[placed.shape] / radius[:, None]  # unit rms radius
    normals = np.stack([s.normals[::_POINT_STEP] for s in shapes])[placed.shape]
    t, z = placed.t.copy(), placed.z * radius  # z in pixels: all four columns are of one size
    for gate in np.geomspace(*_GATES_PX, config.refine_steps):
        limit = np.minimum(gate, np.maximum(1.5, 0.5 * np.abs(z)))
        dt, dz = _step(cmap, placed.slot, points, normals, t, z, limit)
        t, z = t + dt, z + dz
    ratio = np.abs(z) / np.abs(placed.z * radius)
    tame = np.isfinite(t) & (ratio < config.max_refined_scale) & (ratio > 1 / config.max_refined_scale)
    moved = np.where(tame, t, placed.t), np.where(tame, z / radius, placed.z)
    return Placements(*moved, placed.shape, placed.blob, placed.slot, placed.score)


def _step(
    cmap: ContourMap,
    slot: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    t: np.ndarray,
    z: np.ndarray,
    gate: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    where = t[:, None] + z[:, None] * points  # (K, m)
    index = cmap.nearest_index(where, slot)
    n = cmap.normals[index]
    off = where - cmap.points[index]
    residual = np.real(np.conj(n) * off)
    turned = normals * (z / np.maximum(np.abs(z), 1e-12))[:, None]
    use = (np.real(np.conj(turned) * n) >= _NORMAL_AGREEMENT) & (np.abs(off) < 2 * gate[:, None])
    weight = np.where(use, np.clip(1 - (residual / gate[:, None]) ** 2, 0, None) ** 2, 0.0)
    along = np.conj(n) * points
    # d residual / d (Re z, Im z, x, y)
    J = np.stack([along.real, -along.imag, n.real, n.imag], axis=-1)  # (K, m, 4)
    A = np.einsum("kmi,kmj->kij", J * weight[..., None], J)
    A += (_DAMPING * points.shape[1]) * np.eye(4)
    b = -np.einsum("kmi,km->ki", J, weight * residual)
    d = np.linalg.solve(A, b[..., None])[..., 0]
    return d[:, 2] + 1j * d[:, 3], d[:, 0] + 1j * d[:, 1]
