"""Overlays: what was recognised, drawn over the image. Used by `artrec replay` and by the node's debug image."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .canvas import Canvas, Colour, Picture
from .geometry.camera import Camera
from .model.frame_result import FrameResult, Rejection

# BGR of class numbers 0..7, muted so that outlines stand out; higher numbers get hues of their own
_CLASS_COLOURS = np.array(
    [[38, 34, 32], [66, 92, 62], [150, 92, 52], [62, 58, 158], [58, 118, 186], [196, 196, 196], [78, 168, 184],
     [172, 150, 98]],
    np.uint8,
)  # fmt: skip
_OBJECT_COLOURS: tuple[Colour, ...] = (  # BGR, bright, far from each other and from the class colours
    (120, 255, 120), (255, 120, 255), (0, 220, 255), (255, 220, 60), (90, 150, 255), (255, 255, 255),
)  # fmt: skip
_NAMED_COLOURS: dict[str, Colour] = {  # BGR, bright: what objects are drawn in that are named after a colour
    "red": (80, 80, 255), "green": (90, 235, 90), "blue": (255, 150, 70), "yellow": (50, 235, 255),
    "orange": (40, 155, 255), "white": (255, 255, 255), "black": (150, 150, 150), "grey": (190, 190, 190),
    "gray": (190, 190, 190), "cyan": (255, 235, 60), "sky": (255, 215, 120), "turquoise": (210, 225, 60),
    "magenta": (255, 90, 255), "pink": (200, 150, 255), "violet": (255, 110, 180), "purple": (255, 110, 180),
    "brown": (70, 120, 180),
}  # fmt: skip
_MUTED = 0.75  # brightness of a class, against an object's: outlines stand out
_LEAST_LENGTH_PX = 600
_MOST_REJECTIONS = 4
_NUMBER = re.compile(r"-?\d[\d.]*")
_NEAR_PX, _CLUSTER_PX = 3.0, 25.0  # of the original image


def but_for_numbers(rejection: Rejection) -> str:
    """An object's name and a reason: those that differ by numbers alone say the same."""
    return _NUMBER.sub("", f"{rejection.object}: {rejection.reason}")


def class_picture(labels: NDArray[Any], classes: Sequence[tuple[str, int]] = ()) -> Picture:
    """What the recogniser saw: (H, W) class numbers as a (H, W, 3) uint8 BGR picture of the same size.

    The same number always has the same colour, 0 (no class) a dark one; numbers of 255 and above share one.

    :param classes: names and labels: those that are named after a colour are drawn in that, as objects are.
    """
    return np.asarray(_class_table(tuple(classes))[np.minimum(labels, 255)], np.uint8)


@lru_cache(maxsize=8)
def _class_table(classes: tuple[tuple[str, int], ...]) -> NDArray[np.uint8]:
    hues = (np.arange(256) * 67 % 180).astype(np.uint8)
    hsv = np.stack([hues, np.full(256, 110, np.uint8), np.full(256, 170, np.uint8)], axis=-1)[None]
    table = cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0]
    table[: len(_CLASS_COLOURS)] = _CLASS_COLOURS
    named = [(name, label) for name, label in classes if _colour_word(name) is not None]
    names = [name for name, _ in named]
    for name, label in named:
        table[label] = (_MUTED * np.array(object_colour(names, name))).astype(np.uint8)
    return table


def enlargement(image: NDArray[Any]) -> int:
    """How many times as large an image is drawn, so that text can be read in a small one: by its longer side, for one
    that is a pixel wide would fill the memory by its shorter one."""
    return max(1, round(_LEAST_LENGTH_PX / max(*image.shape[:2], 1)))


