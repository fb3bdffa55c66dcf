"""Marker outlines made ready for alignment: evenly spaced samples, normals, anchors, symmetry."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import cv2
import numpy as np

from ..base.config import AlignmentConfig
from ..geometry.polygons import signed_area
from ..geometry.transforms import Array
from ..image.blobs import anchor_points
from ..model.marker import Marker
from .start_kernels import ShapeArrays
from .symmetry import Symmetry, find_symmetry

SAMPLES = 120  # contour points per shape, the same for all so that shapes share a batch
_MOST_CORNERS = 600  # of an outline: of a finer one, as many places evenly along it; it costs with each corner
_INSIDE_GRID = 12  # cells across the longer side: overlaps are told to a percent of the area


@dataclass(frozen=True, eq=False)
class Shape:
    """One outline, however many components and markers show it.

    Points are in metres about the centroid, x right, y down, so that an image similarity places them.
    Complex arrays hold x + iy.

    :param points: (SAMPLES,) complex, evenly spaced along the outline, inside as in `Blob`.
    :param normals: (SAMPLES,) complex unit outward normals.
    :param anchors: (a,) complex.
    :param inside: (g,) complex, a grid of points that fills the outline.
    :param rms_radius_m: root of the mean squared distance of `points` from the centroid.
    """

    outline: Array
    points: np.ndarray
    normals: np.ndarray
    anchors: np.ndarray
    inside: np.ndarray
    area_m2: float
    perimeter_m: float
    rms_radius_m: float
    is_disc: bool
    symmetry: Symmetry

    @classmethod
    def from_marker(cls, marker: Marker, config: AlignmentConfig | None = None) -> Shape:
        """:param config: what its anchors are made by; None: the default."""
        anchor_share = (config or AlignmentConfig()).anchor_share
        outline = np.array(marker.image_outline)
        if signed_area(outline) < 0:
            outline = outline[::-1]
        if len(outline) > _MOST_CORNERS:
            outline = _sample(outline, _MOST_CORNERS)[0]
        points, normals, perimeter = _sample(outline, SAMPLES)
        z = points @ np.array([1, 1j])
        anchors = anchor_points(outline, anchor_share * float(np.sqrt(marker.area)))
        return cls(
            outline=outline,
            points=z,
            normals=normals,
            anchors=anchors @ np.array([1, 1j]),
            inside=_inside_points(outline),
            area_m2=marker.area,
            perimeter_m=perimeter,
            rms_radius_m=float(np.sqrt(np.mean(np.abs(z) ** 2))),
            is_disc=marker.disc_radius is not None,
            symmetry=find_symmetry(points, outline),
        )

    @cached_property
    def corners(self) -> np.ndarray:
        """(n,) complex, the outline's vertices."""
        return self.outline @ np.array([1, 1j])

    def key(self) -> bytes:
        """Equal for markers of the same outline."""
        return np.round(self.outline, 9).tobytes()


def _sample(outline: Array, count: int) -> tuple[Array, np.ndarray, float]:
    side = np.roll(outline, -1, axis=0) - outline
    length = np.hypot(side[:, 0], side[:, 1])
    ends = np.concatenate([[0.0], np.cumsum(length)])
    s = (np.arange(count) + 0.5) * ends[-1] / count
    at = np.clip(np.searchsorted(ends, s, side="right") - 1, 0, len(side) - 1)
    unit = side / np.maximum(length, 1e-12)[:, None]
    points = outline[at] + (s - ends[at])[:, None] * unit[at]
    normals = unit[at, 1] - 1j * unit[at, 0]  # the tangent turned outward
    return points, normals, float(ends[-1])


def _inside_points(outline: Array) -> np.ndarray:
    low, high = outline.min(axis=0), outline.max(axis=0)
    step = float((high - low).max()) / _INSIDE_GRID
    xs, ys = (np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True))
    grid = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    polygon = (outline / step).astype(np.float32)[:, None]  # in cells: float32 keeps its digits
    inside = [cv2.pointPolygonTest(polygon, (float(px), float(py)), False) >= 0 for px, py in grid / step]
    kept = grid[np.array(inside, bool)] if any(inside) else np.zeros((1, 2))
    return kept @ np.array([1, 1j])


@lru_cache(maxsize=8)
def pack_shapes(shapes: tuple[Shape, ...]) -> ShapeArrays:
    """Shapes as compiled code takes them."""
    points = np.stack([s.points for s in shapes])
    return ShapeArrays(
        points,
        np.stack([s.normals for s in shapes]),
        np.ascontiguousarray(points.real),
        np.ascontiguousarray(points.imag),
        np.array([s.area_m2 for s in shapes]),
        np.array([s.rms_radius_m for s in shapes]),
        np.stack([s.symmetry.residual_m for s in shapes]),
    )
