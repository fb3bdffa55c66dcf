"""The term of a fit that pulls markers' contours to the edges of their classes.

A contour point's residual is its distance along its normal to the edge of its class there (point to line); a point with
no edge in reach, hidden or merged, has no say. Nor has one at which another side of its class begins that is in view,
too, nor one that the object itself hides, where that is asked for: the edge beside it is that of what hides it, and
lies inwards.

All edges together may lie outwards of where the object ends, or inwards: segmenters leave seams or fringes, ink runs,
lenses blur. How large markers look then tells nothing of the range, but how far apart they are does.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted
from ..geometry.pixel_kernels import LabelView, outline_pixels
from ..model.chain_kernels import Chain, place_seen
from .edge_kernels import EdgeRoom, EdgeTerms, edge_room, find_edges
from .hiding_kernels import boxes_in_camera, shown_contour
from .placed_kernels import Equations, Joints, Placed, moving
from .surface_kernels import Surface, aspect, find_inner, is_turned_here, room_of


class ContourTerm(NamedTuple):
    """Markers of a surface in one view."""

    surface: Surface
    markers: Any  # (M,) their patches
    use: Any  # (H, M) bool: which markers have a say under each hypothesis
    edges: EdgeTerms
    seen: LabelView
    least_cosine: float  # a marker seen flatter has no say
    shown: Any  # (H, M, m) bool: points that the object does not hide; m is 0 where none is asked about
    at_edges: Any  # (H,) weight with which all edges together are where the object ends; inf: they are


@melted
def lever_of_ball(radius: float, t: Any, rows: Any, xs: Any, ys: Any, zs: Any) -> None:
    """Of a ball the rim that is seen moves with its centre, however it turns: levers, and derivatives by the turn, of
    its points are those of its centre.

    :param t: (3,) the object's place. :param rows: as of `fill_rows`, translations filled. :param xs, ys, zs: (m,) the
        points, of the disc that faces the camera; afterwards the centre.
    """
    m, x, y, z = len(xs), 0.0, 0.0, 0.0
    for i in range(m):
        x, y, z = x + xs[i] / m, y + ys[i] / m, z + zs[i] / m
    farther = math.sqrt(1.0 + radius * radius / max(x * x + y * y + z * z, 1e-12))  # as of `face_camera`
    x, y, z = farther * x, farther * y, farther * z
    ax, ay, az = x - t[0], y - t[1], z - t[2]
    gxs, gys, gzs, r3, r4, r5 = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]
    for i in range(m):
        gx, gy, gz = gxs[i], gys[i], gzs[i]
        r3[i], r4[i], r5[i] = ay * gz - az * gy, az * gx - ax * gz, ax * gy - ay * gx
        xs[i], ys[i], zs[i] = x, y, z


@melted
def fill_rows(
    s: Surface, k: int, P: Any, q: Any, placed: Placed, columns: Any, n: int, view: LabelView, outline: Any, rows: Any
) -> None:
    """Derivatives rows[:n] (n, m) of the residuals of marker `k`'s points by the parameters `columns[:n]`.

    :param P, q: the component's frame; outline: normals in the image in its last two rows.
    """
    on, nus, nvs = s.contour[k], outline[2], outline[3]
    px, py, pz = on[0], on[1], on[2]
    gxs, gys, gzs, r3, r4, r5 = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]
    xs, ys, zs = rows[n], rows[n + 1], rows[n + 2]
    # numbers of their own: a loop that read them from arrays, which its results might overlie, would be no vector's
    x0, x1, x2, y0, y1, y2 = P[0, 0], P[0, 1], P[0, 2], P[1, 0], P[1, 1], P[1, 2]
    z0, z1, z2, qx, qy, qz = P[2, 0], P[2, 1], P[2, 2], q[0], q[1], q[2]
    fx, fy, tx, ty, tz = view.K[0, 0], view.K[1, 1], placed.t[0], placed.t[1], placed.t[2]
    for i in range(len(nus)):
        x = x0 * px[i] + x1 * py[i] + x2 * pz[i] + qx
        y = y0 * px[i] + y1 * py[i] + y2 * pz[i] + qy
        z = z0 * px[i] + z1 * py[i] + z2 * pz[i] + qz
        near = 1.0 / max(z, 1e-3)
        gx, gy = nus[i] * fx * near, nvs[i] * fy * near
        gz = -(gx * x + gy * y) * near
        ax, ay, az = x - tx, y - ty, z - tz
        gxs[i], gys[i], gzs[i] = gx, gy, gz
        r3[i], r4[i], r5[i] = ay * gz - az * gy, az * gx - ax * gz, ax * gy - ay * gx
        xs[i], ys[i], zs[i] = x, y, z
    if s.bulge[s.patch_of[k]] > 0.0:
        lever_of_ball(s.bulge[s.patch_of[k]], placed.t, rows, xs, ys, zs)
    for c in range(6, n):
        j, row = columns[c] - 6, rows[c]
        dx, dy, dz = placed.axis[j, 0], placed.axis[j, 1], placed.axis[j, 2]
        ox, oy, oz = placed.origin[j, 0], placed.origin[j, 1], placed.origin[j, 2]
        if placed.joints.revolute[j]:
            for i in range(len(nus)):
                rx, ry, rz = xs[i] - ox, ys[i] - oy, zs[i] - oz
                row[i] = gxs[i] * (dy * rz - dz * ry) + gys[i] * (dz * rx - dx * rz) + gzs[i] * (dx * ry - dy * rx)
        else:
            for i in range(len(nus)):
                row[i] = gxs[i] * dx + gys[i] * dy + gzs[i] * dz


@melted
def leave_out_hidden(shown: Any, h: int, k: int, weight: Any) -> None:
    """Take their say from the points of marker `k` of hypothesis `h` that the object hides."""
    for i in range(shown.shape[2]):
        weight[i] = weight[i] if shown[h, k, i] else 0.0


@melted
def leave_out_inner(s: Surface, k: int, P: Any, q: Any, view: LabelView, weight: Any, room: EdgeRoom) -> None:
    """Take their say from the points at which marker `k` goes on in another side of its class, see `find_inner`."""
    if s.has_meets[k]:
        inner = room.flags[0]  # no longer needed: edges are found
        find_inner(s, k, P, q, view, inner)
        for i in range(len(weight)):
            weight[i] = 0.0 if inner[i] else weight[i]


@melted
def add_contours(
    term: ContourTerm, h: int, step: int, placed: Placed, to: Equations, columns: Any, room: EdgeRoom
) -> None:
    """Add the equations of hypothesis `h`, whose edges are looked for within the reach of step `step`.

    :param columns: int64 scratch, (6 + J,).
    """
    s, markers, e, view = term.surface, term.markers, term.edges, term.seen
    A, b, weighed, weight, edge = to.A, to.b, room.sums[5], room.weight, room.edge
    for k in range(len(markers)):
        if not term.use[h, k]:
            continue
        p = markers[k]
        P, q = placed.R[s.component[p]], placed.frame_t[s.component[p]]
        cosine, _, _, depth = aspect(s, p, P, q)
        if not is_turned_here(
            s, p, cosine, depth, view.K[0, 0] * view.K[1, 1], term.least_cosine
        ):  # nor is it where the pose is no number: sums below take all points
            continue
        n = moving(s.component[p], placed, columns)
        outline_pixels(P, q, s.contour[k], s.contour_along[k], view, room.outline)
        find_edges(k, e, step, view, room)
        leave_out_hidden(term.shown, h, k, weight)
        leave_out_inner(s, k, P, q, view, weight, room)
        fill_rows(s, k, P, q, placed, columns, n, view, room.outline, room.rows)
        points, off = 0.0, 0.0
        for i in range(len(weight)):
            points += weight[i]
            off += weight[i] * edge[i]
        to.outwards[len(b)] += points
        to.outwards[len(b) + 1] -= off
        for a in range(n):
            row, into, pull, along = room.rows[a], columns[a], 0.0, 0.0
            for i in range(len(weight)):
                weighed[i] = weight[i] * row[i]
                pull += weighed[i] * edge[i]
                along += weighed[i]
            b[into] -= pull
            to.outwards[into] += along
            for g in range(a + 1):
                other, total = room.rows[g], 0.0
                for i in range(len(weight)):
                    total += weighed[i] * other[i]
                A[into, columns[g]] += total


@melted
def leave_outwards(weight: float, to: Equations) -> None:
    """Leave it to what the other parameters are by how much all edges lie outwards (Schur complement).

    :param weight: with which that is nothing; inf: it is.
    """
    row, n = to.outwards, len(to.b)
    if not math.isinf(weight):
        itself = row[n] + weight
        for i in range(n):
            to.b[i] -= row[i] * row[n + 1] / itself
            for j in range(i + 1):
                to.A[i, j] -= row[i] * row[j] / itself


class ContourFit(NamedTuple):
    """The contours of K markers of H hypotheses against the labels' edges, m points each."""

    point: Any  # (H, K, m, 2) pixels
    normal: Any  # (H, K, m, 2) outward unit normals in the image
    spacing_px: Any  # (H, K) of neighbouring points
    residual: Any  # (H, K, m) signed distance of each point from its edge along its normal, pixels
    weight: Any  # (H, K, m), 0 where the residual says nothing: there is no edge, or the object hides the point
    jacobian: Any  # (H, K, m, 6+J) of the residuals
    shown: Any  # (H, K, m) bool: points of markers that a hypothesis uses which the object does not hide itself


