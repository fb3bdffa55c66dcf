"""Boxes, cylinders and balls of one colour: flat markers that cover them, and bodies."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...core.geometry.transforms import Array, Pose
from ...core.model.objects import Box, Marker
from .outlines import default_axis

# of each the direction it faces, and those of its x (right) and y (up) as a camera that faces it sees it: REP 103
_SIDES = {
    "front": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "back": ((-1, 0, 0), (0, -1, 0), (0, 0, 1)),
    "left": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    "right": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    "top": ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    "bottom": ((0, 0, -1), (1, 0, 0), (0, -1, 0)),
}
_ROUND = 12  # sides of a cylinder: with 8 cans came out 1.5 % too near, with 12 half a percent
Solid = tuple[tuple[Marker, ...], tuple[Box, ...]]


def box_solid(box: Box) -> Solid:
    """Its six sides: x is its front, y its left, z its top."""
    sides = ((name, *np.array(axes, float)) for name, axes in _SIDES.items())
    markers = tuple(
        _marker(name, rectangle(*_size(box, right, up)), Pose(_frame(right, up, out), out * box.size / 2), box)
        for name, out, right, up in sides
    )
    return markers, (box,)


def _size(box: Box, right: Array, up: Array) -> tuple[float, float]:
    return float(abs(right @ box.size)), float(abs(up @ box.size))


def cylinder_solid(radius_m: float, length_m: float, T: Pose) -> Solid:
    """One about the z axis of a pose, as a prism that looks as wide as it in the mean of all directions."""
    flat_m = radius_m * math.pi / (_ROUND * math.tan(math.pi / _ROUND))  # from the axis to a side (Cauchy's theorem)
    width_m = 2 * flat_m * math.tan(math.pi / _ROUND)
    whole = Box(T, np.array([2 * flat_m, 2 * flat_m, length_m]))
    markers = list(_around(whole, flat_m, width_m))
    corners = flat_m / math.cos(math.pi / _ROUND) * _circle(np.pi * (2 * np.arange(_ROUND) + 1) / _ROUND)
    for name in ("top", "bottom"):
        out, right, up = np.array(_SIDES[name], float)
        markers.append(_marker(name, corners, Pose(_frame(right, up, out), out * length_m / 2), whole))
    across = np.array([2 * flat_m, width_m, length_m])
    turns = (Pose.from_xyz_rpy((0, 0, 0), (0, 0, 2 * math.pi * k / _ROUND)) for k in range(_ROUND // 2))
    return tuple(markers), tuple(Box(T @ turn, across) for turn in turns)  # each fills it between two sides


def ball_solid(radius_m: float, T: Pose) -> Solid:
    """One about the origin of a pose, as a dodecahedron that looks as large as it where it looks largest: of its turns,
    which nothing tells, the one is told in which it covers most."""
    golden = (1 + 5**0.5) / 2
    corners = [np.roll((0.0, a, b * golden), k) for k in range(3) for a in (-1, 1) for b in (-1, 1)]
    normals = np.array(corners) / math.hypot(1, golden)
    # of a side, as a multiple of how far it is from the middle: to its edges half an angle between neighbours away
    to_corner = math.tan(math.acos(1 / 5**0.5) / 2) / math.cos(math.pi / 5)
    side = 2.5 * to_corner**2 * math.sin(2 * math.pi / 5)
    # a shadow has half the area of all sides as they turn to the light: of its own axes those of sides have most
    shadow = side / 2 * float(np.abs(normals @ _axes_of(normals).T).sum(axis=0).max())
    flat_m = radius_m * math.sqrt(math.pi / shadow)
    outline = flat_m * to_corner * _circle(2 * np.pi * (np.arange(5) + 0.5) / 5)
    whole = Box(T, np.full(3, 2 * flat_m / 3**0.5))
    markers = []
    for k, out in enumerate(normals):
        near = normals[np.argsort(-(normals @ out), kind="stable")[1]]
        right = near - (near @ out) * out
        right /= np.linalg.norm(right)
        markers.append(
            _marker(f"side_{k}", outline, Pose(_frame(right, np.cross(out, right), out), flat_m * out), whole)
        )
    return tuple(markers), (whole,)


def _axes_of(normals: Array) -> Array:
    """(k, 3) directions of sides, and those amid two and three of them: of edges and corners."""
    sums = [normals, normals[:, None] + normals, normals[:, None, None] + normals[:, None] + normals]
    axes = np.concatenate([some.reshape(-1, 3) for some in sums])
    length = np.linalg.norm(axes, axis=1)
    return np.asarray(axes[length > 1e-6] / length[length > 1e-6, None])


def _around(whole: Box, flat_m: float, width_m: float) -> Iterator[Marker]:
    up = np.array([0.0, 0.0, 1.0])
    for k in range(_ROUND):
        out = np.append(_circle(2 * np.pi * k / _ROUND), 0.0)
        pose = Pose(_frame(np.cross(up, out), up, out), flat_m * out)
        yield _marker(f"side_{k}", rectangle(width_m, float(whole.size[2])), pose, whole)


def _marker(name: str, outline: Array, on_box: Pose, box: Box) -> Marker:
    return Marker(name, outline, *default_axis(outline), None, box.T_component_box @ on_box)


def _frame(right: Array, up: Array, out: Array) -> Array:
    return np.stack([right, up, out], axis=1)


def _circle(angle: Array | float) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def rectangle(width_m: float, height_m: float) -> Array:
    """(4, 2) corners about the origin."""
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array([width_m, height_m]) / 2
