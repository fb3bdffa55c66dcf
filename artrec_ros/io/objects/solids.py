"""Boxes, cylinders and balls of one colour: flat markers that cover them, or stand for them, and bodies."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...core.geometry.transforms import Array, Pose
from ...core.model.marker import Marker
from ...core.model.objects import Box
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
_BALL_CORNERS = 64  # of a ball's outline: of a circle's area, it stands out of it by a thousandth of its radius
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
    """One about the origin of a pose: a disc that faces the camera, and a cube that its surface holds."""
    as_large = math.sqrt(2 * math.pi / (_BALL_CORNERS * math.sin(2 * math.pi / _BALL_CORNERS)))
    outline = as_large * radius_m * _circle(2 * np.pi * np.arange(_BALL_CORNERS) / _BALL_CORNERS)
    at = Pose(np.eye(3), T.position)  # it looks the same however it is turned
    cube = Box(at, np.full(3, 2 * radius_m / 3**0.5))
    return (Marker("ball", outline, *default_axis(outline), None, at, is_ball=True),), (cube,)


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
