"""Where parts of an object that are of one class lie over each other.

What lies just beyond a marker's contour then says nothing against it.
"""

from __future__ import annotations

from typing import Any

from ..base.jit import lean, melted
from ..geometry.pixel_kernels import LabelView, outline_pixels, turned
from .hiding_kernels import boxes_in_camera, hide
from .surface_kernels import LEAST_DEPTH_M, Room, Surface, SurfaceLimits, aspect, beside

COVERED = -1.0  # in `Room.open`
_ANYWHERE = 1e9  # times the way to a point: a box behind it covers it, too


@lean
def cover(s: Surface, R: Any, t: Any, view: LabelView, limits: SurfaceLimits, room: Room) -> None:
    """Fill `room.open` with where no other part of the object's that is of the same class lies beyond a contour.

    :param R, t: (C, 3, 3), (C, 3) the frames of its components.
    """
    n_m, n_b, m = len(s.open_ring), len(s.half), s.contour.shape[2]
    for k in range(n_m):
        p, row = s.patch_of[k], room.open[k]
        A, b = R[s.component[p]], t[s.component[p]]
        cosine, _, _, z = aspect(s, p, A, b)
        room.shown[k] = cosine > limits.least_cosine and z > LEAST_DEPTH_M
        room.depth[k] = z
        for i in range(m):
            row[i] = s.open_ring[k, i]
        if room.shown[k]:
            outline_pixels(A, b, s.contour[k], s.contour_along[k], view, room.outlines[k])
    boxed = False
    for k in range(n_m):
        for j in range(n_m):
            if s.like[k, j] and room.shown[k] and room.shown[j]:
                far_px, _ = beside(s, k, room.depth[k], view, limits)
                cover_by_marker(room.outlines[k], room.outlines[j], far_px, room.open[k])
        for j in range(n_b):
            boxed |= s.like_box[k, j] and room.shown[k]
    if boxed:
        boxes_in_camera(s, R, t, room.box_rotation, room.eye, room.middle)
        for k in range(n_m):
            if room.shown[k]:
                cover_by_boxes(s, k, R, t, view, limits, room)


@lean
def contains(outline: Any, x: float, y: float) -> bool:
    """Whether a point lies inside an outline, u and v of whose m corners are its first rows; even-odd rule."""
    inside, j = False, outline.shape[1] - 1
    for i in range(outline.shape[1]):
        xi, yi, xj, yj = outline[0, i], outline[1, i], outline[0, j], outline[1, j]
        if (yi > y) != (yj > y) and x < xi + (y - yi) / (yj - yi) * (xj - xi):
            inside = not inside
        j = i
    return inside


@melted
def box_of(outline: Any) -> tuple[float, float, float, float]:
    """Least and greatest u, then v."""
    left, right, top, bottom = outline[0, 0], outline[0, 0], outline[1, 0], outline[1, 0]
    for i in range(1, outline.shape[1]):
        left, right = min(left, outline[0, i]), max(right, outline[0, i])
        top, bottom = min(top, outline[1, i]), max(bottom, outline[1, i])
    return left, right, top, bottom


@melted
def cover_by_marker(mine: Any, other: Any, far_px: float, row: Any) -> None:
    """Note where so far beyond a contour (4, m) another one lies around it."""
    left, right, top, bottom = box_of(other)
    for i in range(len(row)):
        x, y = mine[0, i] + far_px * mine[2, i], mine[1, i] + far_px * mine[3, i]
        if left <= x <= right and top <= y <= bottom and contains(other, x, y):
            row[i] = COVERED


@melted
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
    far_px, _ = beside(s, k, z + b[2], view, limits)
    far = far_px * (z + b[2]) / view.K[0, 0]
    for i in range(on.shape[1]):
        ax, ay, az = along[0, i], along[1, i], along[2, i]
        out[0, i] = on[0, i] + far * (ay * nz - az * ny)
        out[1, i] = on[1, i] + far * (az * nx - ax * nz)
        out[2, i] = on[2, i] + far * (ax * ny - ay * nx)
    hide(s, A, b, (out[0], out[1], out[2]), room, n, _ANYWHERE)
    for i in range(on.shape[1]):
        if room.hidden[i]:
            room.open[k, i] = COVERED
