"""Poses of objects that were found flat, on a plane that is given: where their outlines lie on it.

Seen at a slant a flat object is squeezed, and the similarity by which it was found tells neither its direction nor
its middle exactly. So the points of its outlines go to the plane by the homography, and there the rigid motion is
taken that lies nearest to them (W. Kabsch, 1976): to first order what the slant did to the similarity is undone by it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.field_plane import FieldPlane
from ..geometry.projection import project, projection_jacobian
from ..geometry.transforms import Array, Pose
from ..image.image_frame import ImageFrame
from ..model.found import Detection, Instance
from ..model.objects import ObjectModel
from ..model.target import Target


@dataclass(frozen=True)
class _Flat:
    """An object as a similarity of the image shows it.

    :param rotation: (3, 3) of its frame, along x and y of the image and away from the camera.
    :param origin: (2,) pixels of its frame's origin. :param scale: pixels per metre.
    :param points: (n, 2) pixels of its outlines.
    :param noise: (3, 3) covariance of its origin, pixels, and of its direction in the image, radians.
    """

    rotation: Array
    origin: Array
    scale: float
    points: Array
    noise: Array


class PlanePlacer:
    """Places objects of these targets on the plane of a frame's scene."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig) -> None:
        self._targets = {t.name: t for t in targets}
        self._config, self._contour = config.covariance, config.constraints
        self._above = {t.name: _above(t.model) for t in targets}

    def placed(self, detections: Sequence[Detection], frame: ImageFrame) -> tuple[Detection, ...]:
        """The same detections; those without a pose get that of their frame on the plane: of the object's where the
        object file tells the marker's pose in it, else of the marker that shows the required component."""
        plane = frame.scene.plane
        if plane is None:
            return tuple(detections)
        return tuple(self._placed(d, self._alone(d, frame), plane) if d.pose is None else d for d in detections)

    def faced(self, detection: Detection, frame: ImageFrame) -> Detection:
        """A detection whose pose is that before a camera that it faces, on the plane; without a pose where there is
        none.

        :param frame: of that camera.
        """
        flat, plane, pose = replace(detection, pose=None, pose_covariance=None), frame.scene.plane, detection.pose
        if plane is None or pose is None or detection.pose_covariance is None:
            return flat
        camera, t = frame.camera, pose.position
        J = np.zeros((3, 6))  # of the origin's pixel and the turn about the optical axis, by the pose
        J[:2, :3], J[2, 5] = projection_jacobian(camera, t), 1.0
        points = np.concatenate([c.contour for c in detection.components])
        noise = J @ detection.pose_covariance @ J.T
        origin, scale = project(camera, t[None])[0], camera.focal_px / float(t[2])
        return self._placed(flat, _Flat(pose.rotation, origin, scale, points, noise), plane)

    def _alone(self, detection: Detection, frame: ImageFrame) -> _Flat:
        """By the marker that shows the required component."""
        target = self._targets[detection.object]
        required = target.model.required
        shown = next(c for c in detection.components if c.component == required.name)
        marker = required.marker(shown.marker)
        T_marker = marker.T_component_marker or Pose.identity()
        turn = shown.theta - marker.axis_angle
        c, s = np.cos(turn), np.sin(turn)
        facing = np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])  # the marker's y is up, its z to the camera
        rotation = facing @ T_marker.rotation.T
        to_origin = rotation @ -T_marker.position - facing @ np.append(marker.centroid, 0.0)
        origin = np.array([shown.x, shown.y]) + shown.scale * to_origin[:2]
        noise = self._noise_alone(shown, 2 * marker.area / marker.perimeter * shown.scale)
        arm = shown.scale * np.array([-to_origin[1], to_origin[0]])  # a turn about the marker's middle moves the origin
        M = np.column_stack([np.eye(3)[:, :2], np.append(arm, 1.0)])
        return _Flat(rotation, origin, shown.scale, _outline(shown), M @ noise @ M.T)

    def _noise_alone(self, shown: Instance, radius_px: float) -> Array:
        """(3, 3) of a marker's middle and direction. :param radius_px: what an edge errs is so much of its turn."""
        place_px = np.hypot(self._contour.contour_noise_px, self._contour.model_noise * radius_px)
        turn = self._config.flat_edge_px / radius_px
        return np.asarray(np.diag(np.square([place_px, place_px, turn])), np.float64)

    def _placed(self, detection: Detection, flat: _Flat, plane: FieldPlane) -> Detection:
        there = plane.places(flat.points)
        if not len(there) or not np.isfinite(there).all():
            return detection
        along = (flat.points - flat.origin) / flat.scale
        turn = _nearest_turn(along, there)
        place = there.mean(axis=0) - along.mean(axis=0) @ turn.T
        to_field = np.pad(turn, (0, 1))
        to_field[2, 2] = -1.0  # what is away from the camera is down
        R = to_field @ flat.rotation
        z = -float(R[2] @ self._above[detection.object])
        covariance = self._covariance(flat, turn, plane)
        pose = Pose(R, np.append(place, z))
        return replace(
            detection, pose=pose, pose_covariance=covariance, frame_id=plane.frame_id, pose_from="plane"
        )  # fmt: skip

    def _covariance(self, flat: _Flat, turn: Array, plane: FieldPlane) -> Array:
        """(6, 6) along the field's axes: what the image errs, through the homography; what the points err; and how far
        an object may stand off the plane."""
        J = plane.jacobian(flat.origin[None])[0]
        onto = np.zeros((3, 3))  # x, y and yaw by the origin's pixel and the direction in the image
        onto[:2, :2], onto[2, 2] = J, np.linalg.det(turn)
        errors = plane.point_errors(flat.origin)
        seen = onto @ flat.noise @ onto.T + errors.T @ errors + np.diag(np.square(_left_by_slant(flat, J)))
        covariance = np.diag(
            np.square([0.0, 0.0, self._config.plane_z_m, self._config.plane_tilt_rad, self._config.plane_tilt_rad, 0.0])
        )
        mine = [0, 1, 5]
        covariance[np.ix_(mine, mine)] = seen
        return covariance


def _nearest_turn(source: Array, target: Array) -> Array:
    """(2, 2) of determinant -1, for y is down in the image: that which takes points (n, 2) nearest to others (n, 2),
    about their middles."""
    moment = (target - target.mean(axis=0)).T @ (source - source.mean(axis=0))
    u, _, vt = np.linalg.svd(moment)
    return np.asarray(u @ np.diag([1.0, -np.linalg.det(u @ vt)]) @ vt, np.float64)


def _left_by_slant(flat: _Flat, jacobian: Array) -> Array:
    """(3,) deviations in x, y and yaw that a slant leaves: its second order, of the outlines' reach."""
    longest, shortest = np.linalg.svd(jacobian)[1]
    second = (longest / shortest - 1) ** 2
    reach = np.linalg.norm(flat.points - flat.points.mean(axis=0), axis=1).mean() / flat.scale
    return np.array([reach / 2, reach / 2, 1.0]) * second


def _outline(shown: Instance) -> Array:
    return shown.contour if len(shown.contour) else np.array([[shown.x, shown.y]])


def _above(model: ObjectModel) -> Array:
    """(3,) the middle of the required component's markers in the object's frame, all joints at zero: those of a flat
    object leave its height as it is."""
    markers = [m for m in model.required.markers if m.T_component_marker is not None]
    if not markers:
        return np.zeros(3)
    middle, part = np.mean([m.centre for m in markers], axis=0), model.required
    while part.joint is not None:
        middle, part = part.joint.T_parent_joint.apply(middle[None])[0], model.component(part.joint.parent)
    return np.asarray(middle, np.float64)
