"""Overlays: what was recognised, drawn over the image. Used by `artrec replay` and by the node's debug image."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .datatypes import Camera, Detection, FrameResult, Instance, Rejection
from .transforms import Array

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]

# BGR of class numbers 0..7, muted so that outlines stand out; higher numbers get hues of their own
_CLASS_COLOURS = np.array(
    [[38, 34, 32], [66, 92, 62], [150, 92, 52], [62, 58, 158], [58, 118, 186], [196, 196, 196], [78, 168, 184],
     [172, 150, 98]],
    np.uint8,
)  # fmt: skip
_OBJECT_COLOURS: tuple[Colour, ...] = (  # BGR, bright, far from each other and from the class colours
    (120, 255, 120), (255, 120, 255), (0, 220, 255), (255, 220, 60), (90, 150, 255), (255, 255, 255),
)  # fmt: skip
_AXIS_COLOURS: tuple[Colour, ...] = ((70, 70, 255), (70, 230, 70), (255, 120, 70))  # x red, y green, z blue
_FAINT: Colour = (165, 165, 165)
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_LEAST_WIDTH_PX = 600
_MOST_REJECTIONS, _LONGEST_REASON = 4, 46
_NEAR_PX, _CLUSTER_PX = 3.0, 25.0  # of the original image
_SMALL = 0.35  # size of faint texts
_SHIFT = 4  # cv2's sub-pixel bits


def class_picture(labels: NDArray[Any]) -> Picture:
    """What the recogniser saw: (H, W) class numbers as a (H, W, 3) uint8 BGR picture of the same size.

    The same number always has the same colour, 0 (no class) a dark one; numbers of 255 and above share one.
    """
    hues = (np.arange(256) * 67 % 180).astype(np.uint8)
    hsv = np.stack([hues, np.full(256, 110, np.uint8), np.full(256, 170, np.uint8)], axis=-1)[None]
    table = cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0]
    table[: len(_CLASS_COLOURS)] = _CLASS_COLOURS
    return np.asarray(table[np.minimum(labels, 255)], np.uint8)


def draw_result(
    image: NDArray[Any], result: FrameResult, object_names: Sequence[str], camera: Camera | None = None
) -> Picture:
    """An overlay picture: outlines, axes, frames, names with scores, and, faint, rejected candidates.

    :param image: (H, W) class numbers, or (H, W, 3) uint8 BGR. Small images are enlarged so that text can be read.
    :param object_names: their order decides the colours.
    :param camera: needed for the objects' frames.
    """
    zoom = max(1, round(_LEAST_WIDTH_PX / max(image.shape[1], 1)))
    base = class_picture(image) if image.ndim == 2 else image
    interpolation = cv2.INTER_NEAREST if image.ndim == 2 else cv2.INTER_CUBIC
    picture = np.ascontiguousarray(cv2.resize(base, None, fx=zoom, fy=zoom, interpolation=interpolation))
    canvas = _Canvas(np.asarray(picture, np.uint8), zoom)
    for detection in result.detections:
        colour = object_colour(object_names, detection.object)
        for instance in detection.components:
            canvas.instance(instance, colour)
        if camera is not None and detection.pose is not None:
            canvas.frame(detection, camera)
    for detection in result.detections:  # names after all outlines: nothing covers them
        canvas.name(detection, object_colour(object_names, detection.object))
    for detection in result.detections:
        canvas.keep_clear(detection)
    told = _told_rejections(result)
    for rejection, others in told:
        canvas.rejection(rejection, others)
    if told and len(told[0][0].reason) > _LONGEST_REASON:
        canvas.footer(f"{told[0][0].object}: {told[0][0].reason}")
    return canvas.picture


def draw_error(size: tuple[int, int], error: str) -> Picture:
    """A dark picture of `size` (width, height) that says why a frame could not be used."""
    canvas = _Canvas(np.full((size[1], size[0], 3), 40, np.uint8), 1)
    width = max(1, size[0] // 8)
    for i in range(0, len(error), width):
        canvas.text(error[i : i + width], (6, 20 + 16 * (i // width)), (120, 160, 255), 0.4)
    return canvas.picture


def object_colour(object_names: Sequence[str], name: str) -> Colour:
    """The BGR colour of an object, by its place among the names."""
    place = list(object_names).index(name) if name in object_names else len(object_names)
    return _OBJECT_COLOURS[place % len(_OBJECT_COLOURS)]


def class_text(detection: Detection) -> str:
    """What follows an object's name and score: its class and how sure that is; nothing where it has no classes."""
    fit = detection.class_fit
    return "" if fit is None else f" {fit.name or 'no class'} {fit.confidence:.2f}"


def _told_rejections(result: FrameResult) -> list[tuple[Rejection, int]]:
    """The rejected candidates worth a text, and how many others lie near each.

    Of neighbours the best, a few in all; none that has no place, or lies on an object that was found.
    """
    outlines = [np.float32(c.contour) for d in result.detections for c in d.components if len(c.contour) >= 3]
    told: list[tuple[Rejection, int]] = []
    for rejection in sorted(result.rejected, key=lambda r: -r.score):
        place = (float(rejection.x), float(rejection.y))
        if place == (0.0, 0.0) or any(cv2.pointPolygonTest(o, place, True) > -_NEAR_PX for o in outlines):
            continue
        for i, (known, others) in enumerate(told):
            if known.object == rejection.object and np.hypot(known.x - place[0], known.y - place[1]) < _CLUSTER_PX:
                told[i] = (known, others + 1)
                break
        else:
            told.append((rejection, 0))
    return told[:_MOST_REJECTIONS]


