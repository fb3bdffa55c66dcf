"""What the sides of a solid are together: one outline, and one blob."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.polygons import perimeter, signed_area
from ..geometry.spread import all_turns
from ..geometry.transforms import Array
from ..model.solids import balls_of, middle_of, shadow_m2
from .surface_kernels import LEAST_DEPTH_M, LEAST_STRIP_PX

_DIRECTIONS = 32  # from which a solid is looked at for its width

if TYPE_CHECKING:
    from .poses import Poses
    from .surface_model import SpatialModel


class Sides:
    """Those of one surface's solids; what is none is asked the same, and is itself."""

    def __init__(self, surface: SpatialModel) -> None:
        self._surface = surface
        patches = [surface.patches[p] for p in surface.markers]
        self._of = surface.component[surface.markers]  # (M,)
        self._normals = np.array([p.normal for p in patches]).reshape(-1, 3)
        self._middles = np.array([p.drawn[0] for p in patches]).reshape(-1, 3)
        self._sizes_m = np.sqrt([p.area for p in patches])

    @cached_property
    def balls(self) -> frozenset[int]:
        """Components of which no picture tells how they are turned."""
        return frozenset(balls_of(self._surface.patches))

    @cached_property
    def blobs(self) -> tuple[Array, Array]:
        """What a blob's middle and area tell of the component that a marker shows: (P, 3) that place in its frame and
        (P,) m^2; of patches that are no markers nothing. Of a solid's sides they tell the whole solid's."""
        surface = self._surface
        middle, area = np.zeros((len(surface.patches), 3)), surface.area.copy()
        for c, markers in enumerate(surface.markers_of):
            sides = [surface.patches[p] for p in markers]
            if c in surface.solids:
                middle[markers], area[markers] = middle_of(sides), shadow_m2(sides)
            else:
                middle[markers] = np.array([side.drawn[0] for side in sides]).reshape(-1, 3)
        return middle, area

    @cached_property
    def half_widths(self) -> Array:
        """(M,) twice the area over the perimeter, of a square as of a strip half its width: metres. Of the sides of a
        solid that of its outline, in the mean of some directions."""
        surface = self._surface
        out: Array = 2 * surface.area[surface.markers] / surface.perimeter
        for c in surface.solids:
            rows = np.flatnonzero(self._of == c)
            corners = np.concatenate([surface.patches[p].drawn[3:] for p in surface.markers[rows]])
            out[rows] = np.mean([_half_width(corners @ turn[:2].T) for turn in all_turns(_DIRECTIONS)])
        return out

    def with_all(self, use: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(..., M) markers in use, and all others of the solids of which some are: their outline is one, whichever of
        them the labels bear out."""
        return np.asarray(use | (use @ self._one_outline)) if self._surface.solids else use

    def ends(self, poses: Poses, camera: Camera) -> NDArray[np.bool_]:
        """(H, M, m) contour points beyond which there is no other marker of the object; where sides of one class meet,
        none that is in view."""
        open_contour, meeting = self._surface.open_contour, self._surface.meeting
        if (meeting < 0).all():
            return open_contour
        seen = self.in_view(poses, camera)
        return np.asarray(open_contour | ((meeting >= 0) & seen[..., None] & ~seen[:, meeting]))

    def in_view(self, poses: Poses, camera: Camera) -> NDArray[np.bool_]:
        """(H, M) which markers are turned to the camera and end a pixel or more from where they begin."""
        frames = self._surface.kinematics.seen(poses.R, poses.t, poses.q)
        R, t = frames.R[:, self._of], frames.t[:, self._of]
        sight = (R @ self._middles[..., None])[..., 0] + t
        cosine = -((R @ self._normals[..., None])[..., 0] * sight).sum(axis=-1) / np.linalg.norm(sight, axis=-1)
        size_px = camera.focal_px * self._sizes_m / np.maximum(sight[..., 2], LEAST_DEPTH_M)
        return np.asarray(cosine * size_px > LEAST_STRIP_PX)

    @cached_property
    def _one_outline(self) -> NDArray[np.bool_]:
        """(M, M) which markers are sides of one solid."""
        return (self._of[:, None] == self._of) & np.isin(self._of, sorted(self._surface.solids))


def _half_width(points: Array) -> float:
    """Of the hull of points (n, 2)."""
    hull = cv2.convexHull(points.astype(np.float32))[:, 0].astype(float)
    return 2 * abs(signed_area(hull)) / perimeter(hull)
