"""Whether the markers of an object can be seen at all where its file puts them."""

from __future__ import annotations

import numpy as np

from ..alignment.shapes import Shape
from ..geometry.transforms import Array
from ..model.marker import Marker
from ..model.objects import Box, Component, ObjectModel
from ..model.target import Target

_LIFT_M = 5e-4  # a sticker lies on its body, or this much within it
_BEFORE_M = (2 * _LIFT_M, 3e-3, 6e-3)  # before a marker: one that looks into its body may lie a little off it
_MUCH = 0.5  # share of a marker


def buried_markers(model: ObjectModel) -> list[tuple[str, str]]:
    """(component, marker) of the markers that lie within their own component's body, or look into it; of a box or
    cylinder of one colour, out of some of whose sides a rod may come, all or none. A ball stands out of what is in
    it."""
    found, solids = list[tuple[str, str]](), Target(model.name, model, 1).solids
    for component in (c for c in model.components if c.ball is None):
        buried = [(component.name, m.name) for m in component.markers if _is_buried(m, component)]
        if len(buried) == len(component.markers) or component.name not in solids:
            found += buried
    return found


def _is_buried(marker: Marker, component: Component) -> bool:
    T = marker.T_component_marker
    if T is None:
        return False
    inside = Shape.from_marker(marker).inside  # x right, y down, about the centroid
    flat = np.column_stack([inside.real, -inside.imag]) + marker.centroid
    covered = np.zeros(len(flat), bool)
    for height in _BEFORE_M:
        points = T.apply(np.column_stack([flat, np.full(len(flat), height)]))
        for box in component.bodies:
            covered |= _inside(box, points)
    return bool(covered.mean() > _MUCH)


def _inside(box: Box, points: Array) -> np.ndarray:
    local = box.T_component_box.inverse().apply(points)
    return np.asarray(np.all(np.abs(local) < box.size / 2 - _LIFT_M, axis=1))
