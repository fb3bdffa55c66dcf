"""Placed outlines moved onto contours: iteratively reweighted least squares of distances to contours' tangents.

Shapes are scaled to unit rms radius, so that z and w are in pixels like t. Sums over points run without a branch, over
numbers and single arrays, so that the compiler can take several at once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted


class Contours(NamedTuple):
    """A `ContourMap`'s nearest points.

    :param nearest: (slots * height, w). :param edge: (P, 4) each point's x, y, with the atlas' origin, and its normal.
    :param left, top: origin; height: rows of a slot.
    """

    nearest: np.ndarray
    edge: np.ndarray
    left: int
    top: int
    height: int


@melted
def nearest_at(nearest: Any, width: int, top: int, height: int, x: float, y: float) -> int:
    """Contour point nearest to (x, y) of a slot. :param nearest: flat. :param top: the slot's first row."""
    column = np.rint(min(max(x, 0.0), width - 1.0))
    row = np.rint(min(max(y, 0.0), height - 1.0))
    return nearest[np.uint32((top + row) * width + column)]


@melted
def agrees(tx: float, ty: float, nx: float, ny: float, least: float) -> bool:
    """Whether the cosine between a direction t and a unit normal n (or zero) is `least` > 0 or more."""
    along = tx * nx + ty * ny
    return (along > 0) & (along * along >= least * least * max(tx * tx + ty * ty, 1e-24))


@melted
def look_up(
    nearest: Any, width: int, top: int, height: int, edge: Any, x: Any, y: Any, index: Any, off: Any
) -> None:  # fmt: skip
    """Fill the contour points nearest to points, how far these are off, and the normals there.

    :param x, y: (n,) with the atlas' origin. :param index: (n,). :param off: (4, n) off x, off y, normals' x and y.
    """
    off_x, off_y, nx, ny = off[0], off[1], off[2], off[3]
    for i in range(len(x)):
        index[i] = nearest_at(nearest, width, top, height, x[i], y[i])
    for i in range(len(x)):
        at = np.uint32(index[i])
        off_x[i], off_y[i], nx[i], ny[i] = x[i] - edge[at, 0], y[i] - edge[at, 1], edge[at, 2], edge[at, 3]


@melted
def _place(px: Any, py: Any, tx: float, ty: float, zx: float, zy: float, x: Any, y: Any) -> None:
    for i in range(len(px)):
        x[i], y[i] = tx + zx * px[i] - zy * py[i], ty + zy * px[i] + zx * py[i]


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


@melted
def _weight(off_x: float, off_y: float, nx: float, ny: float, gate: float) -> float:
    """Tukey's weight of a point that lies `off` from its nearest contour point; 0 beyond twice the gate."""
    far = (nx * off_x + ny * off_y) / gate
    near = off_x * off_x + off_y * off_y < 4 * gate * gate
    return max(1 - far * far, 0.0) ** 2 if near else 0.0


@melted
def _similarity_sums(
    px: Any, py: Any, pnx: Any, pny: Any, off: Any, zx: float, zy: float, gate: float, agreement: float
) -> Any:
    """The lower half of J' W J by rows, then J' W r, for (x, y, Re z, Im z)."""
    all_x, all_y, all_nx, all_ny = off[0], off[1], off[2], off[3]
    a00 = a10 = a11 = a20 = a21 = a22 = a30 = a31 = a32 = a33 = b0 = b1 = b2 = b3 = 0.0
    for i in range(len(px)):
        x, y, off_x, off_y, nx, ny = px[i], py[i], all_x[i], all_y[i], all_nx[i], all_ny[i]
        along_x, along_y = zx * pnx[i] - zy * pny[i], zy * pnx[i] + zx * pny[i]
        weight = _weight(off_x, off_y, nx, ny, gate) if agrees(along_x, along_y, nx, ny, agreement) else 0.0
        along, across = nx * x + ny * y, ny * x - nx * y
        wx, wy, wa, wc = weight * nx, weight * ny, weight * along, weight * across
        residual = nx * off_x + ny * off_y
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
        b0 += wx * residual
        b1 += wy * residual
        b2 += wa * residual
        b3 += wc * residual
    return (a00, a10, a11, a20, a21, a22, a30, a31, a32, a33), (b0, b1, b2, b3)


