"""Choosing among hypotheses: suppression modulo symmetry and batched robust refinement."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .alignment import Placements
from .compiled import contour_fit as compiled
from .compiled.jit import COMPILED
from .compiled.thinning import suppress as suppress_compiled
from .config import RecognizerConfig
from .contour_map import ContourMap
from .deadline import Deadline
from .shapes import Shape, pack_shapes
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
    order = np.lexsort((-placed.score, group))
    if COMPILED and not deadline.expired:
        packed = pack_shapes(tuple(shapes))
        limits = (packed, config.symmetry_px, same_place)
        return suppress_compiled(order, group, placed.t, placed.z, placed.w, placed.shape, quota, *limits)
    kept: list[int] = []
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
        k = float(placed.scale[best])
        order = shape.symmetry.order(k, symmetry_px)
        d = pose_distance_px(
            placed.t[block], placed.z[block], placed.t[best], placed.z[best], shape.rms_radius_m, order
        )
        d = np.hypot(d, shape.rms_radius_m * (np.abs(placed.w[block]) - abs(placed.w[best])))
        block = block[d > max(1.0, same_place * shape.rms_radius_m * k)]
    return kept


def refine(
    cmap: ContourMap, shapes: list[Shape], placed: Placements, config: RecognizerConfig, deadline: Deadline
) -> Placements:
    """All placements moved onto the contours in batches: Tukey-weighted point-to-line least squares.

    A similarity is linear in (z, t), an affinity in (z, t, w), so each step is one exact solve per placement.
    Those whose scale runs away by more than `max_refined_scale` keep their hypothesis, as do those the deadline
    leaves. With `max_slant_deg`, affinities follow; a caller chooses between the two by their evidence.
    """
    return _in_batches(cmap, shapes, placed, config, deadline, False)


def refine_slanted(
    cmap: ContourMap, shapes: list[Shape], placed: Placements, config: RecognizerConfig, deadline: Deadline
) -> Placements:
    """The same with affinities, as far as a turn of `max_slant_deg` out of the image plane squeezes a marker."""
    return _in_batches(cmap, shapes, placed, config, deadline, True)


def _in_batches(
    cmap: ContourMap,
    shapes: list[Shape],
    placed: Placements,
    config: RecognizerConfig,
    deadline: Deadline,
    slanted: bool,
) -> Placements:
    parts = []
    for start in range(0, len(placed), _BATCH):
        part = placed if len(placed) <= _BATCH else placed.take(np.arange(start, min(start + _BATCH, len(placed))))
        if not deadline.expired:
            refined = _refined if COMPILED else _refined_in_numpy
            part = refined(cmap, shapes, part, config, slanted)
        parts.append(part)
    return parts[0] if len(parts) == 1 else Placements.concatenate(parts)


@lru_cache(maxsize=8)
def _gates(steps: int) -> np.ndarray:
    return np.geomspace(*_GATES_PX, steps)


def _squeeze(config: RecognizerConfig, slanted: bool) -> float:
    """Greatest |w| / |z| of an affinity that a turn by `max_slant_deg` makes."""
    cosine = np.cos(np.radians(config.max_slant_deg))
    return float((1 - cosine) / (1 + cosine)) if slanted else 0.0


def _refined(
    cmap: ContourMap, shapes: list[Shape], placed: Placements, config: RecognizerConfig, slanted: bool
) -> Placements:
    t, z, w = compiled.refine(
        cmap.contours,
        pack_shapes(tuple(shapes)),
        placed.t,
        placed.z,
        placed.w,
        placed.shape,
        placed.slot,
        _gates(config.refine_steps),
        _POINT_STEP,
        _NORMAL_AGREEMENT,
        _DAMPING,
        _squeeze(config, slanted),
        config.max_refined_scale,
    )
    return placed.replace(t=t, z=z, w=w)


def _refined_in_numpy(
    cmap: ContourMap, shapes: list[Shape], placed: Placements, config: RecognizerConfig, slanted: bool
) -> Placements:
    return _Batch(cmap, shapes, placed).refined(config, _squeeze(config, slanted))


class _Batch:
    """Placements refined together. Shapes are scaled to unit rms radius, so z and w are in pixels like t."""

    def __init__(self, cmap: ContourMap, shapes: list[Shape], placed: Placements) -> None:
        self._cmap, self._placed = cmap, placed
        self._radius = np.array([s.rms_radius_m for s in shapes])[placed.shape]  # (K,)
        self._points = np.stack([s.points[::_POINT_STEP] for s in shapes])[placed.shape] / self._radius[:, None]
        self._normals = np.stack([s.normals[::_POINT_STEP] for s in shapes])[placed.shape]

    def refined(self, config: RecognizerConfig, squeeze: float) -> Placements:
        start = self._placed.replace(z=self._placed.z * self._radius, w=self._placed.w * self._radius)
        now = start
        for gate in _gates(config.refine_steps):
            limit = np.minimum(gate, np.maximum(1.5, 0.5 * np.abs(now.z)))
            dt, dz, dw = self._step(now, limit, squeeze > 0)
            w = now.w + dw
            w *= np.minimum(1.0, squeeze * np.abs(now.z + dz) / np.maximum(np.abs(w), 1e-12))
            now = now.replace(t=now.t + dt, z=now.z + dz, w=w)
        ratio = now.scale / start.scale
        tame = np.isfinite(now.t) & (ratio < config.max_refined_scale) & (ratio > 1 / config.max_refined_scale)
        t, z, w = (np.where(tame, getattr(now, f), getattr(start, f)) for f in ("t", "z", "w"))
        return self._placed.replace(t=t, z=z / self._radius, w=w / self._radius)

    def _step(self, now: Placements, gate: np.ndarray, slanted: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Changes of (t, z, w): one step of iteratively reweighted least squares."""
        where = now.where(self._points)  # (K, m)
        index = self._cmap.nearest_index(where, now.slot)
        n = self._cmap.normals[index]
        off = where - self._cmap.points[index]
        residual = np.real(np.conj(n) * off)
        agree = np.real(np.conj(now.turned(self._normals)) * n) >= _NORMAL_AGREEMENT
        use = agree & (np.abs(off) < 2 * gate[:, None])
        weight = np.where(use, np.clip(1 - (residual / gate[:, None]) ** 2, 0, None) ** 2, 0.0)
        along = np.conj(n) * self._points
        # d residual / d (x, y, Re z, Im z)
        columns = [n.real, n.imag, along.real, -along.imag]
        if slanted:
            across = np.conj(n) * np.conj(self._points)
            columns += [across.real, -across.imag]  # d residual / d (Re w, Im w)
        J = np.stack(columns, axis=-1)  # (K, m, 4 or 6)
        A = np.einsum("kmi,kmj->kij", J * weight[..., None], J)
        A += (_DAMPING * J.shape[1]) * np.eye(J.shape[2])
        b = -np.einsum("kmi,km->ki", J, weight * residual)
        d = np.linalg.solve(A, b[..., None])[..., 0]
        dw = d[:, 4] + 1j * d[:, 5] if slanted else np.zeros(len(d), complex)
        return d[:, 0] + 1j * d[:, 1], d[:, 2] + 1j * d[:, 3], dw