@melted
def marker_rows(
    term: ContourTerm, h: int, k: int, placed: Placed, columns: Any, n: int, edges: EdgeRoom, fit: ContourFit, at: int
) -> None:
    """Fill row `at` of hypothesis `h` with what the term says of marker `k`; which points are shown is known.

    :param columns: the `n` parameters that move it.
    """
    s, outline, spacing_px = term.surface, edges.outline, 0.0
    p = term.markers[k]
    P, q = placed.R[s.component[p]], placed.frame_t[s.component[p]]
    cosine, _, _, depth = aspect(s, p, P, q)
    here = is_turned_here(s, p, cosine, depth, term.seen.K[0, 0] * term.seen.K[1, 1], term.least_cosine)
    outline_pixels(P, q, s.contour[k], s.contour_along[k], term.seen, outline)
    find_edges(k, term.edges, 0, term.seen, edges)
    leave_out_hidden(fit.shown, h, at, edges.weight)
    leave_out_inner(s, k, P, q, term.seen, edges.weight, edges)
    fill_rows(s, k, P, q, placed, columns, n, term.seen, outline, edges.rows)
    m = s.contour.shape[2]
    for i in range(m):
        spacing_px += math.hypot(outline[0, i - 1] - outline[0, i], outline[1, i - 1] - outline[1, i]) / m
        for a in range(n):
            fit.jacobian[h, at, i, columns[a]] = edges.rows[a, i]
        fit.point[h, at, i, 0], fit.point[h, at, i, 1] = outline[0, i], outline[1, i]
        fit.normal[h, at, i, 0], fit.normal[h, at, i, 1] = outline[2, i], outline[3, i]
        fit.residual[h, at, i] = -edges.edge[i]
        fit.weight[h, at, i] = edges.weight[i] if term.use[h, k] and here else 0.0
    fit.spacing_px[h, at] = spacing_px


