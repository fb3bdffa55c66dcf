"""First guesses of a spatial marker's pose: rigid alignment of its foreshortened outlines with blobs.

A flat marker turned out of the image plane looks, to first order, like its outline squeezed along one
direction. A bank of such views turns the paper's step 4 (couples of consecutive anchors) into 6-DoF guesses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike

from ..base.config import GuessesConfig
from ..geometry.camera import Camera
from ..geometry.polygons import perimeter, signed_area
from ..geometry.projection import normalise
from ..geometry.transforms import Array, rotation_from_rotvec
from ..model.marker import Marker
from ..model.surface import sample_contour, sample_polygon
from . import lifting_kernels as lifting

_FINE = 1e4  # cv2 approximates whole numbers: an extent is so many of them
FACING = np.diag([1.0, -1.0, -1.0])  # marker frame (x right, y up, z out) to the camera's (x right, y down, z ahead)


@dataclass(frozen=True)
class MarkerView:
    """A marker's outline as seen from one direction: turned by `turn` about the image axis across `direction`."""

    turn: float
    direction: float
    outline: Array  # (n, 2) metres, y down, about the marker's centroid
    inside: Array  # (score_points, 2)
    contour: Array  # (score_points, 2)
    contour_normal: Array  # (score_points, 2)
    area: float
    perimeter: float
    anchors: Array  # (a, 2)
    moments: tuple[Array, float]  # of the outline


def view_bank(marker: Marker, config: GuessesConfig, *, facing: bool = False) -> list[MarkerView]:
    """The marker face on, and turned across some of the image's directions. :param facing: face on alone."""
    turns, directions = [(0.0, 0.0)], config.directions
    if facing or marker.is_ball:
        return [_view(marker, 0.0, 0.0, config)]
    if marker.disc_radius is not None:  # a disc squeezed in any direction is the same ellipse turned
        turns += [(turn, 0.0) for turn in config.turns_rad]
    else:
        turns += [(turn, np.pi * i / directions) for turn in config.turns_rad for i in range(directions)]
    return [_view(marker, turn, direction, config) for turn, direction in turns]


def _view(marker: Marker, turn: float, direction: float, config: GuessesConfig) -> MarkerView:
    axis = np.array([np.cos(direction), np.sin(direction)])
    squeeze = np.eye(2) + (np.cos(turn) - 1) * np.outer(axis, axis)
    return view_of(marker.image_outline @ squeeze, marker.area * np.cos(turn), config, turn, direction)


def view_of(
    outline: Array, area: float, config: GuessesConfig, turn: float = 0.0, direction: float = 0.0
) -> MarkerView:
    """What looks like an outline (n, 2) of such an area; both in metres, y down."""
    if signed_area(outline) < 0:  # run round as blobs' contours do
        outline = outline[::-1]
    inside = sample_polygon(outline, config.score_points)
    contour, normal = sample_contour(outline, config.score_points)
    centroid, principal = moments_of(outline * 1e3)  # in mm: cv2 takes a tiny area for none
    return MarkerView(
        turn,
        direction,
        outline,
        inside,
        contour,
        normal,
        area,
        perimeter(outline),
        anchors_of(outline, config.anchor_tolerance),
        (centroid / 1e3, principal),
    )


def anchors_of(outline: Array, tolerance: float) -> Array:
    """Anchor points of a model outline.

    :param tolerance: share of its extent; at a fiftieth a round one is thinned to about a dozen.
    """
    extent = float(np.ptp(outline, axis=0).max())
    scaled = (outline / extent * _FINE).astype(np.int32)
    return cv2.approxPolyDP(scaled, tolerance * _FINE, True).reshape(-1, 2) * (extent / _FINE)


