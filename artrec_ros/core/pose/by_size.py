"""Metric poses of objects that were found flat: by their size in the image, as if they faced the camera.

A marker of known size that lies parallel to the image plane at depth z shows f / z pixels per metre. So its place in
the image and its scale give its place in space, and its direction the turn about the optical axis. How far it is
tilted they do not tell: it is taken to be parallel, and the covariance says by how much it may not be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.camera import Camera
from ..geometry.projection import normalise
from ..geometry.transforms import Array, Pose, skew
from ..image.image_frame import ImageFrame
from ..model.found import Detection, Instance
from ..model.target import Target


class _Seen(NamedTuple):
    """A marker through an undistorted camera: (2,) its place, x/z and y/z; its direction; pixels per unit there."""

    place: Array
    theta: float
    zoom: float


class SizePlacer:
    """Places objects of these targets."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig) -> None:
        self._targets = {t.name: t for t in targets}
        self._config, self._contour = config.covariance, config.constraints
        # markers turned away by more are missed
        self._tilt_rad = float(np.radians(max(self._config.flat_tilt_deg, config.max_slant_deg)))

    def placed(self, detections: Sequence[Detection], frame: ImageFrame) -> tuple[Detection, ...]:
        """The same detections; those without a pose get one by their size.

        It is that of the object's frame where the object file tells the marker's pose in it, else of the frame of
        the marker that shows the required component.
        """
        return tuple(d if d.pose is not None else self._placed(d, frame) for d in detections)

    def _placed(self, detection: Detection, frame: ImageFrame) -> Detection:
        target = self._targets[detection.object]
        required = target.model.required
        shown = next(c for c in detection.components if c.component == required.name)
        marker, seen = required.marker(shown.marker), _seen(shown, frame.camera)
        seam_px = frame.field.seam_px(target.label if required.label is None else required.label)
        radius_px = 2 * marker.area / marker.perimeter * shown.scale  # what an edge errs is so much of the scale
        depth = seen.zoom / (shown.scale * (1 + seam_px / radius_px))
        noise = np.hypot(self._config.flat_edge_px, self._config.seam_share * seam_px) / radius_px
        centre = np.append(seen.place, 1.0) * depth
        turn = seen.theta - marker.axis_angle
        c, s = np.cos(turn), np.sin(turn)
        R = np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])  # the marker's y is up, its z towards the camera
        T_camera_marker = Pose(R, centre - R @ np.append(marker.centroid, 0.0))
        pose = T_camera_marker @ (marker.T_component_marker or Pose.identity()).inverse()
        covariance = self._covariance(seen.place, depth, noise, pose.position - centre)
        place_px = np.hypot(self._contour.contour_noise_px, self._contour.model_noise * radius_px)
        covariance[:2, :2] += np.eye(2) * (place_px / shown.scale) ** 2
        return replace(detection, pose=pose, pose_covariance=covariance, pose_from="size")

    def _covariance(self, place: Array, depth: float, noise: float, arm: Array) -> Array:
        """(6, 6) of the object's frame, for a marker whose centre is seen at x/z, y/z.

        To first order a tilt by w about the camera's axes changes the marker's size by (w_y x - w_x y) / 2, as a share,
        and its direction by (w_x x + w_y y) / 2: the off-diagonal and skew parts of I - (x, y) (-w_y, w_x), which is
        what its outline is mapped by. At the image's middle only the second order is left.

        :param noise: deviation of the scale, a share; of the direction, radians.
        :param arm: from the marker's centre to the origin of the object's frame.
        """
        (x, y), tilt = place, self._tilt_rad
        ray = np.append(place, 1.0)
        turns = np.eye(3)  # of the object, by a tilt about x and y, and by an error of its direction
        turns[2, :2] = -x / 2, -y / 2
        moves = np.outer(ray, (-y / 2, x / 2, 0.0)) * depth - skew(arm) @ turns
        causes = np.array([tilt / 2, tilt / 2, np.hypot(noise, tilt**2 / 10)])  # deviations, over a cone of tilts
        farther = np.hypot(noise, tilt**2 / (4 * np.sqrt(3.0)))  # of 1 - sqrt(cos tilt) over that cone
        linear = np.concatenate([moves, turns]) * causes
        along = np.pad(ray * depth * farther, (0, 3))
        covariance = linear @ linear.T + np.outer(along, along)
        covariance[:3, :3] += np.eye(3) * (arm @ arm) * tilt**4 / 24  # of 1 - cos tilt, by which the arm gets shorter
        return np.asarray(covariance, np.float64)


def _seen(shown: Instance, camera: Camera) -> _Seen:
    step = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])  # to, along and across the marker's axis
    c, s = np.cos(shown.theta), np.sin(shown.theta)
    place, along, across = normalise(camera, step @ np.array([[c, s], [-s, c]]) + (shown.x, shown.y))
    jacobian = np.stack([along - place, across - place])
    return _Seen(place, float(np.arctan2(*jacobian[0, ::-1])), float(abs(np.linalg.det(jacobian)) ** -0.5))
