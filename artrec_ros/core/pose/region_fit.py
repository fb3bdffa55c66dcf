"""The last fit of objects that face the camera, where the image has colours: to these, not to classes' boundaries."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .region_kernels import Regions, even_out
from .surface_model import Poses, SpatialModel

_MOST_IN = 0.6  # of the way to its middle at most, a marker's points are drawn in


class RegionFit:
    """Fits one model's poses: each marker is a region, and so is what lies around each."""

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._surface, self._config = surface, config.facing
        patches = [surface.patches[p] for p in surface.markers]
        outward = [np.cross(p.contour_along, p.normal) for p in patches]
        around = surface.open_contour
        # inside as far from the outlines as outside: else blur, which is in some points and not in others, pulls
        radius = [2 * p.area / p.marker.perimeter for p in patches if p.marker is not None]  # of a circle within, about
        inward = [(p.inside.mean(axis=0) - p.inside) / r for p, r in zip(patches, radius, strict=True)]
        most = [np.full(len(p.inside), _MOST_IN * r) for p, r in zip(patches, radius, strict=True)]
        points = [p.inside for p in patches] + [p.contour[free] for p, free in zip(patches, around, strict=True)]
        self._points = np.concatenate(points)
        self._away = np.concatenate(inward + [o[free] for o, free in zip(outward, around, strict=True)])
        self._most_m = np.concatenate([*most, np.full(int(around.sum()), np.inf)])
        self._on = np.concatenate([np.full(len(p), patches[i % len(patches)].component) for i, p in enumerate(points)])
        self._region = np.concatenate([np.full(len(p), i) for i, p in enumerate(points)])
        self._count = len(points)

    def fitted(self, frame: ImageFrame, poses: Poses) -> Poses:
        """Poses moved, turned and scaled in the image plane."""
        assert frame.image is not None  # the caller's condition
        # a copy: compiled code would take one that may not be written to, or has gaps, for another kind
        image = np.array(frame.image, np.uint8, order="C")
        R, t = poses.R.copy(), poses.t.copy()
        for h in range(len(poses)):
            R[h], t[h] = self._one(frame, image, poses[h : h + 1])
        return Poses(R, t, poses.q)

    def _one(self, frame: ImageFrame, image: NDArray[np.uint8], pose: Poses) -> tuple[Array, Array]:
        camera, config, depth = frame.camera, self._config, pose.t[0, 2]
        frames = self._surface.kinematics.forward(pose.R, pose.t, pose.q)
        scale = camera.focal_px / depth  # pixels per metre
        beyond = self._points + self._away * np.minimum(config.region_ring_px / scale, self._most_m)[:, None]
        pixels = project(camera, self._surface.place(frames, beyond, self._on))[0]
        origin = project(camera, pose.t)[0]
        x, y = (pixels - origin).T
        size = float(np.sqrt(np.mean(x * x + y * y)))
        reach = np.array([config.region_reach_px, config.region_reach_px, config.region_reach_px / size,
                          config.region_reach_px / size])  # fmt: skip
        at = np.array([*origin, 0.0, 1.0])
        regions = Regions(np.ascontiguousarray(x), np.ascontiguousarray(y), self._region, self._count)
        even_out(image, regions, at, reach / 4, config.region_rounds, at - reach, at + reach)
        z = depth / at[3]
        c, s = np.cos(at[2]), np.sin(at[2])
        roll = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        place = (at[:2] - camera.matrix[:2, 2]) * z / camera.focal_px
        return roll @ pose.R[0], np.array([*place, z])
