"""Least squares on contour distances, a hypothesis and a contour at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import inlined, jit, lean
from ..geometry.pixel_kernels import View, outline_pixels
from .edge_kernels import EdgeRoom, EdgeTerms, edge_room, find_edges
from .surface_kernels import Surface, aspect


class Motion(NamedTuple):
    """How a placed object's points move with its parameters."""

    t: Any  # (3,) the object's place, about which it turns
    axis: Any  # (J, 3) of joints
    origin: Any  # (J, 3)
    revolute: Any  # (J,) bool
    moves: Any  # (C, J) bool


@inlined
def moving(c: int, motion: Motion, columns: Any) -> int:
    """Fill `columns` with the parameters that move component `c`, and say how many: the pose's six, and its joints."""
    n = 6
    for i in range(6):
        columns[i] = i
    for j in range(motion.moves.shape[1]):
        if motion.moves[c, j]:
            columns[n] = 6 + j
            n += 1
    return n


@inlined
def fill_rows(
    s: Surface, k: int, P: Any, q: Any, motion: Motion, columns: Any, n: int, view: View, outline: Any, rows: Any
) -> None:
    """Derivatives rows[:n] (n, m) of the residuals of marker `k`'s points by the parameters `columns[:n]`.

    :param P, q: the component's frame; outline: normals in the image in its last two rows.
    """
    on, nus, nvs, K = s.contour[k], outline[2], outline[3], view.K
    gxs, gys, gzs, r3, r4, r5 = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]
    xs, ys, zs = rows[n], rows[n + 1], rows[n + 2]
    for i in range(len(nus)):
        x = P[0, 0] * on[0, i] + P[0, 1] * on[1, i] + P[0, 2] * on[2, i] + q[0]
        y = P[1, 0] * on[0, i] + P[1, 1] * on[1, i] + P[1, 2] * on[2, i] + q[1]
        z = P[2, 0] * on[0, i] + P[2, 1] * on[1, i] + P[2, 2] * on[2, i] + q[2]
        near = 1.0 / max(z, 1e-3)
        gx, gy = nus[i] * K[0, 0] * near, nvs[i] * K[1, 1] * near
        gz = -(gx * x + gy * y) * near
        ax, ay, az = x - motion.t[0], y - motion.t[1], z - motion.t[2]
        gxs[i], gys[i], gzs[i] = gx, gy, gz
        r3[i], r4[i], r5[i] = ay * gz - az * gy, az * gx - ax * gz, ax * gy - ay * gx
        xs[i], ys[i], zs[i] = x, y, z
    for c in range(6, n):
        j, row = columns[c] - 6, rows[c]
        dx, dy, dz = motion.axis[j, 0], motion.axis[j, 1], motion.axis[j, 2]
        ox, oy, oz = motion.origin[j, 0], motion.origin[j, 1], motion.origin[j, 2]
        if motion.revolute[j]:
            for i in range(len(nus)):
                rx, ry, rz = xs[i] - ox, ys[i] - oy, zs[i] - oz
                row[i] = gxs[i] * (dy * rz - dz * ry) + gys[i] * (dz * rx - dx * rz) + gzs[i] * (dx * ry - dy * rx)
        else:
            for i in range(len(nus)):
                row[i] = gxs[i] * dx + gys[i] * dy + gzs[i] * dz


@lean
def normal_equations(
    s: Surface, markers: Any, use: Any, R: Any, t: Any, motion: Motion, e: EdgeTerms, step: int, view: View,
    least_cosine: float, A: Any, b: Any, columns: Any, room: EdgeRoom,
) -> None:  # fmt: skip
    """Fill A (6 + J, 6 + J), b (6 + J,) of one hypothesis: weighted sums over the points of all its markers in use.

    :param markers: (M,) their patches; use: (M,) bool; R, t: (C, ...) frames.
    :param columns: int64 scratch, (6 + J,).
    """
    n_par, weighed, weight, edge = len(b), room.sums[5], room.weight, room.edge
    A[:], b[:] = 0.0, 0.0
    for k in range(len(markers)):
        if not use[k]:
            continue
        p = markers[k]
        P, q = R[s.component[p]], t[s.component[p]]
        cosine, _, _, _ = aspect(s, p, P, q)
        if not cosine > least_cosine:  # nor is it where the pose is no number: sums below take all points
            continue
        n = moving(s.component[p], motion, columns)
        outline_pixels(P, q, s.contour[k], s.contour_along[k], view, room.outline)
        find_edges(k, e, step, view, room)
        fill_rows(s, k, P, q, motion, columns, n, view, room.outline, room.rows)
        for a in range(n):
            row, into, pull = room.rows[a], columns[a], 0.0
            for i in range(len(weight)):
                weighed[i] = weight[i] * row[i]
                pull += weighed[i] * edge[i]
            b[into] -= pull
            for g in range(a + 1):
                other, total = room.rows[g], 0.0
                for i in range(len(weight)):
                    total += weighed[i] * other[i]
                A[into, columns[g]] += total
    for a in range(n_par):
        for g in range(a):
            A[g, a] = A[a, g]


@jit
def contour_rows(
    s: Surface, markers: Any, use: Any, R: Any, t: Any, motion: Motion, e: EdgeTerms, view: View, least_cosine: float,
    normal: Any, spacing_px: Any, residual: Any, weight: Any, jacobian: Any,
) -> None:  # fmt: skip
    """Fill what `posefit.contour_fit` tells of one hypothesis: the fields of `posefit.ContourFit`."""
    n_par, m = jacobian.shape[2], s.contour.shape[2]
    room, columns = edge_room(m, e.reach[0], n_par), np.empty(n_par, np.int64)
    outline = room.outline
    jacobian[:] = 0.0
    for k in range(len(markers)):
        p = markers[k]
        P, q = R[s.component[p]], t[s.component[p]]
        n = moving(s.component[p], motion, columns)
        cosine, _, _, _ = aspect(s, p, P, q)
        outline_pixels(P, q, s.contour[k], s.contour_along[k], view, outline)
        find_edges(k, e, 0, view, room)
        fill_rows(s, k, P, q, motion, columns, n, view, outline, room.rows)
        spacing_px[k] = 0.0
        for i in range(m):
            spacing_px[k] += math.hypot(outline[0, i - 1] - outline[0, i], outline[1, i - 1] - outline[1, i]) / m
            for a in range(n):
                jacobian[k, i, columns[a]] = room.rows[a, i]
            normal[k, i, 0], normal[k, i, 1] = outline[2, i], outline[3, i]
            residual[k, i] = -room.edge[i]
            weight[k, i] = room.weight[i] if use[k] and cosine > least_cosine else 0.0
