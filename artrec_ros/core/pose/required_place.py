"""Where the required component is under hypotheses of a whole object, and how else it may be turned there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..model.objects import ObjectModel
from .surface_model import Poses, SpatialModel

_ACROSS = np.array((1.0, 1.0, -1.0))  # a marker's axes in its own mirror image
_ONE = 0.25  # of the required component's size, and of the logarithm of the depth: two so near are not both there


class RequiredPlace:
    """The required component of one model."""

    def __init__(self, model: ObjectModel, surface: SpatialModel) -> None:
        self._surface = surface
        markers = model.required.markers
        self._marker_turns = np.array([m.T_component_marker.rotation for m in markers if m.T_component_marker])
        self._marker_centres = np.array([m.centre for m in markers])

    def anchors(self, poses: Poses) -> Array:
        """(H, 3) the middle of its markers in the camera."""
        R, t = self._frames(poses)
        return np.asarray(np.einsum("hij,hj->hi", poses.R, R @ self._surface.anchor + t) + poses.t, np.float64)

    def discs(self, camera: Camera, poses: Poses) -> tuple[Array, Array]:
        """Where it is in the image: middles (H, 2) and radii (H,), pixels."""
        anchors = self.anchors(poses)
        return project(camera, anchors), self._radius_px(camera, anchors[:, 2])

    def is_over(self, camera: Camera, poses: Poses, one: Poses) -> np.ndarray:
        """(H,) bool: under which it would lie over the middle of that of `one` in the image."""
        there, here = self.anchors(poses), self.anchors(one)
        radius = self._radius_px(camera, np.maximum(there[:, 2], here[:, 2]))
        distance_px = np.linalg.norm(project(camera, there) - project(camera, here), axis=1)
        return (distance_px < radius) | (distance_px == 0)  # behind the camera all is at one place

    def is_in_place_of(self, poses: Poses, one: Poses, most_turn_rad: float) -> np.ndarray:
        """(H,) bool: under which the object would be where it is under `one`, turned by less than that."""
        cosine = (np.einsum("hij,ij->h", poses.R, one.R[0]) - 1) / 2
        return np.asarray(self.is_at(poses, one) & (cosine > np.cos(most_turn_rad)))

    def is_at(self, poses: Poses, others: Poses) -> np.ndarray:
        """(H,) bool: under which it would be where it is under others, of which there are as many or one: nearer than
        a fourth of its size."""
        there, here = self.anchors(poses), self.anchors(others)
        there[:, 2], here[:, 2] = np.maximum(there[:, 2], 1e-6), np.maximum(here[:, 2], 1e-6)
        off = np.linalg.norm(there / there[:, 2:] - here / here[:, 2:], axis=1)
        alike = np.abs(np.log(there[:, 2] / here[:, 2])) < _ONE
        return np.asarray((off < _ONE * self._surface.extent / here[:, 2]) & alike)

    def flips(self, poses: Poses) -> Poses:
        """Siblings of hypotheses: a flat marker looks almost the same mirrored in the plane that faces its line of
        sight."""
        return self.flips_of_each(poses)[0]

    def flips_of_each(self, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
        """The same, and of which of the hypotheses each one is."""
        R_root, t_root = self._frames(poses)
        R_object_marker = R_root @ self._marker_turns[:, None]  # (markers, H, 3, 3)
        centroid = (R_root @ self._marker_centres[:, None, :, None])[..., 0] + t_root
        R_marker, centre = poses.R @ R_object_marker, (poses.R @ centroid[..., None])[..., 0] + poses.t
        facing = np.sum(R_marker[..., 2] * centre, axis=-1) < 0
        sight = centre / np.maximum(np.linalg.norm(centre, axis=-1, keepdims=True), 1e-12)
        along = np.einsum("...i,...ij->...j", sight, R_marker)  # how far each of its axes points away from the camera
        R_mirrored = (R_marker - 2 * sight[..., :, None] * along[..., None, :]) * _ACROSS
        R = R_mirrored @ R_object_marker.swapaxes(-1, -2)
        t, q = centre - (R @ centroid[..., None])[..., 0], np.broadcast_to(poses.q, (len(R), *poses.q.shape))
        return Poses(R[facing], t[facing], q[facing]), np.nonzero(facing)[1]

    def _radius_px(self, camera: Camera, depth: Array) -> Array:
        return np.asarray(camera.focal_px * self._surface.extent / np.maximum(depth, 1e-6), np.float64)

    def _frames(self, poses: Poses) -> tuple[Array, Array]:
        """It in the object's frame, (H, 3, 3), (H, 3), or (1, ...) where no joint carries it."""
        kin, root = self._surface.kinematics, self._surface.root
        if kin.parent[root] < 0:
            return np.eye(3)[None], np.zeros((1, 3))
        frames = kin.in_object(poses.q)
        return frames.R[:, root], frames.t[:, root]
