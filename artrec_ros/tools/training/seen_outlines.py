"""Outlines of markers as images show them, where objects were found by outlines that were drawn.

Of each marker found, its class is looked at in the marker's own frame; over many images the outline lies where half of
them show the class. Size and place stay the file's: how large a marker is no image tells, for it may as well be nearer.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.geometry.camera import Camera
from ...core.geometry.polygons import distance_to_outline
from ...core.geometry.projection import project
from ...core.geometry.transforms import Array
from ...core.learning.outline_mending import along, laid_on, mended_by
from ...core.model.found import Detection, Instance
from ...core.model.marker import Marker
from ...core.model.objects import ObjectModel
from ...core.model.solids import closed_components
from ...core.model.target import Target
from ...io.objects.marker_shapes import simplified, with_sharp_corners
from ...io.objects.outlines import crossing_edges, folded_corner, subpixel_contour
from ...simulation.scene import PlacedObject
from ...simulation.surfaces import Surface

LEAST_PX = 16.0  # the root of a marker's area in an image: a smaller one shows no shape
LEAST_IMAGES = 8  # that show a marker: fewer tell little of what is the same in all
_CELLS = 64  # of a map along the root of a marker's area
_BEYOND = 0.3  # of that root: how far outside of what is drawn is looked
_KNOWN = 0.3  # of the images: where fewer show what is there, for another marker lies on it, it stays as drawn
_NOISE_PX, _NOISE_SHARE = 1.5, 0.03  # off by less, as of the root, may be the segmentation's edge or a rounded corner
_ALIKE = 0.01  # of the root: sides that are farther off than this are drawn otherwise, and do not tell the place
_FLUSH = 0.02  # of a marker's length: what lies less before it lies in its plane

Shape = bytes
"""An outline's bytes: markers that are drawn alike are seen together."""


@dataclass(frozen=True)
class Traced:
    """How a shape is seen.

    :param drawn: one of its markers. :param images: that show one. :param outline: (n, 2) as seen, metres, in the
        marker's frame. :param off_m: how far what is seen and what is drawn are apart where they are most.
    :param at: (2,) where that is. :param least_m: what may be noise. :param level: (H, W) 0 to 255, share of the images
        that show the class, and `zoom` its pixels per metre, `corner` (2,) where its first one lies.
    """

    drawn: Marker
    images: int
    outline: Array
    off_m: float
    at: Array
    least_m: float
    level: NDArray[np.uint8]
    zoom: float
    corner: Array

    @property
    def differs(self) -> bool:
        return self.off_m > self.least_m


class _Map:
    """What images show of a shape."""

    def __init__(self, marker: Marker) -> None:
        self.marker, self.images, self.px_per_m = marker, 0, list[float]()
        self.slanted = False
        size = np.sqrt(marker.area)
        self.step = size / _CELLS
        low, high = marker.outline.min(axis=0) - _BEYOND * size, marker.outline.max(axis=0) + _BEYOND * size
        self.corner = np.array([low[0], high[1]])
        self.width, self.height = (int(n) + 1 for n in np.ceil((high - low) / self.step))
        self.on, self.known = (np.zeros((self.height, self.width)) for _ in range(2))
        self._to_metres = np.array([[self.step, 0, low[0]], [0, -self.step, high[1]], [0, 0, 1]])

    def add(self, found: Instance, on: NDArray[np.float32], shown: NDArray[np.float32], weight: float) -> None:
        """:param on: (H, W) 1 on its classes. :param shown: (H, W) 0 where other markers lie."""
        warp = _onto_image(self.marker.outline, found.contour)
        if warp is None or not found.scale * np.sqrt(self.marker.area) >= LEAST_PX:
            return
        way = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        size = (self.width, self.height)
        known = weight * cv2.warpPerspective(shown, warp @ self._to_metres, size, flags=way)
        self.on += known * cv2.warpPerspective(on, warp @ self._to_metres, size, flags=way)
        self.known += known
        self.images += 1
        self.px_per_m.append(found.scale)

    def joined(self, other: _Map) -> _Map:
        both = _Map(self.marker)
        both.on, both.known, both.images = self.on + other.on, self.known + other.known, self.images + other.images
        both.px_per_m, both.slanted = self.px_per_m + other.px_per_m, self.slanted or other.slanted
        return both

    def traced(self) -> Traced | None:
        """None: too few images show it, or nothing with a shape."""
        if self.images < LEAST_IMAGES:
            return None
        outline = self.marker.outline
        corners = ((outline - self.corner) / self.step * (1, -1)).round().astype(np.int32)
        drawn = cv2.fillPoly(np.zeros(self.on.shape), [corners], 1.0)
        is_known = self.known > _KNOWN * self.known.max()
        level = np.where(is_known, self.on / np.maximum(self.known, 1e-12), drawn)
        if not (level > 0.5).any():
            return None
        seen = subpixel_contour(level, Path(self.marker.name)) * (1, -1)
        seen = with_sharp_corners(simplified(seen)) * self.step + self.corner
        if len(seen) < 3 or folded_corner(seen) is not None or crossing_edges(seen) is not None:
            return None
        size = float(np.sqrt(self.marker.area))
        seen = laid_on(seen, outline, _ALIKE * size, self.slanted)
        on_drawn, on_seen = along(outline), along(seen)
        off = np.concatenate([distance_to_outline(on_drawn, seen), distance_to_outline(on_seen, outline)])
        worst, least = int(np.argmax(off)), max(_NOISE_PX / float(np.median(self.px_per_m)), _NOISE_SHARE * size)
        at = np.concatenate([on_drawn, on_seen])[worst]
        mended = simplified(mended_by(outline, seen, least)) if float(off[worst]) > least else outline
        grey = (255 * level).astype(np.uint8)
        return Traced(self.marker, self.images, mended, float(off[worst]), at, least, grey, 1 / self.step, self.corner)


