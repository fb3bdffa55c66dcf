"""Shapes of markers that were drawn or photographed: made into polygons of few corners, with names for files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array
from ...core.model.marker import Marker
from ...core.model.objects import Component, ObjectModel
from .outlines import crossing_edges, default_axis, disc_outline, folded_corner

_SHORT, _LONG = 0.06, 0.12  # shares of the longer side: an edge that a blunted corner left, and a true edge
_SIMPLIFY_SHARE = 0.004  # of the longer side: what a polygon may leave out


@dataclass(frozen=True)
class LooseMarker:
    """A marker's shape before it has a place on the object; `component` is the part that it shall show."""

    component: str
    marker: Marker


def safe_name(text: str) -> str:
    """Letters, digits and _, beginning with a letter: what topics, parameters and keypoints can bear."""
    name = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")
    return name if name and name[0].isalpha() else f"m_{name}".rstrip("_")


def marker_of(name: str, outline: Array, place: str, axis: Array | None = None, radius: float | None = None) -> Marker:
    """A marker from a drawn outline (n, 2), metres, x right, y up.

    :param place: what errors name. :param axis: (2, 2) tail and head; None: the longer middle line.
    :param radius: of a disc, metres.
    """
    polygon = disc_outline(radius) if radius else simplified(outline)
    if len(polygon) < 3 or folded_corner(polygon) is not None or crossing_edges(polygon) is not None:
        raise ConfigError(f"{place}: its outline crosses itself or has no area")
    tail, head = default_axis(polygon) if axis is None else axis
    try:
        return Marker(name, polygon, tail, head, radius)
    except ConfigError as error:
        raise ConfigError(f"{place}: {error}") from None


def simplified(outline: Array) -> Array:
    """The polygon with as few corners as its shape needs."""
    size = float(np.ptp(outline, axis=0).max())
    if size == 0:
        return outline
    points = (outline / size * 1e4).astype(np.float32)
    kept = cv2.approxPolyDP(points[:, None], _SIMPLIFY_SHARE * 1e4, True)[:, 0]
    return np.asarray(kept, float) * size / 1e4


def with_sharp_corners(polygon: Array) -> Array:
    """Corners that pixels and blur have cut off are put back: where a short edge lies between two long ones, the
    long ones are drawn out till they meet."""
    size = float(np.ptp(polygon, axis=0).max())
    corners, n = [], len(polygon)
    ahead = np.roll(polygon, -1, axis=0) - polygon  # edge i runs from corner i to i + 1
    length = np.linalg.norm(ahead, axis=1) / size
    cut = (length < _SHORT) & (np.roll(length, 1) > _LONG) & (np.roll(length, -1) > _LONG)
    for i in range(n):
        if cut[i - 1]:
            continue  # the second end of a short edge
        met = _meeting(polygon[i], ahead[i - 1], polygon[(i + 1) % n], ahead[(i + 1) % n]) if cut[i] else None
        near = met is not None and np.linalg.norm(met - polygon[i]) < 2 * length[i] * size
        if cut[i] and not near:
            corners += [polygon[i], polygon[(i + 1) % n]]
        else:
            corners.append(met if near and met is not None else polygon[i])
    return np.array(corners)


def _meeting(p: Array, along_p: Array, q: Array, along_q: Array) -> Array | None:
    """Where two lines meet; None: they are parallel."""
    cross = along_p[0] * along_q[1] - along_p[1] * along_q[0]
    if abs(cross) < 1e-3 * np.linalg.norm(along_p) * np.linalg.norm(along_q):
        return None
    d = q - p
    return np.asarray(p + along_p * (d[0] * along_q[1] - d[1] * along_q[0]) / cross)


def object_of(name: str, loose: Sequence[LooseMarker]) -> ObjectModel:
    """An object whose markers have no places yet. The first component is the required one."""
    components: dict[str, list[Marker]] = {}
    for m in loose:
        others = components.setdefault(m.component, [])
        if m.marker.name in [o.name for o in others]:
            raise ConfigError(f"two markers of component '{m.component}' are called '{m.marker.name}'; rename one")
        others.append(m.marker)
    return ObjectModel(
        name,
        tuple(Component(c, tuple(markers), required=n == 0) for n, (c, markers) in enumerate(components.items())),
    )
