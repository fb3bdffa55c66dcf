"""A picture on which results are drawn: outlines and frames, and texts that find a free place beside them."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .geometry.camera import Camera
from .geometry.transforms import Array
from .model.found import Detection, Instance
from .model.frame_result import Rejection

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]

_AXIS_COLOURS: tuple[Colour, ...] = ((70, 70, 255), (70, 230, 70), (255, 120, 70))  # x red, y green, z blue
_FAINT: Colour = (165, 165, 165)
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_TEXT_WIDTH_PX = 640  # of a picture whose text and lines have their usual size; in wider ones they grow
_USUAL, _SMALL = 0.45, 0.35  # sizes of names and of faint texts
_AWAY = (0, 1, 2, 3, 5, 7)  # how far a text may lie from its object, in its own heights
_CLEAR = 2  # such heights about a cross are free of reasons: it stands on what they speak of, of which no size is known
_SHIFT = 4  # cv2's sub-pixel bits
_LINE_LETTERS = 46  # of a reason


def class_text(detection: Detection) -> str:
    """What follows an object's name and score: its class and how sure that is; nothing where it has no classes."""
    fit = detection.class_fit
    return "" if fit is None else f" {fit.name or 'no class'} {fit.confidence:.2f}"


class Canvas:
    """A picture whose every pixel of the original is `zoom` pixels wide; coordinates are the original's."""

    def __init__(self, picture: Picture, zoom: int) -> None:
        self.picture, self.zoom = picture, zoom
        self._unit = max(1.0, picture.shape[1] / _TEXT_WIDTH_PX)
        self._line = round(self._unit)
        self._taken: list[Area] = []

    def _at(self, points: Array) -> Array:
        """Original pixels (centres at integers) to pixels of the picture."""
        return (np.asarray(points, float) + 0.5) * self.zoom - 0.5

    def _fixed(self, points: Array) -> NDArray[np.int32]:
        limited = np.clip(points, -30000, 30000)
        return np.round(limited * (1 << _SHIFT)).astype(np.int32)

    def polygon(self, points: Array, colour: Colour, thickness: int) -> None:
        cv2.polylines(self.picture, [self._fixed(self._at(points))], True, colour, thickness, cv2.LINE_AA, _SHIFT)

    def line(self, start: Array, end: Array, colour: Colour) -> None:
        a, b = ([int(v) for v in p] for p in self._fixed(self._at(np.stack([start, end]))))
        cv2.line(self.picture, a, b, colour, self._line, cv2.LINE_AA, _SHIFT)

    def arrow(self, start: Array, end: Array, colour: Colour, thickness: int) -> None:
        a, b = self._at(start), self._at(end)
        length = float(np.linalg.norm(b - a))
        if not 1e-3 < length < 1e5:
            return
        tip = min(0.5, 7.0 / length)
        ends = [tuple(int(v) for v in p) for p in self._fixed(np.stack([a, b]))]
        cv2.arrowedLine(self.picture, ends[0], ends[1], colour, thickness, cv2.LINE_AA, _SHIFT, tip)

    def text(self, text: str, corner: tuple[int, int], colour: Colour, size: float) -> None:
        """Text with its lower left corner at a pixel of the picture, on a darkened box: readable on any ground."""
        size, thick = size * self._unit, max(1, round(0.8 * self._unit))
        (width, height), below = cv2.getTextSize(text, _FONT, size, thick)
        x, y = corner
        box = self.picture[max(0, y - height - 2) : y + below, max(0, x - 2) : x + width + 3]
        box[:] = box // 3
        cv2.putText(self.picture, text, corner, _FONT, size, colour, thick, cv2.LINE_AA)

    def label(self, lines: Sequence[str], about: Area, colour: Colour, size: float, least: int = 0) -> bool:
        """Text beside an area where it covers no object and no other text; False: there is no room near by.

        A thin line leads from text that lies apart to what it belongs to. :param least: heights that it lies off.
        """
        sizes = [self._extent(line, size) for line in lines]
        step = max(height for _, height in sizes)
        width, height = max(width for width, _ in sizes), step * len(lines)
        for gap in (away for away in _AWAY if away >= least):
            for area in about.neighbours(width, height, self._line * 4 + gap * step):
                if area.is_in(self.picture.shape) and not any(area.meets(other) for other in self._taken):
                    if gap > 1:
                        ends = area.nearest(about.middle), about.nearest(area.middle)
                        cv2.line(self.picture, *ends, colour, self._line, cv2.LINE_AA)
                    for n, line in enumerate(lines):
                        self.text(line, (area.left, area.top + round((n + 0.75) * step)), colour, size)
                    self._taken.append(area)
                    return True
        return False

    def _extent(self, text: str, size: float) -> tuple[int, int]:
        """Width and height of a line of text with what is around it, in the picture's pixels."""
        (width, height), below = cv2.getTextSize(text, _FONT, size * self._unit, max(1, round(0.8 * self._unit)))
        return width + 4, height + below + 3

    def keep_clear(self, detection: Detection) -> None:
        """Texts shall not cover this object."""
        self._taken += [self._area(c.contour) for c in detection.components if len(c.contour)]

    def _area(self, points: Array) -> Area:
        corners = np.clip(self._at(np.stack([points.min(axis=0), points.max(axis=0)])), -30000, 30000)
        (left, top), (right, bottom) = corners.astype(int).tolist()
        return Area(left, top, right, bottom)

    def footer(self, text: str) -> None:
        """A whole text along the bottom, in as many lines as it takes."""
        width, height = self._extent(text, _SMALL)
        lines = textwrap.wrap(text, max(20, int(len(text) * (self.picture.shape[1] - 8) / width)))
        for i, line in enumerate(reversed(lines)):
            self.text(line, (4, self.picture.shape[0] - height // 3 - 2 - i * height), _FAINT, _SMALL)

    def instance(self, instance: Instance, colour: Colour) -> None:
        centre = np.array([instance.x, instance.y])
        reach = 4.0
        if len(instance.contour) >= 3:
            self.polygon(instance.contour, (20, 20, 20), self._line + 2)
            self.polygon(instance.contour, colour, self._line)
            direction = np.array([np.cos(instance.theta), np.sin(instance.theta)])
            reach = float(((instance.contour - centre) @ direction).max())
        axis = reach * np.array([np.cos(instance.theta), np.sin(instance.theta)])
        self.arrow(centre, centre + 0.85 * axis, (20, 20, 20), self._line + 2)
        self.arrow(centre, centre + 0.85 * axis, colour, self._line)

    def frame(self, detection: Detection, camera: Camera) -> None:
        """The object's frame: arrows along its axes, about a third of the object long."""
        pose = detection.pose
        if pose is None or pose.position[2] <= 0:
            return
        extents = [float(np.ptp(c.contour, axis=0).max()) for c in detection.components if len(c.contour)]
        extent_px = max(extents, default=20.0)
        length = 0.4 * extent_px / camera.matrix[0, 0] * float(pose.position[2])
        points = pose.apply(np.vstack([np.zeros(3), length * np.eye(3)]))  # (4, 3)
        if np.any(points[:, 2] <= 1e-6):
            return
        pixels = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, camera.distortion)[0][:, 0]
        for end, colour in zip(pixels[1:], _AXIS_COLOURS, strict=True):
            self.arrow(pixels[0], end, (20, 20, 20), self._line + 3)
            self.arrow(pixels[0], end, colour, self._line + 1)

    def expected(self, detection: Detection, colour: Colour, camera: Camera | None) -> None:
        """Faintly, the frame of an object that is not seen, or where its required component should be."""
        plain = self.picture.copy()
        if camera is not None and not detection.frame_id:
            self.frame(detection, camera)
        at = np.array([detection.image.x, detection.image.y])
        place = tuple(int(v) for v in self._at(at))
        cv2.circle(self.picture, place, round(9 * self._unit), colour, self._line, cv2.LINE_AA)
        self.picture[:] = cv2.addWeighted(self.picture, 0.5, plain, 0.5, 0.0)

    def name(self, detection: Detection, colour: Colour) -> None:
        """Name, score and class; the name alone where there is room for no more, nothing where there is none."""
        contours = [c.contour for c in detection.components if len(c.contour)]
        about = self._area(np.vstack(contours or [np.array([[detection.image.x, detection.image.y]])]))
        name = f"({detection.name})" if detection.predicted else detection.name
        if not self.label([f"{name}: {detection.score:.2f}{class_text(detection)}"], about, colour, _USUAL):
            self.label([name], about, colour, _SMALL)

    def cross(self, rejection: Rejection) -> None:
        """Where a candidate was turned down; reasons shall not cover what is there."""
        area = self._cross(rejection)
        cv2.drawMarker(
            self.picture, area.middle, _FAINT, cv2.MARKER_TILTED_CROSS, area.right - area.left, self._line, cv2.LINE_AA
        )
        clear = _CLEAR * self._extent("Ay", _SMALL)[1]
        self._taken.append(Area(area.left - clear, area.top - clear, area.right + clear, area.bottom + clear))

    def reason(self, rejection: Rejection, others: int, in_any_case: bool) -> None:
        """The whole reason beside the cross or, if it is wanted in any case, along the bottom."""
        text = f"{rejection.object}: {rejection.reason}" + (f" (+{others})" if others else "")
        lines = textwrap.wrap(text, _LINE_LETTERS)
        if not self.label(lines, self._cross(rejection), _FAINT, _SMALL, _CLEAR) and in_any_case:
            self.footer(text)

    def _cross(self, rejection: Rejection) -> Area:
        x, y = (int(v) for v in self._at(np.array([rejection.x, rejection.y])))
        reach = round(4.5 * self._unit)
        return Area(x - reach, y - reach, x + reach, y + reach)


@dataclass(frozen=True)
class Area:
    """A rectangle of the picture, its last pixels included."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def middle(self) -> tuple[int, int]:
        return (self.left + self.right) // 2, (self.top + self.bottom) // 2

    def nearest(self, point: tuple[int, int]) -> tuple[int, int]:
        """Of its points the one nearest to another."""
        return min(max(point[0], self.left), self.right), min(max(point[1], self.top), self.bottom)

    def meets(self, other: Area) -> bool:
        return (
            self.left <= other.right
            and other.left <= self.right
            and self.top <= other.bottom
            and other.top <= self.bottom
        )

    def is_in(self, shape: tuple[int, ...]) -> bool:
        return self.left >= 2 and self.top >= 1 and self.right < shape[1] - 1 and self.bottom < shape[0] - 1

    def neighbours(self, width: int, height: int, gap: int) -> Iterator[Area]:
        """Places for an area of that size so far above, below, right, left, and at the corners."""
        x, y = self.middle[0] - width // 2, self.middle[1] - height // 2
        left, right, above, below = (
            self.left - gap - width,
            self.right + gap,
            self.top - gap - height,
            self.bottom + gap,
        )
        corners = ((right, above), (right, below), (left, above), (left, below))
        for x0, y0 in ((x, above), (x, below), (right, y), (left, y), *corners):
            yield Area(x0, y0, x0 + width, y0 + height)