def blob_couples(contour: Array, tolerances_px: tuple[float, ...]) -> tuple[Array, Array]:
    """Couples of consecutive anchors, and of every second one, at several approximation tolerances; each once."""
    couples: dict[tuple[float, ...], None] = {}
    for tolerance in tolerances_px:
        A = cv2.approxPolyDP(contour.astype(np.float32), tolerance, True)[:, 0].tolist()
        for step in (1, 2):
            if len(A) > step:
                couples |= dict.fromkeys((*a, *b) for a, b in zip(A, A[step:] + A[:step], strict=True))
    both = np.array(list(couples), float).reshape(-1, 4)
    return both[:, :2].copy(), both[:, 2:].copy()


def scale_range(area: ArrayLike, area_px: float, config: GuessesConfig, piece: int) -> Array:
    """(..., 2) scales at which views of an area are large enough to be told, and not much larger than their blob.

    :param piece: above 0: of one of several things that make up the blob, the smaller the higher.
    """
    least_px, most_px = config.least_area_px, config.most_area_ratio * area_px + config.most_area_more_px
    if piece:
        most_px = area_px / config.piece_ratio ** (piece - 1)
        least_px = max(least_px, most_px / config.piece_ratio)
    return np.sqrt(np.stack([least_px / np.asarray(area), most_px / np.asarray(area)], axis=-1))


def moments_of(outline: Array) -> tuple[Array, float]:
    """Centroid (2,) and principal axis' direction of an outline (n, 2)."""
    m = cv2.moments(outline.astype(np.float32).reshape(-1, 1, 2))
    if m["m00"] <= 0:
        return outline.mean(axis=0), 0.0
    return np.array([m["m10"], m["m01"]]) / m["m00"], 0.5 * float(np.arctan2(2 * m["mu11"], m["mu20"] - m["mu02"]))


class LongAxis(NamedTuple):
    """Of an outline: from its middle to one of its ends (2,), and how many times as long as wide it is. Of a rectangle
    exactly; which of the ends it is no one knows."""

    half: Array
    ratio: float


def long_axis(outline: Array) -> LongAxis:
    """By the second moments of what an outline (n, 2) encloses."""
    unit = float(np.ptp(outline, axis=0).max()) / _FINE  # cv2 takes a tiny area for none
    m = cv2.moments(((outline - outline.mean(axis=0)) / unit).astype(np.float32).reshape(-1, 1, 2))
    if m["m00"] <= 0:
        return LongAxis(np.zeros(2), 1.0)
    spread = np.array([[m["mu20"], m["mu11"]], [m["mu11"], m["mu02"]]]) / m["m00"]
    variance, axes = np.linalg.eigh(spread)
    across, along = np.sqrt(3 * np.maximum(variance, 0.0))  # halves of a rectangle that has these moments
    return LongAxis(unit * along * axes[:, 1], float(along / max(across, 1e-9)))


def flips_of(turn: Array, direction: Array) -> Array:
    """(2, V, 3, 3) both rotations of a marker that look, to first order, like a view, on the optical axis.

    :param turn, direction: (V,) of the views.
    """
    across = np.column_stack([-np.sin(direction), np.cos(direction), np.zeros(len(turn))])
    return np.stack([rotation_from_rotvec(sign * turn[:, None] * across) @ FACING for sign in (1, -1)])


def lift(flips: Array, view: np.ndarray, T: Array, camera: Camera, origin: Array) -> tuple[Array, Array]:
    """The F 6-DoF poses of each similarity of views: both of a marker's.

    :param flips: (F, V, 3, 3) on the optical axis, of the marker or of a frame that is fixed to it.
    :param view: (H,) of each similarity; T: (H, 4).
    :param origin: (3,) that frame's, from the marker's centroid and along the frame's axes.
    :return: rotations (FH, 3, 3) and origins (FH, 3) of the frame, first all of one flip.
    """
    rays, focal = normalise(camera, T[:, :2]), camera.focal_px
    out = np.empty((len(flips), len(T), 3, 3)), np.empty((len(flips), len(T), 3))
    lifting.lift(flips, view, T, rays, focal, origin, *out)
    return out[0].reshape(-1, 3, 3), out[1].reshape(-1, 3)