@jit
def contour_rows(
    term: ContourTerm, which: Any, chain: Chain, joints: Joints, end: float, R: Any, t: Any, q: Any, fit: ContourFit
) -> None:
    """Fill what the term says of markers `which` (K,) of hypotheses R (H, 3, 3), t (H, 3), q (H, J), as they are.

    :param end: as of `shown_contours`. :param fit: jacobian and shown zeros.
    """
    s, n_c, n_j = term.surface, len(chain.parent), q.shape[1]
    edges, columns = edge_room(s.contour.shape[2], term.edges.reach[0], 6 + n_j), np.empty(6 + n_j, np.int64)
    frames_R, frames_t, joint_at = np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((2, n_j, 3))
    room, scratch = room_of(s), np.empty((3, 3, 3))
    for h in range(len(R)):
        place_seen(chain, R[h], t[h], q[h], frames_R, frames_t, joint_at[0], joint_at[1], scratch)
        placed = Placed(t[h], q[h], frames_R, frames_t, joint_at[0], joint_at[1], joints)
        boxes_in_camera(s, frames_R, frames_t, room.box_rotation, room.eye, room.middle)
        for at in range(len(which)):
            k = which[at]
            c = s.component[term.markers[k]]
            if term.use[h, k]:
                shown_contour(s, k, frames_R[c], frames_t[c], end, room, fit.shown[h, at])
            marker_rows(term, h, k, placed, columns, moving(c, placed, columns), edges, fit, at)
