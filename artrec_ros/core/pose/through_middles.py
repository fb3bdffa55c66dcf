"""Poses that have components where blobs are: by the middles of their markers alone, whatever their joints were.

A search that lays one component on its blob and bends one joint after the other chooses each by what it sees of it:
what hangs on a part that is not seen, or on one that was laid wrongly, it never tries elsewhere. Where it is known
which blobs are to be explained, their middles say all of a pose and its joints at once, up to what fits mend.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.spread import spread, turns_at
from ..geometry.transforms import Array, rotation_from_rotvec, short_way
from .middles_kernels import Wanted, go_through
from .pose_fit import joints_of
from .poses import Poses
from .surface_kernels import LEAST_DEPTH_M
from .surface_model import SpatialModel

_ALIKE = 0.1  # radians, or units of joints: fits that are nearer to each other come to rest at one pose


class Middles(NamedTuple):
    """Where n markers are to be.

    :param patches: (n,) of the surface. :param at: (n, 2) pixels. :param scale: (n,) pixels per metre, by their areas.
    """

    patches: NDArray[np.int64]
    at: Array
    scale: Array


class ThroughMiddles:
    """Of one object. :param facing: it turns about the optical axis alone."""

    def __init__(self, surface: SpatialModel, config: RecognizerConfig, *, facing: bool) -> None:
        self._surface, self._kin, self._config = surface, surface.kinematics, config.middles
        self._free = np.ones(6 + self._kin.n_joints, bool)
        self._free[3:5] = not facing
        self._facing, self._joints = facing, joints_of(self._kin)
        self._middle, self._area = surface.sides.blobs

    def of(self, camera: Camera, pose: Poses, middles: Middles) -> Poses:
        """A few poses, the best first. :param pose: one, near which the object is."""
        return self.begun(camera, self._starts(pose), middles)

    def begun(self, camera: Camera, poses: Poses, middles: Middles, *, held: bool = False) -> Poses:
        """The same begun from some poses alone, which are about right. :param held: all but their joints are right."""
        c, patches = self._config, middles.patches
        wanted = Wanted(
            self._surface.component[patches],
            self._middle[patches],
            np.array(middles.at, float),
            np.array(middles.scale, float),
            float(c.place_px),
            float(c.size_share),
            camera.focal_px,
        )
        R, t, q, cost = poses.R.copy(), poses.t.copy(), poses.q.copy(), np.empty(len(poses))
        free = self._free & ((np.arange(len(self._free)) >= 6) | (not held))
        go_through(wanted, self._kin.chain, self._joints, camera.lens, free, R, t, q, cost)
        poses = Poses(R, t, self._kin.bound(q))
        order = np.argsort(cost, kind="stable")
        through = order[self._is_through(camera, poses, middles)[order]]
        return poses[self._distinct(poses, through)]

    def _distinct(self, poses: Poses, order: NDArray[np.int64]) -> list[int]:
        """The first few of these that are not where one before has come to."""
        kept = list[int]()
        for n in order.tolist():
            turned = np.einsum("kij,ij->k", poses.R[kept], poses.R[n])  # trace of the turn from one to the other
            bent = np.abs(short_way(poses.q[kept] - poses.q[n], self._kin.endless)) / self._kin.unit
            same = (turned > 1 + 2 * np.cos(_ALIKE)) & (bent < _ALIKE).all(axis=1)
            if len(kept) < self._config.keep and not same.any():
                kept.append(n)
        return kept

    def _is_through(self, camera: Camera, poses: Poses, middles: Middles) -> NDArray[np.bool_]:
        """(H,) whether all middles lie on their blobs: else climbs and fits would not bring them there either."""
        off = np.linalg.norm(project(camera, self.places(poses, middles.patches)) - middles.at, axis=2)
        return np.asarray((off < np.sqrt(self._area[middles.patches] / np.pi) * middles.scale).all(axis=1))

    def places(self, poses: Poses, patches: NDArray[np.int64]) -> Array:
        """(H, n, 3) where the middles of n markers are, before the camera."""
        frames = self._kin.seen(poses.R, poses.t, poses.q)
        at = self._surface.place(frames, self._middle[patches], self._surface.component[patches])
        at[..., 2] = np.maximum(at[..., 2], LEAST_DEPTH_M)
        return at

    def _starts(self, pose: Poses) -> Poses:
        """Turned about the line of sight and bent in many ways, in space slanted in some; in all ways about a ball,
        which tells none."""
        n, kin = self._config.starts, self._kin
        even = spread(n, 3 + kin.n_joints)
        q = np.ascontiguousarray(kin.lower + (kin.upper - kin.lower) * even[:, 3:])
        if self._surface.root in self._surface.sides.balls:
            return Poses(turns_at(even[:, :3]), np.tile(pose.t[0], (n, 1)), q)
        about = rotation_from_rotvec(2 * np.pi * even[:, :1] * [0.0, 0.0, 1.0])
        if not self._facing:
            slant = self._config.slant_rad * (2 * even[:, 1:3] - 1)
            about = rotation_from_rotvec(np.pad(slant, ((0, 0), (0, 1)))) @ about
        return Poses(about @ self._faced(pose.R[0]), np.tile(pose.t[0], (n, 1)), q)

    def _faced(self, R: Array) -> Array:
        """A turn after which the first of the required component's markers faces the camera."""
        if self._facing:
            return R
        normal = R @ self._surface.patches[self._surface.markers_of[self._surface.root][0]].normal
        towards = np.array([0.0, 0.0, -1.0])
        axis, cosine = np.cross(normal, towards), float(np.clip(normal @ towards, -1, 1))
        length = float(np.linalg.norm(axis))
        axis = axis / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
        return np.asarray(rotation_from_rotvec(np.arccos(cosine) * axis) @ R)
