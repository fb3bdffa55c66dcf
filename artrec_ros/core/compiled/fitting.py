"""Normal equations of contour distances, a hypothesis and a point at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .geometry import View, contour_pixel, pixel, turned
from .jit import jit
from .scoring import Surface


class EdgeTerms(NamedTuple):
    """The constants of `posefit.find_edges`."""

    reach: int
    step_in: float  # factors on the likelihood of a boundary one place further out, by the label passed
    step_seam: float
    step_out: float
    prior: Any  # (2 reach + 2,) of each place
    seam_px: Any  # (M,) half the seam of each marker's class
    unknown: Any  # (256,) bool: labels that say nothing
    outside: int


@jit
def find_edge(
    u: float, v: float, nu: float, nv: float, label: int, seam_px: float, e: EdgeTerms, view: View, seen: Any
) -> tuple[float, float]:
    """`posefit.find_edges` at one contour point: signed distance of the edge and its weight."""
    n = 2 * e.reach + 1
    inner, outer, last_known = False, False, -1
    for i in range(n):
        step = i - e.reach
        seen[i] = view.padded[pixel(u + step * nu, v + step * nv, view.width, view.height)]
        own = seen[i] == label
        if own and i < e.reach:
            inner = True
        if not own and i >= e.reach:
            outer = True
        if not own and not e.unknown[seen[i]]:
            last_known = i
    if not (inner and outer):
        return 0.0, 0.0
    likelihood, total, mean, square, first, last = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ends_unknown, has_seam = False, False
    for i in range(n + 1):
        p = likelihood * e.prior[i]
        place = i - e.reach - 0.5
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
        if i > e.reach and e.unknown[seen[i]]:
            ends_unknown = True
    if (first + last) / total >= 0.3:
        return 0.0, 0.0
    mean /= total
    variance = square / total - mean * mean
    if ends_unknown and not has_seam:
        mean += seam_px
    s = mean + 1.2
    if view.padded[pixel(u + s * nu, v + s * nv, view.width, view.height)] == e.outside:
        return 0.0, 0.0  # not the marker ends there but the image
    return mean, 1.0 / (1.0 + variance)


@jit
def normal_equations(
    s: Surface, markers: Any, use: Any, R: Any, t: Any, origin_t: Any, axis: Any, origin: Any, revolute: Any,
    moves: Any, e: EdgeTerms, view: View, least_cosine: float, A: Any, b: Any, rms: Any,
) -> None:  # fmt: skip
    """Fill A (H, 6 + J, 6 + J), b (H, 6 + J), rms (H,) as `posefit._normal_equations` does.

    :param markers: (M,) their patches; use: (H, M) bool; origin_t: (H, 3) the object's place.
    :param axis, origin: (H, J, 3) of joints; moves: (C, J).
    """
    n_par, n_joints = A.shape[1], axis.shape[1]
    row, seen = np.empty(n_par), np.empty(2 * e.reach + 1, np.int64)
    for h in range(len(R)):
        total, squares = 0.0, 0.0
        A[h], b[h] = 0.0, 0.0
        for k in range(len(markers)):
            if not use[h, k]:
                continue
            p = markers[k]
            c = s.component[p]
            P, q = R[h, c], t[h, c]
            nx, ny, nz = turned(P, s.normal[p])
            mx, my, mz = turned(P, s.centre[p])
            mx, my, mz = mx + q[0], my + q[1], mz + q[2]
            away = max(math.sqrt(mx * mx + my * my + mz * mz), 1e-9)
            if not -(nx * mx + ny * my + nz * mz) / away > least_cosine:
                continue
            for i in range(s.contour.shape[2]):
                u, v, nu, nv = contour_pixel(P, q, s.contour[k, :, i], s.contour_normal[k, :, i], view)
                edge, w = find_edge(u, v, nu, nv, s.label[p], e.seam_px[k], e, view, seen)
                if w == 0.0:
                    continue
                x, y, z = turned(P, s.contour[k, :, i])
                x, y, z = x + q[0], y + q[1], z + q[2]
                depth = max(z, 1e-3)
                gx, gy = nu * view.K[0, 0] / depth, nv * view.K[1, 1] / depth
                gz = -(gx * x + gy * y) / depth
                ax, ay, az = x - origin_t[h, 0], y - origin_t[h, 1], z - origin_t[h, 2]
                row[0], row[1], row[2] = gx, gy, gz
                row[3], row[4], row[5] = ay * gz - az * gy, az * gx - ax * gz, ax * gy - ay * gx
                for j in range(n_joints):
                    row[6 + j] = 0.0
                    if moves[c, j]:
                        dx, dy, dz = axis[h, j, 0], axis[h, j, 1], axis[h, j, 2]
                        if revolute[j]:
                            rx, ry, rz = x - origin[h, j, 0], y - origin[h, j, 1], z - origin[h, j, 2]
                            dx, dy, dz = dy * rz - dz * ry, dz * rx - dx * rz, dx * ry - dy * rx
                        row[6 + j] = gx * dx + gy * dy + gz * dz
                for a in range(n_par):
                    wa = w * row[a]
                    b[h, a] -= wa * edge
                    for g in range(a + 1):
                        A[h, a, g] += wa * row[g]
                total += w
                squares += w * edge * edge
        for a in range(n_par):
            for g in range(a):
                A[h, g, a] = A[h, a, g]
        rms[h] = math.sqrt(squares / max(total, 1e-9))
