"""Outlines of markers as images show them, where objects were found by outlines that were drawn.

Of each marker found, its class is looked at in the marker's own frame; over many images the outline lies where half of
them show the class. Size and place stay the file's: how large a marker is no image tells, for it may as well be nearer.
Of several markers their distances tell it, and a pose in space; of a lone one in the image plane its length is kept.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.geometry.camera import Camera
from ...core.geometry.projection import project
from ...core.geometry.transforms import Array
from ...core.model.found import Detection
from ...core.model.marker import Marker
from ...core.model.objects import ObjectModel
from ...core.model.solids import closed_components
from ...core.model.target import Target
from ...simulation.scene import PlacedObject
from ...simulation.surfaces import Surface
from .outline_map import OutlineMap, Traced

_FLUSH = 0.02  # of a marker's length: what lies less before it lies in its plane

Shape = bytes
"""An outline's bytes: markers that are drawn alike are seen together."""


class SeenOutlines:
    """What images show of an object's flat markers. Sides of solids and discs are left: their shape is their kind's."""

    def __init__(self, model: ObjectModel) -> None:
        solids = closed_components(model)
        traceable = [
            m
            for (component, _), m in model.markers.items()
            if component not in solids and m.disc_radius is None and not m.is_ball
        ]
        self._is_lone = len(model.markers) == 1
        self._maps: dict[Shape, OutlineMap] = {m.outline.tobytes(): OutlineMap(m) for m in traceable}

    def __len__(self) -> int:
        return len(self._maps)

    def add(
        self,
        number: int,
        labels: NDArray[np.uint8],
        camera: Camera | None,
        target: Target,
        found: Detection,
        others: Iterable[Detection],
    ) -> None:
        """An object found in an image of class numbers, counted by its probability.

        :param number: of the image: several objects, or like markers, in one are one image. :param others: in it.
        """
        around = [i.contour for d in others if d is not found for i in d.components]
        surfaces = _surfaces(target, found) if camera is not None else []
        for own in found.components:
            component = target.model.component(own.component)
            seen = self._maps.get(component.marker(own.marker).outline.tobytes())
            if seen is None:
                continue
            seen.slanted |= bool(surfaces)
            seen.unsized |= self._is_lone and found.pose is None
            hidden = [*around, *(i.contour for i in found.components if i is not own)]
            if camera is not None and surfaces:
                hidden += [project(camera, s.corners) for s in _before((own.component, own.marker), surfaces)]
            on = np.isin(labels, component.labels(target.label)).astype(np.float32)
            seen.add(number, own, on, _shown(labels.shape, hidden), found.there)

    @property
    def misfit(self) -> float:
        """Share of the markers' area by which what shows their class differs from it."""
        off, area = np.sum([own.misfit() for own in self._maps.values()], axis=0)
        return float(off / max(area, 1e-12))

    @property
    def images(self) -> int:
        """Of the marker that most show."""
        return max(own.images for own in self._maps.values())

    def joined(self, other: SeenOutlines) -> SeenOutlines:
        """What both saw, of the same object."""
        both = SeenOutlines.__new__(SeenOutlines)
        both._is_lone = self._is_lone
        both._maps = {shape: own.joined(other._maps[shape]) for shape, own in self._maps.items()}
        return both

    def traced(self) -> dict[Shape, Traced]:
        """Of each shape that enough images show."""
        found = ((shape, own.traced()) for shape, own in self._maps.items())
        return {shape: traced for shape, traced in found if traced is not None}


def with_outlines(model: ObjectModel, traced: Collection[Traced]) -> ObjectModel:
    """An object with its markers' outlines as they are seen, where that differs from what is drawn."""
    seen = {t.drawn.outline.tobytes(): t.outline for t in traced if t.differs}

    def retraced(m: Marker) -> Marker:
        return replace(m, outline=seen.get(m.outline.tobytes(), m.outline))

    parts = (replace(c, markers=tuple(map(retraced, c.markers))) for c in model.components)
    return replace(model, components=tuple(parts))


def _surfaces(target: Target, found: Detection) -> list[Surface]:
    """What faces the camera of an object found in space; of others nothing."""
    if found.pose is None or found.pose_from != "fit" or found.frame_id:
        return []
    return [s for s in PlacedObject(target, found.pose, found.joints).surfaces() if s.facing > 0]


def _before(owner: tuple[str, str], surfaces: Sequence[Surface]) -> Iterator[Surface]:
    """Those that may hide a marker: what reaches before its plane."""
    own = next((s for s in surfaces if s.owner == owner), None)
    for s in surfaces if own is not None else ():
        assert own is not None
        ahead = (s.corners - own.corners[0]) @ own.normal
        if s is not own and ahead.max() > _FLUSH * float(np.ptp(own.corners, axis=0).max()):
            yield s


def _shown(size: Sequence[int], hidden: Sequence[Array]) -> NDArray[np.float32]:
    """(H, W) 1, 0 where contours lie and a pixel around them."""
    shown = np.ones(size, np.float32)
    polygons = [c.round().astype(np.int32) for c in hidden if len(c) >= 3 and np.isfinite(c).all()]
    for polygon in polygons:
        cv2.fillPoly(shown, [polygon], 0.0)
        cv2.polylines(shown, [polygon], True, 0.0, 3)
    return shown
