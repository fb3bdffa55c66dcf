"""Where images show a marker's class, in the marker's own frame, and what outline that makes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.geometry.transforms import Array
from ...core.learning.outline_mending import farthest_apart, laid_on, mended_by, to_length
from ...core.model.found import Instance
from ...core.model.marker import Marker
from ...io.objects.marker_shapes import simplified, with_sharp_corners
from ...io.objects.outlines import crossing_edges, folded_corner, subpixel_contour

LEAST_PX = 16.0  # the root of a marker's area in an image: a smaller one shows no shape
LEAST_IMAGES = 8  # that show a marker: fewer tell little of what is the same in all
_CELLS = 64  # of a map along the root of a marker's area
_BEYOND = 0.3  # of that root: how far outside of what is drawn is looked
_KNOWN = 0.3  # of the images: where fewer show what is there, for another marker lies on it, it stays as drawn
_NOISE_PX, _NOISE_SHARE = 1.0, 0.02  # off by less, as of the root, may be where the segmentation has its edge
_SOFT = 0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0  # cells: by how much poses that err soften a map, and round corners
_ONE_TURN, _ONE_PLACE = 0.98, 0.5  # mean of directions, and spread in its sizes, of what is always seen in one place
_HOLE = 0.01  # of a marker's area: what is no speck
_ALIKE = 0.01  # of the root: sides that are farther off than this are drawn otherwise, and do not tell the place


@dataclass(frozen=True)
class Traced:
    """How a shape is seen.

    :param drawn: one of its markers. :param images: that show one. :param outline: (n, 2) as seen, metres, in the
        marker's frame. :param off_m: how far what is seen and what is drawn are apart where they are most.
    :param at: (2,) where that is. :param least_m: what may be noise. :param hole: (2,) where what shows no class lies
        within it, if there is such. :param in_one_place: whether all images show it in one place and turn.
    :param level: (H, W) 0 to 255, share of the images that show the class, and `zoom` its pixels per metre, `corner`
        (2,) where its first one lies.
    """

    drawn: Marker
    images: int
    outline: Array
    off_m: float
    at: Array
    least_m: float
    hole: Array | None
    in_one_place: bool
    level: NDArray[np.uint8]
    zoom: float
    corner: Array

    @property
    def differs(self) -> bool:
        return self.off_m > self.least_m


class OutlineMap:
    """What images show of a shape."""

    def __init__(self, marker: Marker) -> None:
        self.marker, self.slanted, self.unsized = marker, False, False
        self.numbers = set[int]()  # of the images that show it
        self.seen = list[Instance]()
        size = np.sqrt(marker.area)
        self.step = size / _CELLS
        low, high = marker.outline.min(axis=0) - _BEYOND * size, marker.outline.max(axis=0) + _BEYOND * size
        self.corner = np.array([low[0], high[1]])
        self.width, self.height = (int(n) + 1 for n in np.ceil((high - low) / self.step))
        self.on, self.known = (np.zeros((self.height, self.width)) for _ in range(2))
        self._to_metres = np.array([[self.step, 0, low[0]], [0, -self.step, high[1]], [0, 0, 1]])

    @property
    def images(self) -> int:
        return len(self.numbers)

    def add(
        self, number: int, found: Instance, on: NDArray[np.float32], shown: NDArray[np.float32], weight: float
    ) -> None:
        """:param number: of the image. :param on: (H, W) 1 on its classes. :param shown: (H, W) 0 where other markers
        lie."""
        warp = _onto_image(self.marker.outline, found.contour)
        if warp is None or not found.scale * np.sqrt(self.marker.area) >= LEAST_PX:
            return
        way = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        size = (self.width, self.height)
        known = weight * cv2.warpPerspective(shown, warp @ self._to_metres, size, flags=way)
        self.on += known * cv2.warpPerspective(on, warp @ self._to_metres, size, flags=way)
        self.known += known
        self.numbers.add(number)
        self.seen.append(found)

    def joined(self, other: OutlineMap) -> OutlineMap:
        both = OutlineMap(self.marker)
        both.on, both.known, both.numbers = self.on + other.on, self.known + other.known, self.numbers | other.numbers
        both.seen, both.slanted = self.seen + other.seen, self.slanted or other.slanted
        both.unsized = self.unsized or other.unsized
        return both

    def misfit(self) -> tuple[float, float]:
        """Of its area, in cells: what shows otherwise than the outline says, and all of it."""
        drawn, level = self._drawn(), self.on / np.maximum(self.known, 1e-12)
        return float((self.known * np.abs(level - drawn)).sum()), float((self.known * drawn).sum())

    def traced(self) -> Traced | None:
        """None: too few images show it, or nothing with a shape."""
        outline, drawn, size = self.marker.outline, self._drawn(), float(np.sqrt(self.marker.area))
        if self.images < LEAST_IMAGES:
            return None
        is_known = self.known > _KNOWN * self.known.max()
        level = np.where(is_known, self.on / np.maximum(self.known, 1e-12), drawn)
        soft = [cv2.GaussianBlur(drawn, (0, 0), s) if s else drawn for s in _SOFT]
        as_drawn = self._contour(min(soft, key=lambda one: float((self.known * np.abs(level - one)).sum())))
        seen = self._contour(level)
        if seen is None or as_drawn is None:
            return None
        seen, zoom, shift = laid_on(seen, as_drawn, _ALIKE * size, self.slanted), 1.0, np.zeros(2)
        if self.unsized:
            zoom, shift = to_length(seen, as_drawn, self.marker.head - self.marker.tail)
            seen = zoom * seen + shift
        off_m, at = farthest_apart(as_drawn, seen)
        px_per_m = float(np.median([i.scale for i in self.seen]))
        least, mended = max(_NOISE_PX / px_per_m, _NOISE_SHARE * size), outline
        if off_m > least:
            mended = with_sharp_corners(simplified(mended_by(outline, with_sharp_corners(seen), least, as_drawn)))
            if folded_corner(mended) is not None or crossing_edges(mended) is not None:
                return None
        grey, hole, one_place = (255 * level).astype(np.uint8), self._hole(level), self._in_one_place()
        of = self.marker, self.images, mended, off_m, at, least, hole, one_place
        return Traced(*of, grey, 1 / (zoom * self.step), zoom * self.corner + shift)

    def _drawn(self) -> Array:
        """(H, W) 1 within what is drawn."""
        corners = ((self.marker.outline - self.corner) / self.step * (1, -1)).round().astype(np.int32)
        return np.asarray(cv2.fillPoly(np.zeros(self.on.shape), [corners], 1.0), np.float64)

    def _contour(self, level: Array) -> Array | None:
        """(n, 2) metres, where half shows the class; None: nowhere, or it is no simple polygon."""
        if not (level > 0.5).any():
            return None
        found = simplified(subpixel_contour(level, Path(self.marker.name)) * (1, -1)) * self.step + self.corner
        bad = len(found) < 3 or folded_corner(found) is not None or crossing_edges(found) is not None
        return None if bad else found

    def _hole(self, level: Array) -> Array | None:
        """(2,) metres, the middle of the largest one."""
        mask = (level > 0.5).astype(np.uint8)
        contours, order = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
        holes = [c for c, (*_, parent) in zip(contours, order[0], strict=True) if parent >= 0] if contours else []
        largest = max(holes, key=cv2.contourArea, default=None)
        if largest is None or cv2.contourArea(largest) * self.step**2 < _HOLE * self.marker.area:
            return None
        return np.asarray(largest[:, 0].mean(axis=0) * (1, -1) * self.step + self.corner, np.float64)

    def _in_one_place(self) -> bool:
        turns, at = np.array([i.theta for i in self.seen]), np.array([(i.x, i.y) for i in self.seen])
        size_px = np.median([i.scale for i in self.seen]) * np.sqrt(self.marker.area)
        same = abs(np.exp(1j * turns).mean()) > _ONE_TURN and np.hypot(*at.std(axis=0)) < _ONE_PLACE * size_px
        return bool(same)


def _onto_image(outline: Array, contour: Array) -> Array | None:
    """(3, 3) from a marker's plane to the image; None where its contour there is cut."""
    if len(contour) != len(outline) or not np.isfinite(contour).all():
        return None
    drawn, there = outline.astype(np.float32), contour.astype(np.float32)
    if len(outline) == 3:
        return np.vstack([cv2.getAffineTransform(drawn, there), [0, 0, 1]])
    warp = cv2.findHomography(drawn, there)[0]
    return None if warp is None else np.asarray(warp, np.float64)
