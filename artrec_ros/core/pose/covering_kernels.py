"""Where an object's own parts lie beyond the contours of its markers: their class there says nothing against these."""

from __future__ import annotations

from typing import Any

from ..base.jit import inlined, lean
from ..geometry.pixel_kernels import LabelView, outline_pixels, turned
from .hiding_kernels import boxes_in_camera, hide
from .surface_kernels import LEAST_DEPTH_M, Room, Surface, SurfaceLimits, aspect

COVERED = -1.0  # in `Room.open`
_ANYWHERE = 1e9  # times the way to a point: a box behind it covers it, too


@lean
def cover_contours(s: Surface, R: Any, t: Any, view: LabelView, limits: SurfaceLimits, room: Room) -> None:
    """Fill `room.open` with where no other part of the object's that is of the same class lies beyond a contour.

    :param R, t: (C, 3, 3), (C, 3) the frames of its components.
    """
    n_m, n_b, m = len(s.open_ring), len(s.half), s.contour.shape[2]
    for k in range(n_m):
        p, row = s.patch_of[k], room.open[k]
        A, b = R[s.component[p]], t[s.component[p]]
        cosine, _, _, z = aspect(s, p, A, b)
        room.shown[k] = cosine > limits.least_cosine and z > LEAST_DEPTH_M
        for i in range(m):
            row[i] = s.open_ring[k, i]
        if room.shown[k]:
            outline_pixels(A, b, s.contour[k], s.contour_along[k], view, room.outlines[k])
    boxed = False
    for k in range(n_m):
        for j in range(n_m):
            if s.like[k, j] and room.shown[k] and room.shown[j]:
                cover_by_marker(room.outlines[k], room.outlines[j], limits.ring_px, room.open[k])
        for j in range(n_b):
            boxed |= s.like_box[k, j] and room.shown[k]
    if boxed:
        boxes_in_camera(s, R, t, room.box_rotation, room.eye, room.middle)
        for k in range(n_m):
            if room.shown[k]:
                cover_by_boxes(s, k, R, t, view, limits, room)


@inlined
def cover_by_marker(mine: Any, other: Any, ring_px: float, row: Any) -> None:
    """Note where just beyond a contour (4, m) another one lies around it (even-odd rule)."""
    m = len(row)
    left, right, top, bottom = other[0, 0], other[0, 0], other[1, 0], other[1, 0]
    for i in range(1, m):
        left, right = min(left, other[0, i]), max(right, other[0, i])
        top, bottom = min(top, other[1, i]), max(bottom, other[1, i])
    for i in range(m):
        x, y = mine[0, i] + ring_px * mine[2, i], mine[1, i] + ring_px * mine[3, i]
        if not (left <= x <= right and top <= y <= bottom):
            continue
        inside, last = False, m - 1
        for e in range(m):
            u0, v0, u1, v1 = other[0, last], other[1, last], other[0, e], other[1, e]
            if (v0 > y) != (v1 > y) and x < u0 + (y - v0) * (u1 - u0) / (v1 - v0):
                inside = not inside
            last = e
        if inside:
            row[i] = COVERED


@inlined
def cover_by_boxes(s: Surface, k: int, R: Any, t: Any, view: LabelView, limits: SurfaceLimits, room: Room) -> None:
    """Note where just beyond the contour of marker `k` the camera sees, or would see, bodies of its class."""
    n = 0
    for j in range(len(s.half)):
        if s.like_box[k, j]:
            room.near[n] = j
            n += 1
    if n == 0:
        return
    p, on, along, out = s.patch_of[k], s.contour[k], s.contour_along[k], room.beyond
    A, b, (nx, ny, nz) = R[s.component[p]], t[s.component[p]], s.normal[p]
    _, _, z = turned(A, s.centre[p])
    far = limits.ring_px * (z + b[2]) / view.K[0, 0]
    for i in range(on.shape[1]):
        ax, ay, az = along[0, i], along[1, i], along[2, i]
        out[0, i] = on[0, i] + far * (ay * nz - az * ny)
        out[1, i] = on[1, i] + far * (az * nx - ax * nz)
        out[2, i] = on[2, i] + far * (ax * ny - ay * nx)
    hide(s, A, b, (out[0], out[1], out[2]), room, n, _ANYWHERE)
    for i in range(on.shape[1]):
        if room.hidden[i]:
            room.open[k, i] = COVERED