def draw_result(
    image: NDArray[Any], result: FrameResult, object_names: Sequence[str], camera: Camera | None = None
) -> Picture:
    """An overlay picture: outlines, axes, frames, names with scores, and, faint, objects that are not seen but
    expected, and rejected candidates.

    :param image: (H, W) class numbers, or (H, W, 3) uint8 BGR. Small images are enlarged so that text can be read.
    :param object_names: their order decides the colours.
    :param camera: needed for the objects' frames.
    """
    zoom = enlargement(image)
    base = class_picture(image) if image.ndim == 2 else image
    interpolation = cv2.INTER_NEAREST if image.ndim == 2 else cv2.INTER_CUBIC
    picture = np.ascontiguousarray(cv2.resize(base, None, fx=zoom, fy=zoom, interpolation=interpolation))
    canvas = Canvas(np.asarray(picture, np.uint8), zoom)
    colours = {d.object: object_colour(object_names, d.object) for d in result.detections}
    for detection in result.detections:
        if detection.predicted:
            canvas.expected(detection, colours[detection.object], camera)
            continue
        for instance in detection.components:
            canvas.instance(instance, colours[detection.object])
        if camera is not None and not detection.frame_id:  # of poses in the camera
            canvas.frame(detection, camera)
        canvas.keep_clear(detection)
    for detection in result.detections:  # names after all outlines: nothing covers them
        canvas.name(detection, colours[detection.object])
    told = _told_rejections(result)
    for rejection, _ in told:  # crosses before all reasons: none covers another's
        canvas.cross(rejection)
    said = dict[str, tuple[Rejection, int]]()
    for rejection, others in told:  # the best that says so
        said.setdefault(but_for_numbers(rejection), (rejection, others))
    for n, (rejection, others) in enumerate(said.values()):
        canvas.reason(rejection, others, in_any_case=n == 0)
    if result.waiting and not (result.detections or result.rejected):  # else nothing would say why
        canvas.footer(f"nothing found; blobs that wait their turn: {result.waiting}")
    return canvas.picture


def draw_error(size: tuple[int, int], error: str) -> Picture:
    """A dark picture of `size` (width, height) that says why a frame could not be used."""
    canvas = Canvas(np.full((size[1], size[0], 3), 40, np.uint8), 1)
    width = max(1, size[0] // 8)
    for i in range(0, len(error), width):
        canvas.text(error[i : i + width], (6, 20 + 16 * (i // width)), (120, 160, 255), 0.4)
    return canvas.picture


def object_colour(object_names: Sequence[str], name: str) -> Colour:
    """The BGR colour of an object: that after which it is named, else by its place among the others.

    A second object of the same colour is drawn lighter, a third one darker.
    """
    own = _colour_word(name)
    same = [n for n in object_names if _colour_word(n) == own]
    place = same.index(name) if name in same else len(same)
    if own is None:
        return _OBJECT_COLOURS[place % len(_OBJECT_COLOURS)]
    b, g, r = (int((c, c + 0.55 * (255 - c), 0.6 * c)[place % 3]) for c in _NAMED_COLOURS[own])
    return b, g, r


def _colour_word(name: str) -> str | None:
    """The colour that a name contains as a word; gray is grey."""
    return next((w for w in re.findall("[a-z]+", name.lower()) if w in _NAMED_COLOURS), None)


def _told_rejections(result: FrameResult) -> list[tuple[Rejection, int]]:
    """The rejected candidates worth a text, and how many others lie near each.

    Of neighbours the best, a few in all; none that has no place, or lies on an object that was found, nor a blob that
    led to none where its object was found elsewhere: beside a robot stripes of its colour want no sentence each.
    """
    seen = {d.object for d in result.detections if not d.predicted}
    outlines = [np.float32(c.contour) for d in result.detections for c in d.components if len(c.contour) >= 3]
    told: list[tuple[Rejection, int]] = []
    for rejection in sorted(result.rejected, key=lambda r: -r.score):
        place = (float(rejection.x), float(rejection.y))
        if not rejection.score and rejection.object in seen:
            continue
        if place == (0.0, 0.0) or any(cv2.pointPolygonTest(o, place, True) > -_NEAR_PX for o in outlines):
            continue
        for i, (known, others) in enumerate(told):
            if known.object == rejection.object and np.hypot(known.x - place[0], known.y - place[1]) < _CLUSTER_PX:
                told[i] = (known, others + 1)
                break
        else:
            told.append((rejection, 0))
    return told[:_MOST_REJECTIONS]
