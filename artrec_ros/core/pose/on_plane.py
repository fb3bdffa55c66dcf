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
from ..geometry.polygons import in_space
from ..geometry.projection import normalise, projection_jacobian
from ..geometry.transforms import Array, Pose, skew
from ..image.image_frame import ImageFrame
from ..model.found import Detection, Instance
from ..model.marker import Marker
from ..model.objects import ObjectModel
from ..model.target import Target

_FACING = np.diag([1.0, -1.0, -1.0])  # of what faces the camera


@dataclass(frozen=True)
class _Flat:
    """An object as the image shows it.

    :param rotation: (3, 3) brings its axes along x, y of the plane as the image shows it, y down, and away from the
        camera; by any turn about the last one.
    :param points: (n, 2) pixels of its outlines.
    :param along: (n, 2) the same, metres from its frame's origin, by that rotation.
    :param noise: (3, 3) covariance of the pixel of one of its points, and of its direction in the image, radians.
    :param middle: (2,) that point, as `along`.
    """

    rotation: Array
    points: Array
    along: Array
    noise: Array
    middle: Array


class PlanePlacer:
    """Places objects of these targets on the plane of a frame's scene."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig) -> None:
        self._targets = {t.name: t for t in targets}
        self._config, self._contour = config.covariance, config.constraints
        self._above = {t.name: _above(t.model) for t in targets}

    def placed(self, detections: Sequence[Detection], frame: ImageFrame) -> tuple[Detection, ...]:
        """The same detections; those without a pose get that of their frame on the plane: of the object's where the
        object file tells the markers' poses in it, else of the marker that shows the required component; none where
        that is not told."""
        plane = frame.scene.plane
        if plane is None:
            return tuple(detections)
        return tuple(self._by_markers(d, plane) if d.pose is None else d for d in detections)

    def faced(self, detection: Detection, frame: ImageFrame) -> Detection:
        """A detection whose pose is that before a camera that it faces, on the plane; without a pose where there is
        none, or where none of its components is told.

        :param frame: of that camera.
        """
        flat, plane, pose = replace(detection, pose=None, pose_covariance=None), frame.scene.plane, detection.pose
        if plane is None or pose is None or detection.pose_covariance is None or not detection.components:
            return flat
        camera, to_marker = frame.camera, pose.rotation @ self._above[detection.object]
        marker = pose.position + to_marker
        J = np.zeros((3, 6))  # of that point's pixel and the turn about the optical axis, by the pose
        of_point = projection_jacobian(camera, marker)
        # turned about its frame the point moves: how an object is tilted is not known, but where its markers are is
        J[:2], J[2, 5] = np.hstack([of_point, of_point @ skew(-to_marker)]), 1.0
        points = np.concatenate([c.contour for c in detection.components])
        along = normalise(camera, points) * marker[2] - pose.position[:2]
        noise = J @ detection.pose_covariance @ J.T
        return self._placed(flat, _Flat(pose.rotation, points, along, noise, to_marker[:2]), plane)

    def _by_markers(self, detection: Detection, plane: FieldPlane) -> Detection:
        """By the marker that shows the required component, and those that lie firmly beside it in one plane."""
        model = self._targets[detection.object].model
        required = model.required
        if (shown := detection.instance_of(required.name)) is None:
            return detection
        T_root = required.marker(shown.marker).T_component_marker or Pose.identity()
        rotation = _FACING @ T_root.rotation.T  # the marker's y is up, its z towards the camera
        points, along, noise_px = [], [], []
        for seen in detection.components:
            part = model.component(seen.component)
            marker = part.marker(seen.marker)
            if part is not required and not (model.is_flat and part.joint is None and required.joint is None):
                continue
            T = marker.T_component_marker or Pose.identity()
            along.append((T.apply(in_space(marker.outline)) @ rotation.T)[:, :2])
            points.append(_outline(seen, marker))
            radius_px = marker.radius * seen.scale  # what an edge errs is so much of its turn
            place_px = np.hypot(self._contour.contour_noise_px, self._contour.model_noise * radius_px)
            noise_px.append((place_px, radius_px))
        pixels, metres = np.concatenate(points), np.concatenate(along)
        flat = _Flat(rotation, pixels, metres, self._noise(points, np.array(noise_px)), metres.mean(axis=0))
        return self._placed(detection, flat, plane)

    def _noise(self, points: Sequence[Array], noise_px: Array) -> Array:
        """(3, 3) of the middle and the direction of markers (n, 2) each. :param noise_px: (m, 2) of the place of each
        one; its radius."""
        place, radius = np.sqrt(np.mean(noise_px[:, 0] ** 2) / len(points)), noise_px[:, 1].mean()
        turns = [self._config.flat_edge_px / radius / np.sqrt(len(points))]
        if len(points) > 1:
            middles = np.array([p.mean(axis=0) for p in points])
            turns.append(place / np.sqrt(np.mean(np.sum((middles - middles.mean(axis=0)) ** 2, axis=1))))
        return np.asarray(np.diag(np.square([place, place, min(turns)])), np.float64)

    def _placed(self, detection: Detection, flat: _Flat, plane: FieldPlane) -> Detection:
        there = plane.places(flat.points)
        if not np.isfinite(there).all():
            return detection
        turn = _nearest_turn(flat.along, there)
        place = there.mean(axis=0) - turn @ flat.along.mean(axis=0)
        to_field = np.pad(turn, (0, 1))
        to_field[2, 2] = -1.0  # what is away from the camera is down
        R = to_field @ flat.rotation
        pose = Pose(R, np.append(place, -float(R[2] @ self._above[detection.object])))
        covariance = self._covariance(flat, turn, place, plane)
        image = detection.image
        scale = image.scale / float(plane.scales(np.array([[image.x, image.y]]))[0])
        told = replace(detection, pose=pose, pose_covariance=covariance, frame_id=plane.frame_id, pose_from="plane")
        return replace(told, plane_scale=scale)

    def _covariance(self, flat: _Flat, turn: Array, place: Array, plane: FieldPlane) -> Array:
        """(6, 6) along the field's axes: what the image errs, through the homography; what the points err; what a slant
        leaves; and how far an object may stand off the plane."""
        arm = turn @ flat.middle
        pixel = plane.pixels((place + arm)[None])[0]
        J = plane.jacobian(pixel[None])[0]
        onto = np.zeros((3, 3))  # x, y and yaw by that pixel and the direction in the image
        onto[:2, :2], onto[2, 2] = J, -1.0
        to_origin = np.array([[1, 0, arm[1]], [0, 1, -arm[0]], [0, 0, 1.0]])
        errors = plane.point_errors(pixel)
        known = onto @ flat.noise @ onto.T + errors.T @ errors + np.diag(np.square(_left_by_slant(flat, J)))
        off = [0.0, 0.0, self._config.plane_z_m, self._config.plane_tilt_rad, self._config.plane_tilt_rad, 0.0]
        covariance, flat_ones = np.diag(np.square(off)), [0, 1, 5]
        covariance[np.ix_(flat_ones, flat_ones)] = to_origin @ known @ to_origin.T
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
    reach = np.linalg.norm(flat.along - flat.along.mean(axis=0), axis=1).mean()
    return np.array([reach / 2, reach / 2, 1.0]) * second


def _outline(seen: Instance, marker: Marker) -> Array:
    """(n, 2) pixels of a marker's outline where it was found."""
    turn = seen.theta - marker.axis_angle
    c, s = np.cos(turn), np.sin(turn)
    offset = (marker.outline - marker.centroid) * (1, -1)  # the image's y is down
    return np.asarray(seen.scale * offset @ np.array([[c, s], [-s, c]]) + (seen.x, seen.y), np.float64)


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
