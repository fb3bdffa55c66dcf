"""Metres for a marker's picture: from its measured sides, or from a rectangle of known size that lies around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array

_MEASURING = 0.02  # share by which the ratio of two sides is off in a straight photo: contour, lens, ruler
_TURN_DEG = 1.0  # by so much a picture may be turned in its own plane
_GREATEST_SLANT_DEG = 55.0  # beyond, corners are in another order than the sides, or the shape is too squeezed to read
_CUT = 0.01  # share of the rectangle's shorter side that is cut off along its rim, whose line is no background


def in_metres(outline: Array, width_m: float, height_m: float | None, place: str) -> Array:
    """The outline, in metres and about the middle of its bounding box.

    :param outline: (n, 2) in pixels, x right, y up.
    :param width_m: measured width of the bounding box. :param height_m: its measured height, where it is known.
    :raises ConfigError: the two do not go together with the outline: the picture was taken at a slant.
    """
    low, high = outline.min(axis=0), outline.max(axis=0)
    pictured = high - low
    if height_m is None:
        scale = np.full(2, width_m / pictured[0])
    else:
        scale = np.array([width_m, height_m]) / pictured
        if abs(float(np.log(scale[1] / scale[0]))) > ratio_tolerance(outline):
            raise ConfigError(_slanted(pictured, width_m, height_m, float(scale[1] / scale[0]), place))
    return np.asarray((outline - (low + high) / 2) * scale)


def ratio_tolerance(outline: Array) -> float:
    """By how much height / width of a picture taken straight from in front may differ from the truth, as logarithm.

    A turn in the picture's own plane makes a bounding box of other sides: of a long strip by much.
    """
    ratios = []
    for angle in np.radians([-_TURN_DEG, 0.0, _TURN_DEG]):
        c, s = np.cos(angle), np.sin(angle)
        width, height = np.ptp(outline @ np.array([[c, s], [-s, c]]), axis=0)
        ratios.append(np.log(height / width))
    return float(_MEASURING + max(abs(r - ratios[1]) for r in ratios))


def _slanted(pictured: Array, width_m: float, height_m: float, ratio: float, place: str) -> str:
    slant = np.degrees(np.arccos(min(ratio, 1 / ratio)))
    return (
        f"{place}: with its width of {width_m:.4g} m the picture has it {width_m * pictured[1] / pictured[0]:.4g} m "
        f"high, not {height_m:.4g} m: it was taken at a slant of some {slant:.0f} degrees, some of a background that "
        "is not plain was taken for the marker, or one of the two is wrong; take it straight from in front, on one "
        "colour, or straighten it by a rectangle around it (--corners, --rectangle)"
    )


@dataclass(frozen=True)
class KnownRectangle:
    """A flat rectangle of known size, in the plane of the marker and around it, as the picture shows it.

    :param corners: (4, 2) pixels of the picture: upper left, upper right, lower right, lower left of the rectangle.
    :param size_m: its width (upper left to upper right) and height, metres.
    :raises ConfigError: corners that go round the wrong way or cross, or that no such rectangle shows.
    """

    corners: Array
    size_m: tuple[float, float]

    def __post_init__(self) -> None:
        corners = np.array(self.corners, float).reshape(4, 2)
        corners.setflags(write=False)
        object.__setattr__(self, "corners", corners)
        ahead = np.roll(corners, -1, axis=0) - corners
        after = np.roll(ahead, -1, axis=0)
        if np.any(ahead[:, 0] * after[:, 1] - ahead[:, 1] * after[:, 0] <= 0):
            raise ConfigError(
                f"--corners: {_shown(corners)} do not go round a rectangle clockwise; give x y of its upper left, "
                "upper right, lower right and lower left corner"
            )
        if self.slant_deg > _GREATEST_SLANT_DEG:
            raise ConfigError(
                f"--corners, --rectangle: {_shown(corners)} would show {self.size_m[0]:g} x {self.size_m[1]:g} m at "
                f"a slant of {self.slant_deg:.0f} degrees; is its width, from first to second corner, given first?"
            )

    @property
    def slant_deg(self) -> float:
        """How far the rectangle is turned out of the picture's plane, about: by its middle's squeeze."""
        to_picture = np.linalg.inv(self._to_metres(self.corners))
        x, y, w = to_picture @ (self.size_m[0] / 2, self.size_m[1] / 2, 1.0)
        jacobian = (to_picture[:2, :2] - np.outer((x / w, y / w), to_picture[2, :2])) / w  # pixels per metre
        most, least = np.linalg.svd(jacobian, compute_uv=False)
        return float(np.degrees(np.arccos(min(1.0, least / most))))

    def straightened(self, image: NDArray, greatest_px: int, smooth: bool) -> tuple[NDArray, float]:
        """What lies within the rectangle, seen straight from in front, and its pixels per metre.

        :param greatest_px: greatest side of the result; a larger picture is shrunk.
        :param smooth: mix neighbouring pixels; not for class numbers.
        :raises ConfigError: a corner lies outside the picture.
        """
        extent = image.shape[1::-1]
        if np.any(self.corners < -1) or np.any(self.corners > extent):
            size = f"{extent[0]} x {extent[1]} pixels"
            raise ConfigError(f"--corners: {_shown(self.corners)} are not all within the picture of {size}")
        seen = np.linalg.norm(self.corners - np.roll(self.corners, -1, axis=0), axis=1)
        shrink = min(1.0, greatest_px / float(seen.max())) if smooth else 1.0
        if shrink < 1:
            image = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
        corners = (self.corners + 0.5) * shrink - 0.5
        cut = _CUT * min(self.size_m)
        width, height = self.size_m[0] - 2 * cut, self.size_m[1] - 2 * cut
        zoom = min(float(seen.max()) * shrink, greatest_px) / max(width, height)
        to_pixels = np.diag([zoom, zoom, 1.0]) @ [[1, 0, -cut], [0, 1, -cut], [0, 0, 1]]
        shape = max(8, round(width * zoom)), max(8, round(height * zoom))
        method = cv2.INTER_LINEAR if smooth else cv2.INTER_NEAREST
        return cv2.warpPerspective(image, to_pixels @ self._to_metres(corners), shape, flags=method), zoom

    def _to_metres(self, corners: Array) -> Array:
        """(3, 3) homography from pixels to metres from the upper left corner, y down."""
        width, height = self.size_m
        metres = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
        return np.asarray(cv2.getPerspectiveTransform(corners.astype(np.float32), metres), float)


def check_side(name: str, given_m: float | None, found_m: float, tolerance: float, place: str) -> None:
    """:raises ConfigError: a measured side is not what the rectangle makes of it."""
    if given_m is not None and abs(float(np.log(found_m / given_m))) > tolerance:
        raise ConfigError(
            f"{place}: by its rectangle the marker's {name} is {found_m:.4g} m, and not {given_m:.4g} m as given; "
            "check --rectangle, --corners and that the marker lies flat within it"
        )


def _shown(corners: Sequence[Sequence[float]] | Array) -> str:
    return ", ".join(f"{x:g} {y:g}" for x, y in corners)
