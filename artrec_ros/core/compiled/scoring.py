"""Votes of the label image for a surface under many hypotheses."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .chains import Chain, place_all
from .geometry import View, locate, outline_pixels, padded_pixel, turned
from .jit import inlined, jit, lean


class Surface(NamedTuple):
    """P patches and B boxes of a spatial model as arrays.

    Patch p owns the points from starts[p] to starts[p + 1], of which the first count[p] count; the others fill up a
    vector instruction.
    """

    component: Any  # (P,)
    normal: Any  # (P, 3)
    centre: Any  # (P, 3)
    area: Any  # (P,)
    radius: Any  # (P,) of a ball about the centre that holds the patch
    label: Any  # (P,)
    marker_of: Any  # (P,) index into the markers' contours, -1: a face
    ignored: Any  # (P, B) bool: boxes that the patch lies on
    starts: Any  # (P + 1,) multiples of LANES
    count: Any  # (P,)
    points: Any  # (3, n)
    role: Any  # (P,)
    contour: Any  # (M, 3, m)
    contour_normal: Any  # (M, 3, m)
    perimeter: Any  # (M,)
    ring_role: Any  # (M,)
    rim_role: Any  # (M,)
    table: Any  # (roles, 256) votes
    best: Any  # (roles,) the greatest vote of each
    box_component: Any  # (B,)
    box_rotation: Any  # (B, 3, 3)
    box_t: Any  # (B, 3)
    half: Any  # (B, 3)
    box_radius: Any  # (B,) of a ball that holds the box


class Limits(NamedTuple):
    """The constants of `spatial.py`, so that they stand in one place."""

    least_cosine: float
    ring_px: float
    ring_width_px: float
    behind: float  # share of the way to a point beyond which nothing hides it
    outside: int  # the label beyond the image


@inlined
def points_of(s: Surface, p: int) -> tuple[Any, Any, Any]:
    """x, y and z of a patch's points, LANES or a multiple: slices of their own, over which loops become vector
    instructions."""
    first, last = s.starts[p], s.starts[p + 1]
    return s.points[0, first:last], s.points[1, first:last], s.points[2, first:last]


@inlined
def in_box(B: Any, i: int, A: Any, b: Any) -> tuple[float, float, float, float]:
    """Row `i` of a component's frame A, b as a box sees it whose axes are the columns of B."""
    return (
        B[0, i] * A[0, 0] + B[1, i] * A[1, 0] + B[2, i] * A[2, 0],
        B[0, i] * A[0, 1] + B[1, i] * A[1, 1] + B[2, i] * A[2, 1],
        B[0, i] * A[0, 2] + B[1, i] * A[1, 2] + B[2, i] * A[2, 2],
        B[0, i] * b[0] + B[1, i] * b[1] + B[2, i] * b[2],
    )


@inlined
def hide(s: Surface, A: Any, b: Any, on: Any, room: Room, n_near: int, end: float) -> None:
    """Fill `room.hidden` with whether one of the first `n_near` boxes of `room.near` hides a point (slab test).

    :param on: x, y and z of points on the component whose frame is A, b.
    """
    out, (xs, ys, zs) = room.hidden, on
    out[: len(xs)] = False
    for n in range(n_near):
        k = room.near[n]
        B, E, half = room.box_rotation[k], room.eye[k], s.half[k]
        # rays in the box's frame; scalars, for an array here would cost as much as the points do
        x0, x1, x2, x3 = in_box(B, 0, A, b)
        y0, y1, y2, y3 = in_box(B, 1, A, b)
        z0, z1, z2, z3 = in_box(B, 2, A, b)
        l0, l1, l2 = -half[0] - E[0], -half[1] - E[1], -half[2] - E[2]
        h0, h1, h2 = half[0] - E[0], half[1] - E[1], half[2] - E[2]
        for i in range(len(xs)):
            x, y, z = xs[i], ys[i], zs[i]
            r0, r1, r2 = (
                x0 * x + x1 * y + x2 * z + x3,
                y0 * x + y1 * y + y2 * z + y3,
                z0 * x + z1 * y + z2 * z + z3,
            )
            r0 = 1.0 / (r0 if abs(r0) > 1e-9 else 1e-9)
            r1 = 1.0 / (r1 if abs(r1) > 1e-9 else 1e-9)
            r2 = 1.0 / (r2 if abs(r2) > 1e-9 else 1e-9)
            a0, c0, a1, c1, a2, c2 = l0 * r0, h0 * r0, l1 * r1, h1 * r1, l2 * r2, h2 * r2
            enter = max(max(min(a0, c0), min(a1, c1)), max(min(a2, c2), 0.0))
            leave = min(min(max(a0, c0), max(a1, c1)), min(max(a2, c2), end))
            out[i] |= enter < leave


