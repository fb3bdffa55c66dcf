"""The six sides of a box of one colour as markers."""

from __future__ import annotations

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


def sides_of(box: Box) -> tuple[Marker, ...]:
    """Markers that cover a box, by the sides they are on: x is its front, y its left, z its top."""
    return tuple(_side(box, name, *np.array(axes, float)) for name, axes in _SIDES.items())


def _side(box: Box, name: str, out: Array, right: Array, up: Array) -> Marker:
    outline = rectangle(float(abs(right @ box.size)), float(abs(up @ box.size)))
    on_box = Pose(np.stack([right, up, out], axis=1), out * box.size / 2)
    return Marker(name, outline, *default_axis(outline), None, box.T_component_box @ on_box)


def rectangle(width_m: float, height_m: float) -> Array:
    """(4, 2) corners about the origin."""
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array([width_m, height_m]) / 2
