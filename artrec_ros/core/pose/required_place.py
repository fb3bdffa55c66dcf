"""Where the required component is under hypotheses of a whole object, and how else it may be turned there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..model.objects import ObjectModel
from .poses import Poses
from .surface_model import SpatialModel

_ONE = 0.25  # of the required component's size, and of the logarithm of the depth: two so near are not both there


class RequiredPlace:
    """The required component of one model."""

    def __init__(self, model: ObjectModel, surface: SpatialModel) -> None:
        self._surface = surface
        markers = model.required.markers
        turns = np.array([m.T_component_marker.rotation for m in markers if m.T_component_marker])
        self._normals, self._marker_centres = turns[:, None, :, 2], np.array([m.centre for m in markers])[:, None]
        kin = surface.kinematics
        self._is_fixed = kin.parent[surface.root] < 0  # no joint carries it

    def anchors(self, poses: Poses) -> Array:
        """(H, 3) the middle of its markers in the camera."""
        if self._is_fixed:
            return np.asarray(poses.R @ self._surface.anchor + poses.t, np.float64)
        R, t = self._frames(poses)
        return np.asarray(np.einsum("hij,hj->hi", poses.R, R @ self._surface.anchor + t) + poses.t, np.float64)

    def discs(self, camera: Camera, poses: Poses) -> tuple[Array, Array]:
        """Where it is in the image: middles (H, 2) and radii (H,), pixels."""
        anchors = self.anchors(poses)
        return project(camera, anchors), self._radius_px(camera, anchors[:, 2])

    def is_over(self, camera: Camera, poses: Poses, one: Poses) -> np.ndarray:
        """(H,) bool: under which it would lie over the middle of that of `one` in the image."""
        return np.asarray(self.are_over(camera, poses, one)[:, 0])

    def are_over(self, camera: Camera, poses: Poses, others: Poses) -> np.ndarray:
        """(H, K) bool: `is_over` each of K others."""
        there, here = self.anchors(poses)[:, None], self.anchors(others)[None]
        radius = self._radius_px(camera, np.maximum(there[..., 2], here[..., 2]))
        distance_px = np.linalg.norm(project(camera, there) - project(camera, here), axis=-1)
        return (distance_px < radius) | (distance_px == 0)  # behind the camera all is at one place

    def is_in_place_of(self, poses: Poses, others: Poses, most_turn_rad: float) -> np.ndarray:
        """(H, K) bool: under which the object would be where it is under each of K others, turned by less than that."""
        cosine = (poses.R.reshape(-1, 9) @ others.R.reshape(-1, 9).T - 1) / 2
        near = self._is_near(self.anchors(poses)[:, None], self.anchors(others)[None])
        return np.asarray(near & (cosine > np.cos(most_turn_rad)))

    def is_at(self, poses: Poses, others: Poses) -> np.ndarray:
        """(H,) bool: under which it would be where it is under others, of which there are as many or one: nearer than
        a fourth of its size."""
        return self._is_near(self.anchors(poses), self.anchors(others))

    def _is_near(self, there: Array, here: Array) -> np.ndarray:
        """(...) bool: which middles of it (..., 3) are nearer to others (..., 3) than a fourth of its size."""
        far, depth = np.maximum(there[..., 2], 1e-6), np.maximum(here[..., 2], 1e-6)
        x, y = (there[..., i] / far - here[..., i] / depth for i in (0, 1))
        alike = np.abs(np.log(far / depth)) < _ONE
        return np.asarray((np.hypot(x, y) < _ONE * self._surface.extent / depth) & alike)

    def flips(self, poses: Poses) -> Poses:
        """Siblings of hypotheses: a flat marker looks almost the same mirrored in the plane that faces its line of
        sight."""
        return self.flips_of_each(poses)[0]

    def flips_of_each(self, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
        """The same, and of which of the hypotheses each one is."""
        n, centroid = self._normals, self._marker_centres  # (markers, H or 1, 3) in the object's frame
        if not self._is_fixed:
            R, t = self._frames(poses)
            n, centroid = (R @ n[..., None])[..., 0], (R @ centroid[..., None])[..., 0] + t
        centre = (poses.R @ centroid[..., None])[..., 0] + poses.t
        of = np.nonzero(((poses.R @ n[..., None])[..., 0] * centre).sum(axis=-1) < 0)
        facing = of[0], np.minimum(of[1], n.shape[1] - 1)
        return mirrored_about(poses[of[1]], n[facing], centroid[facing]), of[1]

    def _radius_px(self, camera: Camera, depth: Array) -> Array:
        return np.asarray(camera.focal_px * self._surface.extent / np.maximum(depth, 1e-6), np.float64)

    def _frames(self, poses: Poses) -> tuple[Array, Array]:
        """It in the object's frame, (H, 3, 3), (H, 3)."""
        frames, root = self._surface.kinematics.in_object(poses.q), self._surface.root
        return frames.R[:, root], frames.t[:, root]


def mirrored_about(poses: Poses, normals: Array, centres: Array) -> Poses:
    """H hypotheses as each looks almost the same if all that is seen of it lies in one plane: mirrored in that, and
    then in the plane that faces the line of sight to a point of it.

    :param normals: (H, 3) of the plane. :param centres: (H, 3) of the point, both in the object's frame.
    """
    centre = (poses.R @ centres[..., None])[..., 0] + poses.t
    sight = centre / np.maximum(np.linalg.norm(centre, axis=-1, keepdims=True), 1e-12)
    R = _mirrored(_mirrored(poses.R.swapaxes(-1, -2), normals).swapaxes(-1, -2), sight)
    return Poses(R, centre - (R @ centres[..., None])[..., 0], poses.q)


def _mirrored(axes: Array, normal: Array) -> Array:
    """The columns of matrices (n, 3, 3) mirrored in planes with such unit normals (n, 3)."""
    along = np.einsum("ni,nij->nj", normal, axes)
    return np.asarray(axes - 2 * normal[:, :, None] * along[:, None, :])
