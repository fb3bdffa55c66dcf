"""Bodies that fit beneath the markers that stick on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.transforms import Array, Pose
from .marker import Marker
from .objects import Box, Component

_OUTER = 1 / 3  # of a box' size: markers that lie deeper in it were not meant to lie on that side
_ALONG = 0.9  # cosine: such a marker's normal is that of the side
_GAP_M = 1e-5  # so far beneath a marker its body ends


def beneath_markers(component: Component) -> tuple[Component, tuple[str, ...]]:
    """The component with its boxes cut back to the markers that lie a little within them, and these markers' names.

    Whoever measures a body and a marker's place on it with a ruler is a few millimetres off, and what lies within a
    body would never be seen.
    """
    cut, boxes = list[str](), []
    for box in component.bodies:
        for marker in component.markers:
            smaller = _cut_back(box, marker)
            if smaller is not None:
                box, cut = smaller, [*cut, marker.name]
        boxes.append(box)
    return replace(component, bodies=tuple(boxes)), tuple(dict.fromkeys(cut))


def _cut_back(box: Box, marker: Marker) -> Box | None:
    """The box with the side on which a marker lies, a little sunk, cut back to it; None: it lies on none so."""
    T = marker.T_component_marker
    if T is None:
        return None
    in_box = box.T_component_box.inverse() @ T
    axis = int(np.argmax(np.abs(in_box.rotation[:, 2])))
    sign = float(np.sign(in_box.rotation[axis, 2]))
    points = in_box.apply(np.pad(marker.outline, ((0, 0), (0, 1))))
    sunk = box.size[axis] / 2 - float((sign * points[:, axis]).min())
    if abs(in_box.rotation[axis, 2]) < _ALONG or not _GAP_M / 2 < sunk < _OUTER * box.size[axis]:
        return None
    return _shortened(box, axis, sign, sunk + _GAP_M) if _lies_on(points, box.size, axis) else None


def _lies_on(points: Array, size: Array, axis: int) -> bool:
    """Whether the middle of points (n, 3) is within the other sides of a box."""
    middle = np.delete(points.mean(axis=0), axis)
    return bool(np.all(np.abs(middle) < np.delete(size, axis) / 2))


def _shortened(box: Box, axis: int, sign: float, by: float) -> Box:
    shift, size = np.zeros(3), box.size.copy()
    shift[axis], size[axis] = -sign * by / 2, size[axis] - by
    return Box(box.T_component_box @ Pose(np.eye(3), shift), size)
