"""A plane of the scene as a camera straight above it would see it.

What lies in the plane is squeezed where a camera sees it at a slant, smaller where it is farther off, bent by a lens.
Seen from above it is a similarity of the image plane, of one scale everywhere. So the image is warped there, objects
are looked for in what comes of it, and what is told of them in pixels is brought back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import FacingConfig
from .field_plane import FieldPlane
from .range_limits import ScaleLimits
from .scene import Scene
from .transforms import Array

_LOOKS = 24  # along each side of the image: where the plane is looked at
_MOST_SIDES = 4.0  # of the view, in the image's longer one
_MOST_PX = 32_766  # of sides that OpenCV looks up
_LEAST_PX = 2.0  # of its sides: a smaller one is none
_EDGE_STEPS = 16  # of each side of a region: lenses bend them
_STEP_PX = 8  # of places that are worked out one by one: a lens bends what is between by a hundredth of a pixel
_NOWHERE = -1e4
Image = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class TopView:
    """:param scene: what is known of the scene, in this view: its plane's pixels are the view's, as are its region's.
    :param seen: the same plane in the image. :param scale: pixels per metre, everywhere.
    :param columns, rows: (h, w) where in the image each of its pixels is.
    """

    scene: Scene
    seen: FieldPlane
    scale: float
    columns: NDArray[np.float32]
    rows: NDArray[np.float32]

    @classmethod
    def of(
        cls, scene: Scene, size: tuple[int, int], limits: ScaleLimits, config: FacingConfig | None = None
    ) -> TopView | None:
        """Of what images of this size (width, height) show; None where there is no plane, nothing on it is squeezed, or
        nothing of it is looked at.

        :param limits: of the scale in the image: where the plane has others, nobody looks.
        :param config: None: the default.
        """
        plane, config = scene.plane, config or FacingConfig()
        pixels = _looked_at(scene, size)
        if plane is None or not len(pixels) or max(size) > _MOST_PX:
            return None
        scales, tolerance = plane.scales(pixels), 1 + plane.config.scale_tolerance
        seen = (scales > config.horizon * scales.max()) & (scales * tolerance >= limits.least)
        seen &= scales <= limits.greatest * tolerance
        if not seen.any():
            return None
        longest, shortest = np.linalg.svd(plane.jacobian(pixels[seen]), compute_uv=False).T
        places = plane.places(pixels[seen])
        low, high = places.min(axis=0), places.max(axis=0)
        scale = min(max(float(np.median(scales[seen])), limits.least), limits.greatest)
        scale = min(scale, _most_scale(high - low, size, config.view_area))
        if (longest / shortest).max() < config.squeezed or ((high - low) * scale < _LEAST_PX).any():
            return None
        to_plane = np.array([[1 / scale, 0, low[0]], [0, -1 / scale, high[1]], [0, 0, 1.0]])
        width, height = (np.ceil((high - low) * scale).astype(int) + 1).tolist()
        columns, rows = _where(plane, to_plane, width, height)
        nearby = plane.nearby @ np.linalg.inv(plane.matrix) @ to_plane
        above = FieldPlane(to_plane, nearby, plane.errors_px, plane.config, None)
        view = cls(Scene(plane=above), plane, scale, columns, rows)
        return replace(view, scene=Scene(view._region(scene), above))

    def _region(self, scene: Scene) -> Array | None:
        """(n, 2) corners of the scene's region in this view, as far as it does not lie beyond the horizon."""
        if scene.region is None:
            return None
        share = np.arange(_EDGE_STEPS)[:, None] / _EDGE_STEPS
        after = np.roll(scene.region, -1, axis=0)
        edges = np.concatenate([a + share * (b - a) for a, b in zip(scene.region, after, strict=True)])
        corners = self.from_image(edges)
        return corners[np.isfinite(corners).all(axis=1)]

    def codes(self, codes: Image, outside: int) -> Image:
        """(h, w) the codes (H, W) of an image. :param outside: that of what it does not show."""
        how = {"interpolation": cv2.INTER_NEAREST, "borderMode": cv2.BORDER_CONSTANT, "borderValue": outside}
        return np.asarray(cv2.remap(codes, self.columns, self.rows, **how), np.uint8)

    def colours(self, image: Image) -> Image:
        """(h, w, 3) an image's colours."""
        return np.asarray(cv2.remap(image, self.columns, self.rows, cv2.INTER_LINEAR), np.uint8)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) pixels."""
        height, width = self.columns.shape
        return width, height

    def from_image(self, pixels: Array) -> Array:
        """(n, 2) where pixels (n, 2) of the image are; NaN beyond the horizon."""
        plane = self.scene.plane
        assert plane is not None  # a view has one
        return plane.pixels(self.seen.places(pixels))

    def in_image(self, pixels: Array) -> Array:
        """(n, 2) where pixels (n, 2) of the view are in the image."""
        plane = self.scene.plane
        assert plane is not None
        return self.seen.pixels(plane.places(pixels))

    def turned(self, pixels: Array, theta: Array) -> tuple[Array, Array, Array]:
        """Where pixels (n, 2) are in the image, which way directions (n,) run there, and how much larger things are."""
        along = np.stack([np.cos(theta), np.sin(theta)], axis=1)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        steps = 0.5 * np.stack([np.zeros_like(along), along, -along, across, -across])
        at = self.in_image((pixels + steps).reshape(-1, 2)).reshape(steps.shape)
        ahead, aside = at[1] - at[2], at[3] - at[4]
        larger = np.sqrt(np.abs(ahead[:, 0] * aside[:, 1] - ahead[:, 1] * aside[:, 0]))
        return at[0], np.arctan2(ahead[:, 1], ahead[:, 0]), larger


def _where(
    plane: FieldPlane, to_plane: Array, width: int, height: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """(h, w) columns and rows of the image at a view's pixels: of every few of them, and between these in proportion.

    :param to_plane: (3, 3) the view's pixels in metres.
    """
    cells = -(-np.array([width, height]) // _STEP_PX) + 2  # one more on each side
    u, v = ((np.arange(n) - 0.5) * _STEP_PX - 0.5 for n in cells)  # the middles of these cells
    grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    at = plane.pixels(grid @ to_plane[:2, :2].T + to_plane[:2, 2])
    at = np.nan_to_num(at, nan=_NOWHERE).reshape(cells[1], cells[0], 2).astype(np.float32)
    fine = cv2.resize(at, (cells * _STEP_PX).tolist(), interpolation=cv2.INTER_LINEAR)
    columns, rows = cv2.split(fine[_STEP_PX : _STEP_PX + height, _STEP_PX : _STEP_PX + width])
    return columns, rows


def _most_scale(extent: Array, size: tuple[int, int], area: float) -> float:
    """Of a view of so many metres (2,): one of so many times the image's area, and sides that are not much longer."""
    room = area * size[0] * size[1]
    side = min(_MOST_SIDES * max(size), _MOST_PX - 2)  # one more pixel ends it, after rounding up
    return min(math.sqrt(room / max(float(np.prod(extent)), 1e-12)), side / float(extent.max() or 1))


def _looked_at(scene: Scene, size: tuple[int, int]) -> Array:
    """(n, 2) pixels all over what of an image objects may be in."""
    low, high = np.zeros(2), np.array(size) - 1.0
    corners = np.zeros((0, 2)) if scene.region is None else scene.region
    if len(corners):
        low, high = np.maximum(low, corners.min(axis=0)), np.minimum(high, corners.max(axis=0))
    if scene.plane is None or (low > high).any():
        return np.zeros((0, 2))
    sides = (np.linspace(a, b, _LOOKS) for a, b in zip(low, high, strict=True))
    pixels = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
    corners = corners[((corners >= low) & (corners <= high)).all(axis=1)]
    pixels = np.concatenate([pixels[scene.inside(pixels)], corners])
    return np.asarray(pixels[scene.plane.scales(pixels) > 0]) if len(pixels) else pixels