class _Canvas:
    """A picture whose every pixel of the original is `zoom` pixels wide; coordinates are the original's."""

    def __init__(self, picture: Picture, zoom: int) -> None:
        self.picture, self.zoom = picture, zoom
        self._taken: list[tuple[int, int, int, int]] = []  # x, y of the lower left corner, width, height

    def _at(self, points: Array) -> Array:
        """Original pixels (centres at integers) to pixels of the picture."""
        return (np.asarray(points, float) + 0.5) * self.zoom - 0.5

    def _fixed(self, points: Array) -> NDArray[np.int32]:
        limited = np.clip(points, -30000, 30000)
        return np.round(limited * (1 << _SHIFT)).astype(np.int32)

    def polygon(self, points: Array, colour: Colour, thickness: int) -> None:
        cv2.polylines(self.picture, [self._fixed(self._at(points))], True, colour, thickness, cv2.LINE_AA, _SHIFT)

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
        (width, height), below = cv2.getTextSize(text, _FONT, size, 1)
        x, y = corner
        box = self.picture[max(0, y - height - 2) : y + below, max(0, x - 2) : x + width + 3]
        box[:] = box // 3
        cv2.putText(self.picture, text, corner, _FONT, size, colour, 1, cv2.LINE_AA)

    def label(self, text: str, centre_x: float, bottom: float, colour: Colour, size: float) -> None:
        """Text around a place of the picture, kept within it and moved so that it covers no other text."""
        (width, height), below = cv2.getTextSize(text, _FONT, size, 1)
        lowest = self.picture.shape[0] - below - 1
        step = height + below + 3
        x = int(np.clip(centre_x - width / 2, 3, max(3, self.picture.shape[1] - width - 4)))
        y = int(np.clip(bottom, height + 3, max(height + 3, lowest)))
        for candidate in [y + sign * i * step for i in range(5) for sign in (-1, 1)]:
            if height + 3 <= candidate <= lowest and not self._is_taken(x, candidate, width, step):
                y = candidate
                break
        self._taken.append((x, y, width, step))
        self.text(text, (x, y), colour, size)

    def keep_clear(self, detection: Detection) -> None:
        """Later texts shall not cover this object, where there is room for them elsewhere."""
        for contour in (c.contour for c in detection.components if len(c.contour)):
            corners = np.clip(self._at(np.stack([contour.min(axis=0), contour.max(axis=0)])), -30000, 30000)
            (left, top), (right, bottom) = corners.astype(int).tolist()
            self._taken.append((left, bottom, right - left, bottom - top))

    def footer(self, text: str) -> None:
        """A whole text along the bottom, in as many lines as it takes."""
        (width, height), below = cv2.getTextSize(text, _FONT, _SMALL, 1)
        per_line = max(20, int(len(text) * (self.picture.shape[1] - 8) / max(width, 1)))
        lines = textwrap.wrap(text, per_line)
        for i, line in enumerate(reversed(lines)):
            self.text(line, (4, self.picture.shape[0] - below - 2 - i * (height + below + 2)), _FAINT, _SMALL)

    def _is_taken(self, x: int, y: int, width: int, height: int) -> bool:
        return any(x < x1 + w and x1 < x + width and y - height < y1 and y1 - h < y for x1, y1, w, h in self._taken)

    def instance(self, instance: Instance, colour: Colour) -> None:
        centre = np.array([instance.x, instance.y])
        reach = 4.0
        if len(instance.contour) >= 3:
            self.polygon(instance.contour, (20, 20, 20), 3)
            self.polygon(instance.contour, colour, 1)
            direction = np.array([np.cos(instance.theta), np.sin(instance.theta)])
            reach = float(np.abs((instance.contour - centre) @ direction).max())
        axis = reach * np.array([np.cos(instance.theta), np.sin(instance.theta)])
        self.arrow(centre, centre + 0.85 * axis, (20, 20, 20), 3)
        self.arrow(centre, centre + 0.85 * axis, colour, 1)

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
            self.arrow(pixels[0], end, (20, 20, 20), 4)
            self.arrow(pixels[0], end, colour, 2)

    def name(self, detection: Detection, colour: Colour) -> None:
        contours = [c.contour for c in detection.components if len(c.contour)]
        centre = np.array([detection.image.x, detection.image.y])
        top = np.vstack(contours)[:, 1].min() if contours else centre[1] - 6
        x, bottom = self._at(np.array([centre[0], top]))
        text = f"{detection.object}_{detection.id}: {detection.score:.2f}{class_text(detection)}"
        self.label(text, x, bottom - 8, colour, 0.45)

    def rejection(self, rejection: Rejection, others: int) -> None:
        x, y = self._at(np.array([rejection.x, rejection.y]))
        cv2.drawMarker(self.picture, (int(x), int(y)), _FAINT, cv2.MARKER_TILTED_CROSS, 9, 1, cv2.LINE_AA)
        reason = (
            rejection.reason if len(rejection.reason) <= _LONGEST_REASON else rejection.reason[:_LONGEST_REASON] + "..."
        )
        more = f" (+{others})" if others else ""
        self.label(f"{rejection.object}: {reason}{more}", x, y - 8, _FAINT, _SMALL)
