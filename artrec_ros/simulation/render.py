"""Draws a scene into a buffer that knows, for each sample point, the surface that is nearest to the camera.

A pixel has SUPERSAMPLING x SUPERSAMPLING sample points. A surface covers the sample points that lie inside its
outline (even-odd rule), so that areas and edges have no bias; of two surfaces the nearer one shows (inverse depths
are compared, which are exact for planes). Corners must be ahead of the camera.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.geometry.camera import Camera
from ..core.geometry.projection import normalise, project
from ..core.geometry.transforms import Array
from .scene import Floor, Scene
from .surfaces import Surface

SUPERSAMPLING = 3
NOTHING, FLOOR = -2, -1  # surface indices of the sample points that show no surface
_MARKER_LIFT = 1e-3  # markers count as this share of their distance nearer: they lie on bodies
_EDGE_PIECES = 12  # straight edges bend under lens distortion


@dataclass(frozen=True)
class Rendering:
    """What each sample point shows.

    :param surfaces: all surfaces that were drawn, in the camera's frame.
    :param objects: for each surface the index of its object in the scene, -1: none.
    :param index: (S H, S W) int16 index into `surfaces`, or FLOOR, or NOTHING.
    :param floor_label: class label of the floor, 0: none.
    """

    surfaces: tuple[Surface, ...]
    objects: tuple[int, ...]
    index: NDArray[np.int16]
    floor_label: int

    @property
    def sample_labels(self) -> NDArray[np.uint8]:
        """(S H, S W) class label of each sample point."""
        table = np.array([s.label for s in self.surfaces] + [0, self.floor_label], np.uint8)
        return table[self.index]  # NOTHING and FLOOR count from the table's end


class Renderer:
    """Renders scenes for one camera."""

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        width, height = camera.size
        u = to_pixel(np.arange(width * SUPERSAMPLING))
        v = to_pixel(np.arange(height * SUPERSAMPLING))
        pixels = np.stack(np.meshgrid(u, v), axis=-1)
        # (S H, S W, 2): where each sample point's line of sight crosses the plane z = 1
        self._rays = normalise(camera, pixels.reshape(-1, 2)).reshape(pixels.shape).astype(np.float32)

    def render(self, scene: Scene) -> Rendering:
        """The nearest surface at each sample point."""
        drawn = [(s, i) for i, placed in enumerate(scene.objects) for s in placed.surfaces() if s.facing > 0]
        drawn += [(s, -1) for s in scene.distractors]
        index = np.full(self._rays.shape[:2], NOTHING, np.int16)
        nearness = np.zeros(index.shape, np.float32)  # inverse depth
        if scene.floor is not None:
            self._draw_floor(scene.floor, index, nearness)
        for number, (surface, _) in enumerate(drawn):
            self._draw(surface, number, index, nearness)
        surfaces, objects = zip(*drawn, strict=True) if drawn else ((), ())
        return Rendering(surfaces, objects, index, scene.floor.label if scene.floor else 0)

    def _inverse_depth(self, normal: Array, offset: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """1/z of the plane normal @ X = offset on the lines of sight: normal @ (x, y, 1) / offset."""
        rays = self._rays[rows, columns]
        a, b, c = (normal / offset).astype(np.float32)
        return a * rays[..., 0] + b * rays[..., 1] + c

    def _inverse_depth_of_ball(
        self, centre: Array, radius_m: float, rows: slice, columns: slice
    ) -> NDArray[np.float32]:
        """1/z of the near side of a ball; beside it that of where lines of sight come nearest to it."""
        rays = self._rays[rows, columns]
        along = rays @ centre[:2].astype(np.float32) + np.float32(centre[2])
        square = (rays**2).sum(axis=-1) + 1
        left = along**2 - square * np.float32(centre @ centre - radius_m**2)
        return np.asarray(square / np.maximum(along - np.sqrt(np.maximum(left, 0)), 1e-6), np.float32)

    def _draw_floor(self, floor: Floor, index: NDArray[np.int16], nearness: NDArray[np.float32]) -> None:
        everywhere = slice(None)
        inverse = self._inverse_depth(floor.normal, floor.offset, everywhere, everywhere)
        seen = inverse > 0
        index[seen] = FLOOR
        nearness[seen] = inverse[seen]

    def _draw(self, surface: Surface, number: int, index: NDArray[np.int16], nearness: NDArray[np.float32]) -> None:
        outline = (project_outline(self.camera, surface.corners) + 0.5) * SUPERSAMPLING - 0.5
        height, width = index.shape
        low = np.clip(np.floor(outline.min(axis=0)).astype(int), 0, (width, height))
        high = np.clip(np.ceil(outline.max(axis=0)).astype(int) + 1, 0, (width, height))
        if np.any(low >= high):
            return
        rows, columns = slice(low[1], high[1]), slice(low[0], high[0])
        if surface.ball is not None:
            inverse = self._inverse_depth_of_ball(*surface.ball, rows, columns)
        else:
            inverse = self._inverse_depth(surface.normal, float(surface.normal @ surface.corners[0]), rows, columns)
        if surface.owner is not None:
            inverse = inverse * np.float32(1 + _MARKER_LIFT)
        inside = polygon_mask(outline - low, (high[1] - low[1], high[0] - low[0]))
        shown = inside & (inverse > nearness[rows, columns])
        index[rows, columns][shown] = number
        nearness[rows, columns][shown] = inverse[shown]


def to_pixel(sample: ArrayLike) -> Array:
    """Sample coordinates to pixel coordinates, a pixel's centre being an integer."""
    return (np.asarray(sample, float) + 0.5) / SUPERSAMPLING - 0.5


def project_outline(camera: Camera, corners: Array) -> Array:
    """(m, 2) the image of a polygon (n, 3): m = n without lens distortion, else edges are cut into pieces."""
    if camera.distortion.any():
        t = np.arange(_EDGE_PIECES)[:, None] / _EDGE_PIECES
        following = np.roll(corners, -1, axis=0)
        corners = (corners[:, None] * (1 - t) + following[:, None] * t).reshape(-1, 3)
    return project(camera, corners)


def polygon_mask(outline: Array, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """(height, width) True at the integer points inside a polygon (n, 2): even-odd rule, exact, by scan lines."""
    height, width = shape
    following = np.roll(outline, -1, axis=0)
    upward = (outline[:, 1] > following[:, 1])[:, None]  # one sense, so that neighbours round a shared edge alike
    start, end = np.where(upward, following, outline), np.where(upward, outline, following)
    y = np.arange(height)[:, None]
    crosses = (start[:, 1] > y) != (end[:, 1] > y)  # (height, n)
    row, edge = np.nonzero(crosses)
    slope = (end[edge, 0] - start[edge, 0]) / (end[edge, 1] - start[edge, 1])
    x = start[edge, 0] + (row - start[edge, 1]) * slope
    column = np.clip(np.ceil(x), 0, width).astype(int)  # the first point to the right of the crossing
    flips = np.zeros((height, width + 1), np.uint8)
    np.add.at(flips, (row, column), 1)
    return (np.cumsum(flips[:, :width], axis=1, dtype=np.uint8) & 1).astype(bool)