@inlined
def boxes_in_camera(s: Surface, R: Any, t: Any, box_R: Any, eye: Any, middle: Any) -> None:
    """Rotations (B, 3, 3) of one hypothesis' boxes, the camera's centre in their frames, and their middles."""
    for b in range(len(s.half)):
        A, c = R[s.box_component[b]], t[s.box_component[b]]
        for i in range(3):
            middle[b, i] = c[i]
            for j in range(3):
                middle[b, i] += A[i, j] * s.box_t[b, j]
                box_R[b, i, j] = (
                    A[i, 0] * s.box_rotation[b, 0, j]
                    + A[i, 1] * s.box_rotation[b, 1, j]
                    + A[i, 2] * s.box_rotation[b, 2, j]
                )
        for i in range(3):
            eye[b, i] = -(box_R[b, 0, i] * middle[b, 0] + box_R[b, 1, i] * middle[b, 1] + box_R[b, 2, i] * middle[b, 2])


@inlined
def boxes_in_front(s: Surface, p: int, normal: Any, centre: Any, room: Room) -> int:
    """Fill `room.near` with the boxes that may hide a patch, whose normal and centre in the camera are given."""
    nx, ny, nz = normal
    cx, cy, cz = centre
    inverse = 1.0 / (cx * cx + cy * cy + cz * cz)
    n = 0
    for k in range(len(s.half)):
        if s.ignored[p, k]:
            continue
        B, E, half, m = room.box_rotation[k], room.eye[k], s.half[k], room.middle[k]
        above = nx * (m[0] - cx) + ny * (m[1] - cy) + nz * (m[2] - cz)
        for i in range(3):
            above += half[i] * abs(nx * B[0, i] + ny * B[1, i] + nz * B[2, i])
        if not above > 0.0:  # wholly behind the patch's plane
            continue
        # a box grown by the patch's radius reaches out at most that much times the square root of three
        along, reach = m[0] * cx + m[1] * cy + m[2] * cz, s.box_radius[k] + 2.0 * s.radius[p]
        if m[0] * m[0] + m[1] * m[1] + m[2] * m[2] - along * along * inverse > reach * reach:  # beside its cone
            continue
        enter, leave = 0.0, 1.0
        for i in range(3):
            # the ray to the centre, in the box's frame, and the box grown by the patch's radius
            ray = B[0, i] * cx + B[1, i] * cy + B[2, i] * cz
            ray = 1.0 / (ray if abs(ray) > 1e-9 else 1e-9)
            grown = half[i] + s.radius[p]
            low, high = (-grown - E[i]) * ray, (grown - E[i]) * ray
            enter, leave = max(enter, min(low, high)), min(leave, max(low, high))
        if enter <= leave:
            room.near[n] = k
            n += 1
    return n


@inlined
def ring_votes(s: Surface, k: int, A: Any, b: Any, view: View, limits: Limits, room: Room) -> float:
    """Mean vote of what lies just inside and just outside the contour of marker `k`."""
    outline_pixels(A, b, s.contour[k], s.contour_normal[k], view, room.outline)
    u, v, nu, nv = room.outline[0], room.outline[1], room.outline[2], room.outline[3]
    outer, inner, ring_px = room.at[0], room.at[1], limits.ring_px
    out, into = s.table[s.ring_role[k]], s.table[s.rim_role[k]]
    m, ring = len(u), 0.0
    for i in range(m):
        outer[i] = padded_pixel(u[i] + ring_px * nu[i], v[i] + ring_px * nv[i], view)
        inner[i] = padded_pixel(u[i] - ring_px * nu[i], v[i] - ring_px * nv[i], view)
    for i in range(m):
        beyond = view.padded[outer[i]]
        if beyond != limits.outside:  # else not the marker ends there but the image
            ring += out[beyond] + into[view.padded[inner[i]]]
    return ring / m


