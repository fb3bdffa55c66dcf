"""What boxes hide from the camera, one patch after another."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import jit, melted
from ..geometry.pixel_kernels import turned
from ..model.chain_kernels import Chain, place_seen
from .surface_kernels import Room, Surface, aspect, points_of, room_of, surface_share


@melted
def in_box(B: Any, i: int, A: Any, b: Any) -> tuple[float, float, float, float]:
    """Row `i` of a component's frame A, b as a box sees it whose axes are the columns of B."""
    return (
        B[0, i] * A[0, 0] + B[1, i] * A[1, 0] + B[2, i] * A[2, 0],
        B[0, i] * A[0, 1] + B[1, i] * A[1, 1] + B[2, i] * A[2, 1],
        B[0, i] * A[0, 2] + B[1, i] * A[1, 2] + B[2, i] * A[2, 2],
        B[0, i] * b[0] + B[1, i] * b[1] + B[2, i] * b[2],
    )


@melted
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


@melted
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


@melted
def boxes_in_front(s: Surface, p: int, A: Any, normal: Any, centre: Any, room: Room, which: int) -> int:
    """Fill `room.near` with the boxes that may hide a patch, whose normal and centre in the camera are given.

    :param A: rotation of its component. :param which: bits of boxes, see `bit_of`; others are left out.
    """
    nx, ny, nz = normal
    cx, cy, cz = centre
    ux, uy, uz = turned(A, s.extent[p, 0])
    vx, vy, vz = turned(A, s.extent[p, 1])
    inverse = 1.0 / (cx * cx + cy * cy + cz * cz)
    n = 0
    for k in range(len(s.half)):
        if s.ignored[p, k] or not which & bit_of(k):
            continue
        B, E, half, m = room.box_rotation[k], room.eye[k], s.half[k], room.middle[k]
        # a box grown by the patch's radius reaches out at most that much times the square root of three
        along, reach = m[0] * cx + m[1] * cy + m[2] * cz, s.box_radius[k] + 2.0 * s.radius[p]
        if m[0] * m[0] + m[1] * m[1] + m[2] * m[2] - along * along * inverse > reach * reach:  # beside its cone
            continue
        above = nx * (m[0] - cx) + ny * (m[1] - cy) + nz * (m[2] - cz)
        for i in range(3):
            above += half[i] * abs(nx * B[0, i] + ny * B[1, i] + nz * B[2, i])
        if not above > 0.0:  # wholly behind the patch's plane
            continue
        enter, leave = 0.0, 1.0
        for i in range(3):
            # the ray to the centre, in the box's frame, and the box grown by as far as the patch reaches along its axes
            ray = B[0, i] * cx + B[1, i] * cy + B[2, i] * cz
            ray = 1.0 / (ray if abs(ray) > 1e-9 else 1e-9)
            u, v = B[0, i] * ux + B[1, i] * uy + B[2, i] * uz, B[0, i] * vx + B[1, i] * vy + B[2, i] * vz
            grown = half[i] + abs(u) + abs(v)
            low, high = (-grown - E[i]) * ray, (grown - E[i]) * ray
            enter, leave = max(enter, min(low, high)), min(leave, max(low, high))
        if enter <= leave:
            room.near[n] = k
            n += 1
    return n


@melted
def bit_of(box: int) -> int:
    """A bit for each box; of many boxes several share one."""
    return 1 << (box % 62)


ALL_BOXES = (1 << 62) - 1


@jit
def shown_points(s: Surface, R: Any, t: Any, patches: Any, end: float, out: Any) -> None:
    """Fill out (H, P, n) with which of the first n points of patches no box hides; R (H, C, 3, 3), t (H, C, 3).

    :param patches: (P,) that face the camera: of others a box behind may be left out.
    :param end: share of the way to a point beyond which a box no longer hides it.
    """
    room = room_of(s)
    for h in range(len(R)):
        boxes_in_camera(s, R[h], t[h], room.box_rotation, room.eye, room.middle)
        for column in range(len(patches)):
            p = patches[column]
            A, b = R[h, s.component[p]], t[h, s.component[p]]
            _, mx, my, mz = aspect(s, p, A, b)
            nearer = surface_share(s, p, mz, end)
            n_near = boxes_in_front(s, p, A, turned(A, s.normal[p]), (mx, my, mz), room, ALL_BOXES)
            hide(s, A, b, points_of(s, p, s.count[p]), room, n_near, nearer)
            for i in range(out.shape[2]):
                out[h, column, i] = not room.hidden[i]


@melted
def shown_contour(s: Surface, k: int, A: Any, b: Any, end: float, room: Room, out: Any) -> None:
    """Fill out (m,) with which points of the contour of marker `k`, on a component whose frame is A, b, no box hides:
    as `shown_points`. :param room: with the boxes in the camera."""
    p, on = s.patch_of[k], s.contour[k]
    _, mx, my, mz = aspect(s, p, A, b)
    nearer = surface_share(s, p, mz, end)
    n_near = boxes_in_front(s, p, A, turned(A, s.normal[p]), (mx, my, mz), room, ALL_BOXES)
    hide(s, A, b, (on[0], on[1], on[2]), room, n_near, nearer)
    for i in range(len(out)):
        out[i] = not room.hidden[i]


@jit
def shown_contours(s: Surface, chain: Chain, R: Any, t: Any, q: Any, use: Any, end: float, out: Any) -> None:
    """Fill out (H, M, m) with which points of markers' contours no box hides, of those in use (H, M), under hypotheses
    R (H, 3, 3), t (H, 3), q (H, J). :param end: as of `shown_points`."""
    n_c, room, scratch = len(chain.parent), room_of(s), np.empty((3, 3, 3))
    frames_R, frames_t, joints = np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((2, q.shape[1], 3))
    for h in range(len(R)):
        place_seen(chain, R[h], t[h], q[h], frames_R, frames_t, joints[0], joints[1], scratch)
        boxes_in_camera(s, frames_R, frames_t, room.box_rotation, room.eye, room.middle)
        for k in range(use.shape[1]):
            if use[h, k]:
                c = s.component[s.patch_of[k]]
                shown_contour(s, k, frames_R[c], frames_t[c], end, room, out[h, k])
