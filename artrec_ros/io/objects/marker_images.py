"""A marker's outline from a photo or a label image: taken straight from in front, or straightened by a rectangle."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.base.errors import ConfigError, ImageError
from ...core.geometry.transforms import Array
from ..images.decoding import read_image
from .marker_shapes import LooseMarker, marker_of, safe_name, simplified, with_sharp_corners
from .measured_sizes import KnownRectangle, check_side, in_metres, ratio_tolerance
from .outlines import subpixel_contour

_GREATEST_SIDE_PX = 1500  # a larger photo is shrunk: its outline has more detail than a camera will see
_MOST_CLASSES = 32  # an image of one channel with smaller numbers only holds classes, not brightness
_LIGHTNESS = 0.5  # weight of lightness against colour: shadows are darker, not of another colour
_LEAST_CONTRAST = 12.0  # of the shape against its background, in units of CIE Lab
_BORDER_PX = 2


def image_marker(
    path: Path,
    width_m: float | None,
    label: int | None = None,
    height_m: float | None = None,
    rectangle: KnownRectangle | None = None,
) -> LooseMarker:
    """The marker that an image shows, named after the file.

    :param width_m: width of the shape's bounding box, metres; needed where there is no rectangle.
    :param label: its class, in a label image; None: the class of the largest shape that is not the background.
    :param height_m: the bounding box's height, metres: shows whether the picture was taken at a slant.
    :param rectangle: lies around the marker: straightens the picture, and gives its size.
    :raises ConfigError: no image, no shape, one that touches the image's border, or sizes that disagree with it.
    """
    image = _read(path)
    classes, zoom = _holds_classes(image, label), None
    if rectangle is not None:
        image, zoom = rectangle.straightened(image, _GREATEST_SIDE_PX, smooth=not classes)
    outline = with_sharp_corners(simplified(_contour(image, classes, label, path) * (1, -1)))
    if zoom is not None:
        width, height = np.ptp(outline, axis=0) / zoom
        check_side("width", width_m, width, ratio_tolerance(outline), str(path))
        check_side("height", height_m, height, ratio_tolerance(outline), str(path))
        width_m, height_m = width, None
    if width_m is None:
        raise ConfigError(f"{path}: its width is needed, in metres")
    name = safe_name(path.stem)
    return LooseMarker(name, marker_of(name, in_metres(outline, width_m, height_m, str(path)), str(path)))


def _read(path: Path) -> NDArray:
    try:
        image = read_image(path) if path.is_file() else None
    except ImageError as error:
        raise ConfigError(f"{path}: {error}") from None
    if image is None:
        raise ConfigError(f"{path}: there is no such file")
    return image


def _contour(image: NDArray, classes: bool, label: int | None, path: Path) -> Array:
    """(n, 2) pixels, y down, of the largest shape."""
    level = _class_level(image, label, path) if classes else _photo_level(image, path)
    contour = subpixel_contour(level, path)
    edge = np.array(level.shape[::-1]) - 1
    if np.any(contour.min(axis=0) < _BORDER_PX - 1) or np.any(contour.max(axis=0) > edge - _BORDER_PX + 1):
        raise ConfigError(
            f"{path}: the shape touches the image's border; leave some background all around it, also within the sheet "
            "that --corners mark"
        )
    return contour


def _holds_classes(image: NDArray, label: int | None) -> bool:
    if image.ndim == 2:
        return label is not None or int(image.max()) < _MOST_CLASSES
    return False


def _class_level(image: NDArray, label: int | None, path: Path) -> Array:
    """(H, W) 1 on the class, 0 elsewhere."""
    found = sorted(int(v) for v in np.unique(image))
    if label is not None:
        if label not in found:
            shown = ", ".join(map(str, found[:_MOST_CLASSES]))
            raise ConfigError(f"{path}: no pixel is of class {label} (there are: {shown})")
        return np.asarray(image == label, float)
    background = int(np.bincount(_border(image).reshape(-1)).argmax())
    others = [v for v in found if v != background]
    if not others:
        raise ConfigError(f"{path}: the image holds class {background} only; a shape on a background is wanted")
    return np.asarray(image == max(others, key=lambda v: _largest_area(image == v)), float)


def _largest_area(mask: NDArray) -> float:
    contours = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    return max(cv2.contourArea(c) for c in contours)


def _photo_level(image: NDArray, path: Path) -> Array:
    """(H, W) 0 on the background's colour, 1 on the shape's, between them on a soft edge."""
    if image.dtype != np.uint8:
        image = np.asarray(image >> 8, np.uint8)
    shrink = _GREATEST_SIDE_PX / max(image.shape[:2])
    if shrink < 1:
        image = np.asarray(cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA), np.uint8)
    bgr = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if image.ndim == 2 else image
    lab = cv2.cvtColor(bgr.astype(np.float32) / 255, cv2.COLOR_BGR2Lab) * np.array([_LIGHTNESS, 1, 1], np.float32)
    background = np.median(_border(lab).reshape(-1, 3), axis=0)
    distance = np.linalg.norm(lab - background, axis=2)
    scale = float(distance.max())
    if scale < _LEAST_CONTRAST:
        raise ConfigError(f"{path}: the image has one colour only; a shape on a plain background is wanted")
    threshold, _ = cv2.threshold((distance / scale * 255).astype(np.uint8), 0, 255, cv2.THRESH_OTSU)
    shape = distance[distance > threshold / 255 * scale]
    return np.asarray(np.clip(distance / float(np.median(shape)), 0, 1), float)


def _border(image: NDArray) -> NDArray:
    """The pixels along the image's four sides."""
    b = _BORDER_PX
    sides = [image[:b], image[-b:], image[:, :b].swapaxes(0, 1), image[:, -b:].swapaxes(0, 1)]
    return np.concatenate(sides, axis=1)