class SeenOutlines:
    """What images show of an object's flat markers. Sides of solids and discs are left: their shape is their kind's."""

    def __init__(self, model: ObjectModel) -> None:
        solids = closed_components(model)
        traceable = [
            m
            for (component, _), m in model.markers.items()
            if component not in solids and m.disc_radius is None and not m.is_ball
        ]
        self._maps: dict[Shape, _Map] = {m.outline.tobytes(): _Map(m) for m in traceable}

    def __len__(self) -> int:
        return len(self._maps)

    def add(
        self,
        labels: NDArray[np.uint8],
        camera: Camera | None,
        target: Target,
        found: Detection,
        others: Iterable[Detection],
    ) -> None:
        """An object found in an image of class numbers, counted by its probability. :param others: in the image."""
        around = [i.contour for d in others if d is not found for i in d.components]
        surfaces = _surfaces(target, found) if camera is not None else []
        for own in found.components:
            component = target.model.component(own.component)
            seen = self._maps.get(component.marker(own.marker).outline.tobytes())
            if seen is None:
                continue
            seen.slanted |= bool(surfaces)
            hidden = [*around, *(i.contour for i in found.components if i is not own)]
            if camera is not None and surfaces:
                hidden += [project(camera, s.corners) for s in _before((own.component, own.marker), surfaces)]
            on = np.isin(labels, component.labels(target.label)).astype(np.float32)
            seen.add(own, on, _shown(labels.shape, hidden), found.score)

    def joined(self, other: SeenOutlines) -> SeenOutlines:
        """What both saw, of the same object."""
        both = SeenOutlines.__new__(SeenOutlines)
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


def _onto_image(outline: Array, contour: Array) -> Array | None:
    """(3, 3) from a marker's plane to the image; None where its contour there is cut."""
    if len(contour) != len(outline) or not np.isfinite(contour).all():
        return None
    drawn, there = outline.astype(np.float32), contour.astype(np.float32)
    if len(outline) == 3:
        return np.vstack([cv2.getAffineTransform(drawn, there), [0, 0, 1]])
    warp = cv2.findHomography(drawn, there)[0]
    return None if warp is None else np.asarray(warp, np.float64)


def _shown(size: Sequence[int], hidden: Sequence[Array]) -> NDArray[np.float32]:
    """(H, W) 1, 0 where contours lie and a pixel around them."""
    shown = np.ones(size, np.float32)
    polygons = [c.round().astype(np.int32) for c in hidden if len(c) >= 3 and np.isfinite(c).all()]
    for polygon in polygons:
        cv2.fillPoly(shown, [polygon], 0.0)
        cv2.polylines(shown, [polygon], True, 0.0, 3)
    return shown
