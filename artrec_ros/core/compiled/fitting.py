"""Least squares on contour distances, a hypothesis and a point at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .geometry import View, outline_pixels, padded_pixel
from .jit import inlined, jit, lean
from .scoring import Surface, aspect

OWN, KNOWN, UNKNOWN = 0, 1, 2  # kinds of labels along a marker's normal: its own, another's, one that says nothing


class EdgeTerms(NamedTuple):
    """The constants of `posefit.find_edges`, and what it is told of each of the steps of a fit."""

    reach: Any  # (steps,)
    step_in: float  # factors on the likelihood of a boundary one place further out, by the label passed
    step_seam: float
    step_out: float
    prior: Any  # (steps, n) of each place, the first 2 reach + 2 count
    seam_px: Any  # (M,) half the seam of each marker's class
    kind: Any  # (M, 256) int32, of each label for each marker
    outside: int


class EdgeRoom(NamedTuple):
    """Scratch arrays of the m points of one contour."""

    outline: Any  # (4, m), see `outline_pixels`
    at: Any  # (m,)
    kind: Any  # (2 max reach + 1, m)
    flags: Any  # (5, m)
    sums: Any  # (5, m)
    edge: Any  # (m,) signed distance of the edge along the normal
    weight: Any  # (m,) 0: no edge
    rows: Any  # (9 + J, m)


@jit
def edge_room(m: int, most_reach: int, n_par: int) -> EdgeRoom:
    """Scratch arrays for contours of `m` points that move with `n_par` parameters."""
    return EdgeRoom(
        np.empty((4, m)), np.empty(m, np.int32), np.empty((2 * most_reach + 1, m), np.int32),
        np.empty((5, m), np.int32), np.empty((5, m)), np.empty(m), np.empty(m), np.empty((n_par + 3, m)),
    )  # fmt: skip


@inlined
def look_along(k: int, reach: int, e: EdgeTerms, view: View, room: EdgeRoom) -> None:
    """Fill room.kind with the kinds of the labels along the normals, and room.flags with what they tell together."""
    us, vs, nus, nvs = room.outline[0], room.outline[1], room.outline[2], room.outline[3]
    for i in range(len(us)):
        if not abs(us[i]) + abs(vs[i]) + abs(nus[i]) + abs(nvs[i]) < 1e9:
            us[i], vs[i], nus[i], nvs[i] = -9.0, -9.0, 0.0, 0.0  # a pose that is no number has no edge anywhere
    at, kinds = room.at, e.kind[k]
    inner, outer, last, silent = room.flags[0], room.flags[1], room.flags[2], room.flags[3]
    inner[:], outer[:], last[:], silent[:] = 0, 0, -1, 0
    for n in range(2 * reach + 1):
        off, row = float(n - reach), room.kind[n]
        for i in range(len(us)):
            at[i] = padded_pixel(us[i] + off * nus[i], vs[i] + off * nvs[i], view)
        for i in range(len(us)):
            row[i] = kinds[view.padded[at[i]]]
        for i in range(len(us)):
            last[i] = n if row[i] == KNOWN else last[i]
        if n < reach:
            for i in range(len(us)):
                inner[i] |= row[i] == OWN
        else:
            for i in range(len(us)):
                outer[i] |= row[i] != OWN
        if n > reach:
            for i in range(len(us)):
                silent[i] |= row[i] == UNKNOWN


@inlined
def find_edges(k: int, e: EdgeTerms, step: int, view: View, room: EdgeRoom) -> None:
    """`posefit.find_edges` of marker `k`, whose contour is room.outline: fill room.edge and room.weight."""
    reach, prior = e.reach[step], e.prior[step]
    look_along(k, reach, e, view, room)
    inner, outer, last, silent, seam = room.flags[0], room.flags[1], room.flags[2], room.flags[3], room.flags[4]
    likelihood, total, mean, square, end = room.sums[0], room.sums[1], room.sums[2], room.sums[3], room.sums[4]
    likelihood[:], total[:], mean[:], square[:], seam[:] = 1.0, 0.0, 0.0, 0.0, 0
    m = len(total)
    for n in range(2 * reach + 2):
        place, before = n - reach - 0.5, prior[n]
        for i in range(m):
            p = likelihood[i] * before
            total[i] += p
            mean[i] += p * place
            square[i] += p * place * place
            end[i] = p
        if n == 2 * reach + 1:
            break
        row = room.kind[n]
        for i in range(m):
            in_seam = (row[i] == UNKNOWN) & (n < last[i])
            seam[i] |= in_seam
            likelihood[i] *= e.step_in if row[i] == OWN else (e.step_seam if in_seam else e.step_out)
    for i in range(m):
        room.edge[i] = room.weight[i] = 0.0
        if not (inner[i] and outer[i]) or prior[0] + end[i] >= 0.3 * total[i]:
            continue
        edge = mean[i] / total[i]
        variance = square[i] / total[i] - edge * edge
        if silent[i] and not seam[i]:
            edge += e.seam_px[k]
        u, v, out = room.outline[0, i], room.outline[1, i], edge + 1.2
        if view.padded[padded_pixel(u + out * room.outline[2, i], v + out * room.outline[3, i], view)] == e.outside:
            continue  # not the marker ends there but the image
        room.edge[i], room.weight[i] = edge, 1.0 / (1.0 + variance)


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
                row[i] = (
                    gxs[i] * (dy * rz - dz * ry) + gys[i] * (dz * rx - dx * rz) + gzs[i] * (dx * ry - dy * rx)
                )
        else:
            for i in range(len(nus)):
                row[i] = gxs[i] * dx + gys[i] * dy + gzs[i] * dz


@lean
def normal_equations(
    s: Surface, markers: Any, use: Any, R: Any, t: Any, motion: Motion, e: EdgeTerms, step: int, view: View,
    least_cosine: float, A: Any, b: Any, columns: Any, room: EdgeRoom,
) -> None:  # fmt: skip
    """Fill A (6 + J, 6 + J), b (6 + J,) of one hypothesis as `posefit._normal_equations` does.

    :param markers: (M,) their patches; use: (M,) bool; R, t: (C, ...) frames.
    :param columns: int64 scratch, (6 + J,).
    """
    n_par, weighed, weight, edge = len(b), room.sums[0], room.weight, room.edge
    A[:], b[:] = 0.0, 0.0
    for k in range(len(markers)):
        if not use[k]:
            continue
        p = markers[k]
        P, q = R[s.component[p]], t[s.component[p]]
        cosine, _, _, _ = aspect(s, p, P, q)
        if not cosine > least_cosine:
            continue
        n = moving(s.component[p], motion, columns)
        outline_pixels(P, q, s.contour[k], s.contour_normal[k], view, room.outline)
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
        outline_pixels(P, q, s.contour[k], s.contour_normal[k], view, outline)
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
