"""Least squares on contour distances, a hypothesis and a point at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .geometry import View, outline_pixels, padded_pixel, turned
from .jit import inlined, jit, lean
from .scoring import Surface, aspect


class EdgeTerms(NamedTuple):
    """The constants of `posefit.find_edges`, and what it is told of each of the steps of a fit."""

    reach: Any  # (steps,)
    step_in: float  # factors on the likelihood of a boundary one place further out, by the label passed
    step_seam: float
    step_out: float
    prior: Any  # (steps, n) of each place, the first 2 reach + 2 count
    seam_px: Any  # (M,) half the seam of each marker's class
    unknown: Any  # (256,) bool: labels that say nothing
    outside: int


@inlined
def find_edge(
    u: float, v: float, nu: float, nv: float, label: int, seam_px: float, e: EdgeTerms, step: int, view: View, seen: Any
) -> tuple[float, float]:
    """`posefit.find_edges` at one contour point: signed distance of the edge and its weight."""
    if not abs(u) + abs(v) < 1e9:  # a pose that is no number has no edge anywhere
        return 0.0, 0.0
    reach, prior = e.reach[step], e.prior[step]
    n = 2 * reach + 1
    inner, outer, last_known = False, False, -1
    for i in range(n):
        at = i - reach
        seen[i] = view.padded[padded_pixel(u + at * nu, v + at * nv, view)]
        own = seen[i] == label
        if own and i < reach:
            inner = True
        if not own and i >= reach:
            outer = True
        if not own and not e.unknown[seen[i]]:
            last_known = i
    if not (inner and outer):
        return 0.0, 0.0
    likelihood, total, mean, square, first, last = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ends_unknown, has_seam = False, False
    for i in range(n + 1):
        p = likelihood * prior[i]
        place = i - reach - 0.5
        total += p
        mean += p * place
        square += p * place * place
        if i == 0:
            first = p
        last = p
        if i == n:
            break
        if seen[i] == label:
            likelihood *= e.step_in
        elif e.unknown[seen[i]] and i < last_known:
            likelihood *= e.step_seam
            has_seam = True
        else:
            likelihood *= e.step_out
        if i > reach and e.unknown[seen[i]]:
            ends_unknown = True
    if (first + last) / total >= 0.3:
        return 0.0, 0.0
    mean /= total
    variance = square / total - mean * mean
    if ends_unknown and not has_seam:
        mean += seam_px
    s = mean + 1.2
    if view.padded[padded_pixel(u + s * nu, v + s * nv, view)] == e.outside:
        return 0.0, 0.0  # not the marker ends there but the image
    return mean, 1.0 / (1.0 + variance)


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
def fill_row(
    x: float, y: float, z: float, nu: float, nv: float, motion: Motion, columns: Any, n: int, view: View, row: Any
) -> None:
    """Derivatives row[:n] of a residual by the parameters `columns[:n]`: a point at x, y, z, its normal nu, nv in the
    image."""
    depth = max(z, 1e-3)
    gx, gy = nu * view.K[0, 0] / depth, nv * view.K[1, 1] / depth
    gz = -(gx * x + gy * y) / depth
    ax, ay, az = x - motion.t[0], y - motion.t[1], z - motion.t[2]
    row[0], row[1], row[2] = gx, gy, gz
    row[3], row[4], row[5] = ay * gz - az * gy, az * gx - ax * gz, ax * gy - ay * gx
    for i in range(6, n):
        j = columns[i] - 6
        dx, dy, dz = motion.axis[j, 0], motion.axis[j, 1], motion.axis[j, 2]
        if motion.revolute[j]:
            rx, ry, rz = x - motion.origin[j, 0], y - motion.origin[j, 1], z - motion.origin[j, 2]
            dx, dy, dz = dy * rz - dz * ry, dz * rx - dx * rz, dx * ry - dy * rx
        row[i] = gx * dx + gy * dy + gz * dz


@lean
def normal_equations(
    s: Surface, markers: Any, use: Any, R: Any, t: Any, motion: Motion, e: EdgeTerms, step: int, view: View,
    least_cosine: float, A: Any, b: Any, row: Any, columns: Any, seen: Any, outline: Any,
) -> None:  # fmt: skip
    """Fill A (6 + J, 6 + J), b (6 + J,) of one hypothesis as `posefit._normal_equations` does.

    :param markers: (M,) their patches; use: (M,) bool; R, t: (C, ...) frames.
    :param row, columns, seen, outline: scratch, (6 + J,), int64 (6 + J,) and (2 max reach + 1,), and (4, m).
    """
    n_par = len(b)
    A[:], b[:] = 0.0, 0.0
    for k in range(len(markers)):
        if not use[k]:
            continue
        p = markers[k]
        c = s.component[p]
        P, q = R[c], t[c]
        cosine, _, _, _ = aspect(s, p, P, q)
        if not cosine > least_cosine:
            continue
        n = moving(c, motion, columns)
        outline_pixels(P, q, s.contour[k], s.contour_normal[k], view, outline)
        for i in range(s.contour.shape[2]):
            u, v, nu, nv = outline[0, i], outline[1, i], outline[2, i], outline[3, i]
            edge, w = find_edge(u, v, nu, nv, s.label[p], e.seam_px[k], e, step, view, seen)
            if w == 0.0:
                continue
            x, y, z = turned(P, s.contour[k, :, i])
            fill_row(x + q[0], y + q[1], z + q[2], nu, nv, motion, columns, n, view, row)
            for a in range(n):
                wa, into = w * row[a], columns[a]
                b[into] -= wa * edge
                for g in range(a + 1):
                    A[into, columns[g]] += wa * row[g]
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
    outline = np.empty((4, m))
    seen, row, columns = np.empty(2 * e.reach[0] + 1, np.int64), np.empty(n_par), np.empty(n_par, np.int64)
    jacobian[:] = 0.0
    for k in range(len(markers)):
        p = markers[k]
        c = s.component[p]
        P, q = R[c], t[c]
        n = moving(c, motion, columns)
        cosine, _, _, _ = aspect(s, p, P, q)
        outline_pixels(P, q, s.contour[k], s.contour_normal[k], view, outline)
        spacing_px[k] = 0.0
        for i in range(m):
            u, v, nu, nv = outline[0, i], outline[1, i], outline[2, i], outline[3, i]
            spacing_px[k] += math.hypot(outline[0, i - 1] - u, outline[1, i - 1] - v) / m
            edge, w = find_edge(u, v, nu, nv, s.label[p], e.seam_px[k], e, 0, view, seen)
            x, y, z = turned(P, s.contour[k, :, i])
            fill_row(x + q[0], y + q[1], z + q[2], nu, nv, motion, columns, n, view, row)
            for a in range(n):
                jacobian[k, i, columns[a]] = row[a]
            normal[k, i, 0], normal[k, i, 1] = nu, nv
            residual[k, i] = -edge
            weight[k, i] = w if use[k] and cosine > least_cosine else 0.0