class Room(NamedTuple):
    """Scratch arrays of one hypothesis."""

    at: Any  # (2, n) pixels of a patch
    outline: Any  # (4, m), see `outline_pixels`
    hidden: Any  # (n,)
    near: Any  # (B,)
    box_rotation: Any  # (B, 3, 3)
    eye: Any  # (B, 3)
    middle: Any  # (B, 3)


@jit
def room_of(s: Surface) -> Room:
    """Scratch arrays that fit a surface."""
    n, m, most = len(s.half), s.contour.shape[2], np.diff(s.starts).max()
    return Room(
        np.empty((2, max(m, most)), np.int32), np.empty((4, m)), np.empty(most, np.bool_), np.empty(n, np.int64),
        np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((n, 3)),
    )  # fmt: skip


@inlined
def aspect(s: Surface, p: int, A: Any, b: Any) -> tuple[float, float, float, float]:
    """Cosine of the viewing angle of a patch, and its centre in the camera."""
    nx, ny, nz = turned(A, s.normal[p])
    mx, my, mz = turned(A, s.centre[p])
    mx, my, mz = mx + b[0], my + b[1], mz + b[2]
    cosine = -(nx * mx + ny * my + nz * mz) / max(math.sqrt(mx * mx + my * my + mz * mz), 1e-9)
    return cosine, mx, my, mz


@jit
def score_patches(
    s: Surface, chain: Chain, R: Any, t: Any, q: Any, patches: Any, view: View, limits: Limits, occlusion: bool,
    votes: Any, area_px: Any, agree: Any,
) -> None:  # fmt: skip
    """Fill votes, area_px, agree (H, P) of hypotheses R (H, 3, 3), t (H, 3), q (H, J) as `SpatialModel.score` does."""
    room, scratch, n_c = room_of(s), np.empty((4, 3, 3)), len(chain.parent)
    frames_R, frames_t = np.empty((n_c, 3, 3)), np.empty((n_c, 3))
    for h in range(len(R)):
        place_all(chain, R[h], t[h], q[h], frames_R, frames_t, scratch)
        score_hypothesis(
            s, frames_R, frames_t, patches, view, limits, occlusion, room, votes[h], area_px[h], agree[h]
        )


@lean
def score_hypothesis(
    s: Surface, R: Any, t: Any, patches: Any, view: View, limits: Limits, occlusion: bool, room: Room,
    votes: Any, area_px: Any, agree: Any,
) -> None:  # fmt: skip
    """The same for one hypothesis: (C, 3, 3), (C, 3), and (P,) each to fill."""
    blocked = occlusion and len(s.half) > 0
    f2 = view.K[0, 0] * view.K[1, 1]
    if blocked:
        boxes_in_camera(s, R, t, room.box_rotation, room.eye, room.middle)
    for column in range(len(patches)):
        p = patches[column]
        A, b = R[s.component[p]], t[s.component[p]]
        cosine, mx, my, mz = aspect(s, p, A, b)
        votes[column] = area_px[column] = agree[column] = 0.0
        if not (cosine > limits.least_cosine and mz > 0.02):
            continue
        n_near = boxes_in_front(s, p, turned(A, s.normal[p]), (mx, my, mz), room) if blocked else 0
        total, seen, same, role = 0.0, 0, 0, s.table[s.role[p]]
        on, count = points_of(s, p), s.count[p]
        locate(A, b, on, view, room.at[0])
        if n_near:
            hide(s, A, b, on, room, n_near, limits.behind)
        for i in range(count):
            if n_near and room.hidden[i]:
                continue
            seen += 1
            found = view.padded[room.at[0, i]]
            total += role[found]
            same += found == s.label[p]
        size, visible = s.area[p] * f2 / mz**2 * cosine, seen / count
        value, k = total / count * size, s.marker_of[p]
        if k >= 0 and visible > 0.5:
            value += ring_votes(s, k, A, b, view, limits, room) * ring_px2(s, k, cosine, mz, f2, limits)
        votes[column] = value
        area_px[column] = size * visible
        agree[column] = same / max(visible * count, 1.0)


@inlined
def ring_px2(s: Surface, k: int, cosine: float, depth: float, f2: float, limits: Limits) -> float:
    """Pixels that a marker's ring stands for."""
    return s.perimeter[k] * (1 + min(cosine, 1.0)) / 2 * math.sqrt(f2) / depth * limits.ring_width_px