@melted
def _solve_similarity(a: Any, b: Any, damping: float) -> Any:
    """(x, y, Re z, Im z) that solve (A + damping) x = -b, by L D L'. :param a, b: as `_similarity_sums` gives them."""
    a00, a10, a11, a20, a21, a22, a30, a31, a32, a33 = a
    d0 = a00 + damping
    l10, l20, l30 = a10 / d0, a20 / d0, a30 / d0
    d1 = a11 + damping - l10 * a10
    a21, a31 = a21 - l20 * a10, a31 - l30 * a10
    l21, l31 = a21 / d1, a31 / d1
    d2 = a22 + damping - l20 * a20 - l21 * a21
    a32 = a32 - l30 * a20 - l31 * a21
    l32 = a32 / d2
    d3 = a33 + damping - l30 * a30 - l31 * a31 - l32 * a32
    y0 = -b[0]
    y1 = -b[1] - l10 * y0
    y2 = -b[2] - l20 * y0 - l21 * y1
    x3 = (-b[3] - l30 * y0 - l31 * y1 - l32 * y2) / d3
    x2 = y2 / d2 - l32 * x3
    x1 = y1 / d1 - l21 * x2 - l31 * x3
    return y0 / d0 - l10 * x1 - l20 * x2 - l30 * x3, x1, x2, x3


@jit
def _affine_step(
    nearest: Any, width: int, top: int, height: int, edge: Any, px: Any, py: Any, pnx: Any, pny: Any, t: complex,
    z: complex, w: complex, gate: float, agreement: float, damping: float, A: Any, b: Any,
) -> None:  # fmt: skip
    """b becomes the changes of (x, y, Re z, Im z, Re w, Im w)."""
    A[:], b[:] = 0.0, 0.0
    row = np.empty(6)
    for i in range(len(px)):
        p, outward = complex(px[i], py[i]), complex(pnx[i], pny[i])
        where, turned = t + z * p + w * np.conj(p), z * outward - w * np.conj(outward)
        at = nearest_at(nearest, width, top, height, where.real, where.imag)
        normal, off = complex(edge[at, 2], edge[at, 3]), where - complex(edge[at, 0], edge[at, 1])
        weight = _weight(off.real, off.imag, normal.real, normal.imag, gate)
        if weight == 0.0 or not agrees(turned.real, turned.imag, normal.real, normal.imag, agreement):
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
def move_onto_contours(
    contours: Any, shapes: Any, t: Any, z: Any, w: Any, shape: Any, slot: Any, gates: Any, step: int, agreement: float,
    damping: float, squeeze: float, most: float,
) -> Any:  # fmt: skip
    """(t, z, w) refined; `squeeze`: greatest |w| / |z|, 0 for similarities alone; `most`: greatest change of scale."""
    new_t, new_z, new_w = t.copy(), z.copy(), w.copy()
    nearest, width, height = contours.nearest.ravel(), contours.nearest.shape[1], contours.height
    origin = complex(contours.left, contours.top)
    edge = contours.edge
    # points every `step`-th, in units of the shape's radius
    unit = shapes.radius.reshape(-1, 1)
    all_x, all_y = shapes.x[:, ::step] / unit, shapes.y[:, ::step] / unit
    all_nx, all_ny = shapes.normals.real[:, ::step].copy(), shapes.normals.imag[:, ::step].copy()
    damping *= all_x.shape[1]
    A, b, x, y = np.empty((6, 6)), np.empty(6), np.empty(all_x.shape[1]), np.empty(all_x.shape[1])
    index, off = np.empty(len(x), np.int32), np.empty((4, len(x)))
    for h in range(len(t)):
        s, top = shape[h], slot[h] * height
        px, py, pnx, pny, r = all_x[s], all_y[s], all_nx[s], all_ny[s], shapes.radius[s]
        th, zh, wh = t[h] - origin, z[h] * r, w[h] * r
        start = abs(zh) + abs(wh)
        for gate in gates:
            limit = min(gate, max(1.5, 0.5 * abs(zh)))
            if squeeze > 0:
                _affine_step(nearest, width, top, height, edge, px, py, pnx, pny, th, zh, wh, limit, agreement,
                             damping, A, b)  # fmt: skip
            else:
                _place(px, py, th.real, th.imag, zh.real, zh.imag, x, y)
                look_up(nearest, width, top, height, edge, x, y, index, off)
                JWJ, JWr = _similarity_sums(px, py, pnx, pny, off, zh.real, zh.imag, limit, agreement)
                b[0], b[1], b[2], b[3] = _solve_similarity(JWJ, JWr, damping)
            th += complex(b[0], b[1])
            zh += complex(b[2], b[3])
            if squeeze > 0:
                wh += complex(b[4], b[5])
                wh *= min(1.0, squeeze * abs(zh) / max(abs(wh), 1e-12))
        ratio = (abs(zh) + abs(wh)) / start
        if 1 / most < ratio < most:
            new_t[h], new_z[h], new_w[h] = th + origin, zh / r, wh / r
    return new_t, new_z, new_w
