"""The last fit of objects that face the camera, where the image has colours: to these, not to classes' boundaries."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.range_limits import scale_limits
from ..geometry.transforms import Array
from ..image.codes import OUTSIDE
from ..image.image_frame import ImageFrame
from ..image.segmentation import as_light
from ..model.kinematics import Frames
from .poses import Poses
from .region_kernels import Regions, even_out_each
from .surface_model import SpatialModel

_MOST_IN = 0.6  # of the way to its middle at most, a marker's points are drawn in


class _Figures(NamedTuple):
    """H hypotheses in the image.

    :ivar at: (H, 4 + J) the similarity of each, and by how much joints are moved. :ivar shown: (H,) whether the image
        shows all of each: a view from above has no colours of what that does not show.
    """

    regions: Regions
    at: Array
    shown: NDArray[np.bool_]


class RegionFit:
    """Fits one model's poses: each marker is a region, and so is what lies around each."""

    def __init__(self, surface: SpatialModel, config: RecognizerConfig, there: NDArray[np.bool_] | None = None) -> None:
        """:param there: (M,) markers that are; None: all."""
        self._surface, self._config, self._limits = surface, config.facing, scale_limits(config, None)
        there = np.ones(len(surface.markers), bool) if there is None else there
        patches = [surface.patches[p] for p in surface.markers[there]]
        outward = [np.cross(p.contour_along, p.normal) for p in patches]
        around = surface.open_contour[there]
        # inside as far from the outlines as outside: else blur, which is in some points and not in others, pulls
        radius = [p.marker.radius for p in patches if p.marker is not None]
        inward = [(p.inside.mean(axis=0) - p.inside) / r for p, r in zip(patches, radius, strict=True)]
        most = [np.full(len(p.inside), _MOST_IN * r) for p, r in zip(patches, radius, strict=True)]
        points = [p.inside for p in patches] + [p.contour[free] for p, free in zip(patches, around, strict=True)]
        self._points = np.concatenate(points)
        away = np.concatenate(inward + [o[free] for o, free in zip(outward, around, strict=True)])
        self._beyond = self._points + away
        self._most_m = np.concatenate([*most, np.full(int(around.sum()), np.inf)])
        self._on = np.concatenate([np.full(len(p), patches[i % len(patches)].component) for i, p in enumerate(points)])
        self._region = np.concatenate([np.full(len(p), i) for i, p in enumerate(points)])
        self._count = len(points)
        kin = surface.kinematics
        self._order = np.argsort(-kin.moves[kin.carried].sum(axis=1), kind="stable")  # joints, the last ones first
        self._moved = np.ascontiguousarray(kin.moves[self._on].T[self._order])  # (J, n)

    def fitted(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]) -> Poses:
        """Poses moved, turned, scaled and bent in the image plane; what the border cuts stays.

        :param used: (H, M) markers that the labels support: joints that move none of these stay.
        """
        config, (regions, at, shown) = self._config, self._figures(frame, poses)  # in light, which lenses blend
        scale = frame.camera.focal_px / poses.t[:, 2]
        reach = self._reach(regions, scale)
        kin, component = self._surface.kinematics, self._surface.component[self._surface.markers]
        reach[:, 4:] *= (used @ kin.moves[component])[:, self._order] > 0
        least, most = at - reach, at + reach
        within = np.where(kin.endless, -np.inf, kin.lower - poses.q), np.where(kin.endless, np.inf, kin.upper - poses.q)
        least[:, 4:] = np.minimum(np.maximum(least[:, 4:], within[0][:, self._order]), 0.0)
        most[:, 4:] = np.maximum(np.minimum(most[:, 4:], within[1][:, self._order]), 0.0)
        least[:, 3] = np.minimum(np.maximum(least[:, 3], self._limits.least / scale), 1.0)  # but never has it to move
        most[:, 3] = np.maximum(np.minimum(most[:, 3], self._limits.greatest / scale), 1.0)
        even_out_each(
            as_light(frame.colours, frame.gamma),
            regions,
            at,
            reach / 4,
            config.region_rounds,
            least,
            most,
            np.empty(len(at)),
        )
        z = poses.t[:, 2] / at[:, 3]
        roll = np.zeros((len(at), 3, 3))
        roll[:, 0, 0] = roll[:, 1, 1] = np.cos(at[:, 2])
        roll[:, 1, 0], roll[:, 2, 2] = np.sin(at[:, 2]), 1.0
        roll[:, 0, 1] = -roll[:, 1, 0]
        place = (at[:, :2] - frame.camera.matrix[:2, 2]) * (z / frame.camera.focal_px)[:, None]
        q = poses.q.copy()
        q[:, self._order] += at[:, 4:]
        fitted = Poses(roll @ poses.R, np.column_stack([place, z]), kin.bound(q))
        both, rows = Poses.concatenate([poses, fitted]), np.arange(len(poses))
        return both[rows + len(poses) * shown]

    def evenness(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H,) the share of the variance of the colours on and around each hypothesis that is between its regions; 0
        where a part of it lies outside of the image."""
        (regions, at, shown), uneven = self._figures(frame, poses), np.empty(len(poses))
        even_out_each(frame.colours, regions, at, at, 0, at, at, uneven)
        return np.where(shown, 1.0 - uneven, 0.0)

    def _reach(self, regions: Regions, scale: Array) -> Array:
        """(H, 4 + J) how far similarities and joints may go. :param scale: (H,) pixels per metre."""
        x, y, about = regions.x, regions.y, regions.at
        size = np.sqrt(np.mean(x * x + y * y, axis=1))
        arms = np.hypot(x[:, None] - about[..., :1], y[:, None] - about[..., 1:])  # (H, J, n)
        arm = np.sqrt((arms**2 * self._moved).sum(axis=2) / np.maximum(self._moved.sum(axis=1), 1))
        revolute = self._surface.kinematics.revolute[self._order]
        arm = np.where(revolute, arm, scale[:, None])  # pixels that a radian, or a metre, moves points
        each = np.column_stack([np.ones((len(size), 2)), size, size, np.maximum(arm, 1.0)])
        return np.asarray(self._config.region_reach_px / each)

    def _figures(self, frame: ImageFrame, poses: Poses) -> _Figures:
        """Each hypothesis' points in the image."""
        camera, depth = frame.camera, poses.t[:, 2]
        frames = self._surface.kinematics.seen(poses.R, poses.t, poses.q)
        scale, origin = camera.focal_px / depth, project(camera, poses.t)  # scale: pixels per metre
        at, moved = (self._surface.place(frames, points, self._on) for points in (self._points, self._beyond))
        moved -= at  # in place: these are large
        moved *= np.minimum(self._config.region_ring_px / scale[:, None], self._most_m)[..., None]
        moved += at
        pixels = project(camera, moved)
        x, y = (pixels[..., i] - origin[:, i : i + 1] for i in range(2))
        start = np.zeros((len(depth), 4 + poses.q.shape[1]))
        start[:, :2], start[:, 3] = origin, 1.0
        regions = Regions(x, y, self._region, self._count, self._moved, *self._joints(frames, scale, origin, camera))
        return _Figures(regions, start, np.asarray((frame.field.at(pixels) != OUTSIDE).all(axis=1)))

    def _joints(self, frames: Frames, scale: Array, origin: Array, camera: Camera) -> tuple[Array, Array]:
        """`Regions.turns` and `Regions.at`, of hypotheses at such a scale (H,) with their origins at pixels (H, 2)."""
        if not len(self._order):
            return np.zeros((len(scale), 0)), np.zeros((len(scale), 0, 2))
        axis, joint_at = frames.axis[:, self._order], project(camera, frames.origin[:, self._order]) - origin[:, None]
        revolute = self._surface.kinematics.revolute[self._order]
        # in one order in memory, whatever indexing gives: another one is compiled for anew
        turns = np.ascontiguousarray(np.where(revolute, np.sign(axis[..., 2]), 0.0))
        about = np.ascontiguousarray(np.where(revolute[:, None], joint_at, axis[..., :2] * scale[:, None, None]))
        return turns, about
