"""Placed outlines moved onto contours, and how they agree: twins of `refinement._Batch` and `alignment.evidence`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .jit import jit


class Contours(NamedTuple):
    """A `ContourMap`'s nearest points."""

    nearest: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    left: int
    top: int
    height: int


@jit
def _nearest(contours: Any, slot: int, x: float, y: float) -> int:
    column = int(np.rint(min(max(x - contours.left, 0.0), contours.nearest.shape[1] - 1.0)))
    row = int(np.rint(min(max(y - contours.top, 0.0), contours.height - 1.0)))
    return contours.nearest[slot * contours.height + row, column]


@jit
def _agree(turned: complex, normal: complex, least: float) -> bool:
    """Whether the cosine between a direction and a unit normal (or zero) is `least` > 0 or more."""
    along = turned.real * normal.real + turned.imag * normal.imag
    length2 = turned.real * turned.real + turned.imag * turned.imag
    return along > 0 and along * along >= least * least * max(length2, 1e-24)


@jit
def _solve(A: Any, b: Any, n: int) -> None:
    """b becomes the solution of the symmetric positive definite A x = b: Cholesky, in place; the lower half is read."""
    for j in range(n):
        for k in range(j):
            A[j, j] -= A[j, k] * A[j, k]
        A[j, j] = np.sqrt(A[j, j])
        for i in range(j + 1, n):
            for k in range(j):
                A[i, j] -= A[i, k] * A[j, k]
            A[i, j] /= A[j, j]
    for i in range(n):
        for k in range(i):
            b[i] -= A[i, k] * b[k]
        b[i] /= A[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= A[k, i] * b[k]
        b[i] /= A[i, i]


@jit
def _accumulate(
    contours: Any, slot: int, points: Any, normals: Any, step: int, radius: float, t: complex, z: complex, w: complex,
    gate: float, agreement: float, n: int, A: Any, b: Any,
) -> None:  # fmt: skip
    """Normal equations of one step: A (lower half) and b are overwritten. z and w are in pixels."""
    A[:], b[:] = 0.0, 0.0
    row = np.empty(6)
    unit = 1 / radius
    for i in range(0, len(points), step):
        p = points[i] * unit
        where = t + z * p + w * np.conj(p)
        at = _nearest(contours, slot, where.real, where.imag)
        normal = contours.normals[at]
        off = where - contours.points[at]
        if off.real * off.real + off.imag * off.imag >= 4 * gate * gate:
            continue
        if not _agree(z * normals[i] - w * np.conj(normals[i]), normal, agreement):
            continue
        residual = normal.real * off.real + normal.imag * off.imag
        weight = 1 - (residual / gate) ** 2
        if weight <= 0:
            continue
        weight *= weight
        along, across = np.conj(normal) * p, np.conj(normal) * np.conj(p)
        row[0], row[1], row[2], row[3] = normal.real, normal.imag, along.real, -along.imag
        row[4], row[5] = across.real, -across.imag
        for j in range(n):
            weighted = weight * row[j]
            b[j] -= weighted * residual
            for k in range(j + 1):
                A[j, k] += weighted * row[k]


@jit
def refine(
    contours: Any, shape_points: Any, shape_normals: Any, radius: Any, t: Any, z: Any, w: Any, shape: Any, slot: Any,
    gates: Any, step: int, agreement: float, damping: float, squeeze: float, most: float,
) -> Any:  # fmt: skip
    """(t, z, w) refined; `squeeze`: greatest |w| / |z|, 0 for similarities alone; `most`: greatest change of scale."""
    new_t, new_z, new_w = t.copy(), z.copy(), w.copy()
    unknowns = 6 if squeeze > 0 else 4
    used = (shape_points.shape[1] + step - 1) // step
    A, b = np.empty((6, 6)), np.empty(6)
    for h in range(len(t)):
        s = shape[h]
        r = radius[s]
        th, zh, wh = t[h], z[h] * r, w[h] * r
        start = abs(zh) + abs(wh)
        for gate in gates:
            limit = min(gate, max(1.5, 0.5 * abs(zh)))
            _accumulate(contours, slot[h], shape_points[s], shape_normals[s], step, r, th, zh, wh, limit, agreement,
                        unknowns, A, b)  # fmt: skip
            for j in range(unknowns):
                A[j, j] += damping * used
            _solve(A, b, unknowns)
            th += complex(b[0], b[1])
            zh += complex(b[2], b[3])
            if squeeze > 0:
                wh += complex(b[4], b[5])
                wh *= min(1.0, squeeze * abs(zh) / max(abs(wh), 1e-12))
        ratio = (abs(zh) + abs(wh)) / start
        if 1 / most < ratio < most:
            new_t[h], new_z[h], new_w[h] = th, zh / r, wh / r
    return new_t, new_z, new_w


@jit
def _is_seen(x: float, y: float, width: int, height: int, blank: Any) -> bool:
    if not (0.5 < x < width - 1.5 and 0.5 < y < height - 1.5):
        return False
    for i in range(0, len(blank), 4):
        across = blank[i] - 1.5 <= x <= blank[i] + blank[i + 2] + 0.5
        if across and blank[i + 1] - 1.5 <= y <= blank[i + 1] + blank[i + 3] + 0.5:
            return False
    return True


@jit
def evidence(
    contours: Any, shape_points: Any, shape_normals: Any, t: Any, z: Any, w: Any, shape: Any, slot: Any,
    tolerance: Any, agreement: float, size: Any, blank: Any,
) -> Any:  # fmt: skip
    """(share, score, visible, matched) as in `Evidence`."""
    count, samples = len(t), shape_points.shape[1]
    share, score, visible = np.zeros(count), np.zeros(count), np.zeros(count)
    matched = np.full((count, samples), -1, np.int32)
    for h in range(count):
        seen, hits, worth = 0, 0, 0.0
        for i in range(samples):
            p, n = shape_points[shape[h], i], shape_normals[shape[h], i]
            where = t[h] + z[h] * p + w[h] * np.conj(p)
            in_view = _is_seen(where.real, where.imag, size[0], size[1], blank)
            seen += in_view
            at = _nearest(contours, slot[h], where.real, where.imag)
            off = where - contours.points[at]
            off2 = off.real * off.real + off.imag * off.imag
            if off2 > tolerance[h] * tolerance[h]:
                continue
            if not _agree(z[h] * n - w[h] * np.conj(n), contours.normals[at], agreement):
                continue
            matched[h, i] = at
            if in_view:
                hits += 1
                worth += 1 - 0.5 * off2 / (tolerance[h] * tolerance[h])
        share[h], score[h], visible[h] = hits / max(seen, 1), worth / max(seen, 1), seen / samples
    return share, score, visible, matched
