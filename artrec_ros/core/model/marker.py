"""What a marker is: an outline with an axis.

Marker frame: x to the right, y up as a camera that faces the marker sees it, z out of the marker towards that camera;
metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.errors import ConfigError
from ..geometry.polygons import perimeter, signed_area
from ..geometry.transforms import Array, Pose, readonly
from .names import check_name


@dataclass(frozen=True)
class Marker:
    """A rigid flat marker. Its name, as those of components and objects, is one that `names.check_name` passes.

    :param outline: (n, 2) polygon in metres, marker frame (x right, y up), not closed, any sense.
    :param tail, head: (2,) ends of the marker's axis in the marker frame.
    :param disc_radius: radius in metres where the marker is a disc (its outline is then a regular polygon).
    :param T_component_marker: the marker's place on its component, where known.
    :param is_ball: it stands for a ball about its centre, which looks the same from all sides: a disc of the ball's
        radius that faces the camera wherever that is.
    """

    name: str
    outline: Array
    tail: Array
    head: Array
    disc_radius: float | None = None
    T_component_marker: Pose | None = None
    is_ball: bool = False

    def __post_init__(self) -> None:
        check_name(self.name, "marker")
        for name in ("outline", "tail", "head"):
            object.__setattr__(self, name, readonly(getattr(self, name)))
        if self.is_ball and self.T_component_marker is not None:  # its component's frame is turned to the camera
            object.__setattr__(self, "T_component_marker", Pose(np.eye(3), self.T_component_marker.position))
        if self.outline.ndim != 2 or self.outline.shape[1] != 2 or len(self.outline) < 3:
            raise ConfigError(f"marker '{self.name}': the outline needs three points (x, y) or more")
        if abs(self._signed_area) < 1e-12:
            raise ConfigError(f"marker '{self.name}': the outline encloses no area")
        if self.axis_length < 1e-9:
            raise ConfigError(f"marker '{self.name}': the axis' tail and head are the same point")

    @cached_property
    def _signed_area(self) -> float:
        return signed_area(self.outline)

    @cached_property
    def area(self) -> float:
        """Square metres."""
        return abs(self._signed_area)

    @cached_property
    def perimeter(self) -> float:
        """Metres."""
        return perimeter(self.outline)

    @property
    def radius(self) -> float:
        """Metres: twice the area over the perimeter, a disc's radius. An edge all around that errs, errs the scale by
        its share of this. Of a ball its own, whose outline has a circle's area."""
        return float(np.sqrt(self.area / np.pi)) if self.is_ball else 2 * self.area / self.perimeter

    @cached_property
    def centroid(self) -> Array:
        """(2,) centroid of the outline's area, marker frame."""
        x, y = self.outline.T
        cross = x * np.roll(y, -1) - np.roll(x, -1) * y
        sums = [np.sum((v + np.roll(v, -1)) * cross) for v in (x, y)]
        return readonly(np.array(sums) / (6 * self._signed_area))

    @cached_property
    def centre(self) -> Array:
        """(3,) the centroid in the component's frame; for a marker whose place there is known."""
        assert self.T_component_marker is not None
        return readonly(self.T_component_marker.apply(np.append(self.centroid, 0.0)[None])[0])

    @cached_property
    def image_outline(self) -> Array:
        """(n, 2) outline about the centroid with y DOWN, so that T(outline) is a plain similarity."""
        return readonly((self.outline - self.centroid) * (1, -1))

    @cached_property
    def axis_length(self) -> float:
        """Metres from tail to head."""
        return float(np.linalg.norm(self.head - self.tail))

    @cached_property
    def axis_angle(self) -> float:
        """Direction of the axis tail -> head in `image_outline` coordinates, radians."""
        d = (self.head - self.tail) * (1, -1)
        return float(np.arctan2(d[1], d[0]))
