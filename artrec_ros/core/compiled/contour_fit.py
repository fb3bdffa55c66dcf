"""Placed outlines moved onto contours, and how they agree: twins of `refinement._Batch` and `alignment.evidence`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .jit import inlined, jit


class Contours(NamedTuple):
    """A `ContourMap`'s nearest points."""

    nearest: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    left: int
    top: int
    height: int


@inlined
def _nearest(contours: Any, slot: int, x: float, y: float) -> int:
    column = int(np.rint(min(max(x - contours.left, 0.0), contours.nearest.shape[1] - 1.0)))
    row = int(np.rint(min(max(y - contours.top, 0.0), contours.height - 1.0)))
    return contours.nearest[slot * contours.height + row, column]


@inlined
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


@inlined
def _weight(turned: complex, normal: complex, off: complex, gate: float, agreement: float) -> float:
    """Tukey's weight of a point that lies `off` from its nearest contour point; 0 where it is no correspondence."""
    if off.real * off.real + off.imag * off.imag >= 4 * gate * gate or not _agree(turned, normal, agreement):
        return 0.0
    far = (normal.real * off.real + normal.imag * off.imag) / gate
    return max(1 - far * far, 0.0) ** 2


@jit
def _similarity_step(
    contours: Any, slot: int, points: Any, normals: Any, step: int, t: complex, z: complex, gate: float,
    agreement: float, damping: float, A: Any, b: Any,
) -> None:  # fmt: skip
    """b becomes the changes of (x, y, Re z, Im z); z is in units of the points. A is scratch."""
    a00 = a10 = a11 = a20 = a21 = a22 = a30 = a31 = a32 = a33 = b0 = b1 = b2 = b3 = 0.0
    for i in range(0, len(points), step):
        p = points[i]
        where = t + z * p
        at = _nearest(contours, slot, where.real, where.imag)
        normal = contours.normals[at]
        off = where - contours.points[at]
        weight = _weight(z * normals[i], normal, off, gate, agreement)
        if weight == 0.0:
            continue
        nx, ny = normal.real, normal.imag
        along, across = nx * p.real + ny * p.imag, ny * p.real - nx * p.imag
        wx, wy, wa, wc = weight * nx, weight * ny, weight * along, weight * across
        residual = nx * off.real + ny * off.imag
        a00 += wx * nx
        a10 += wx * ny
        a11 += wy * ny
        a20 += wa * nx
        a21 += wa * ny
        a22 += wa * along
        a30 += wc * nx
        a31 += wc * ny
        a32 += wc * along
        a33 += wc * across
        b0 -= wx * residual
        b1 -= wy * residual
        b2 -= wa * residual
        b3 -= wc * residual
    A[0, 0], A[1, 0], A[1, 1], A[2, 0], A[2, 1] = a00 + damping, a10, a11 + damping, a20, a21
    A[2, 2], A[3, 0], A[3, 1], A[3, 2], A[3, 3] = a22 + damping, a30, a31, a32, a33 + damping
    b[0], b[1], b[2], b[3] = b0, b1, b2, b3
    _solve(A, b, 4)


@jit
def _affine_step(
    contours: Any, slot: int, points: Any, normals: Any, step: int, t: complex, z: complex, w: complex, gate: float,
    agreement: float, damping: float, A: Any, b: Any,
) -> None:  # fmt: skip
    """b becomes the changes of (x, y, Re z, Im z, Re w, Im w)."""
    A[:], b[:] = 0.0, 0.0
    row = np.empty(6)
    for i in range(0, len(points), step):
        p = points[i]
        where = t + z * p + w * np.conj(p)
        at = _nearest(contours, slot, where.real, where.imag)
        normal = contours.normals[at]
        off = where - contours.points[at]
        weight = _weight(z * normals[i] - w * np.conj(normals[i]), normal, off, gate, agreement)
        if weight == 0.0:
            continue
        residual = normal.real * off.real + normal.imag * off.imag
        along, across = np.conj(normal) * p, np.conj(normal) * np.conj(p)
        row[0], row[1], row[2], row[3] = normal.real, normal.imag, along.real, -along.imag
        row[4], row[5] = across.real, -across.imag
        for j in range(6):
            b[j] -= weight * row[j] * residual
            for k in range(j + 1):
                A[j, k] += weight * row[j] * row[k]
    for j in range(6):
        A[j, j] += damping
    _solve(A, b, 6)


@jit
def refine(
    contours: Any, shape_points: Any, shape_normals: Any, radius: Any, t: Any, z: Any, w: Any, shape: Any, slot: Any,
    gates: Any, step: int, agreement: float, damping: float, squeeze: float, most: float,
) -> Any:  # fmt: skip
    """(t, z, w) refined; `squeeze`: greatest |w| / |z|, 0 for similarities alone; `most`: greatest change of scale."""
    new_t, new_z, new_w = t.copy(), z.copy(), w.copy()
    damping = damping * ((shape_points.shape[1] + step - 1) // step)
    A, b = np.empty((6, 6)), np.empty(6)
    points = shape_points / radius.reshape(-1, 1)
    for h in range(len(t)):
        s = shape[h]
        r = radius[s]
        th, zh, wh = t[h], z[h] * r, w[h] * r
        start = abs(zh) + abs(wh)
        for gate in gates:
            limit = min(gate, max(1.5, 0.5 * abs(zh)))
            if squeeze > 0:
                _affine_step(contours, slot[h], points[s], shape_normals[s], step, th, zh, wh, limit, agreement,
                             damping, A, b)  # fmt: skip
            else:
                _similarity_step(contours, slot[h], points[s], shape_normals[s], step, th, zh, limit, agreement,
                                 damping, A, b)  # fmt: skip
            th += complex(b[0], b[1])
            zh += complex(b[2], b[3])
            if squeeze > 0:
                wh += complex(b[4], b[5])
                wh *= min(1.0, squeeze * abs(zh) / max(abs(wh), 1e-12))
        ratio = (abs(zh) + abs(wh)) / start
        if 1 / most < ratio < most:
            new_t[h], new_z[h], new_w[h] = th, zh / r, wh / r
    return new_t, new_z, new_w


@inlined
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


@jit
def stretches(index: Any, blob: Any, first: Any, count: Any, longest: int) -> Any:
    """`ContourMap.stretches`; contours are those of blobs that start at `first` and have `count` points."""
    held = np.zeros(len(blob), np.bool_)
    for i in range(len(index)):
        here, after = index[i], index[(i + 1) % len(index)]
        if here < 0:
            continue
        held[here] = True
        b = blob[here]
        if after < 0 or blob[after] != b:
            continue
        between = (after - here) % count[b]
        for step in range(1, between if between <= longest else 0):
            held[first[b] + (here - first[b] + step) % count[b]] = True
    return np.flatnonzero(held).astype(np.int32)
