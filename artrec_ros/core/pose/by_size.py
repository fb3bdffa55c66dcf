"""Metric poses of objects that were found flat: by their size in the image, as if they faced the camera.

A marker of known size that lies parallel to the image plane at depth z shows f / z pixels per metre. So its place in
the image and its scale give its place in space, and its direction the turn about the optical axis. How far it is
tilted they do not tell: it is taken to be parallel, and the covariance says by how much it may not be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.camera import Camera
from ..geometry.projection import normalise
from ..geometry.transforms import Array, Pose, skew
from ..image.image_frame import ImageFrame
from ..model.found import Detection, Instance
from ..model.marker import Marker
from ..model.target import Target


class SizePlacer:
    """Places objects of these targets."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig) -> None:
        self._targets = {t.name: t for t in targets}
        self._config, self._contour = config.covariance, config.constraints
        # markers turned away by more are missed
        self._tilt_rad = float(np.radians(max(self._config.flat_tilt_deg, config.max_slant_deg)))

    def placed(self, detections: Sequence[Detection], frame: ImageFrame) -> tuple[Detection, ...]:
        """The same detections; those without a pose get one by their size, where the required component is told.

        It is that of the object's frame where the object file tells the marker's pose in it, else of the frame of
        the marker that shows the required component.
        """
        flat = [n for n, d in enumerate(detections) if d.pose is None and self._shown(d)]
        if not flat:
            return tuple(detections)
        out = list(detections)
        poses, covariances = self._poses([detections[n] for n in flat], frame)
        for n, pose, covariance in zip(flat, poses, covariances, strict=True):
            out[n] = replace(out[n], pose=pose, pose_covariance=covariance, pose_from="size")
        return tuple(out)

    def _poses(self, detections: Sequence[Detection], frame: ImageFrame) -> tuple[list[Pose], Array]:
        """The pose of each and its covariance, (n, 6, 6)."""
        config = self._config
        shown = [s for d in detections if (s := self._shown(d)) is not None]
        markers = [self._marker(d, s) for d, s in zip(detections, shown, strict=True)]
        scale = np.array([s.scale for s in shown])
        radius_px = np.array([m.radius for m in markers]) * scale  # an edge that errs errs the scale
        seam_px = np.array([self._seam_px(d, frame) for d in detections])
        place, theta, zoom = _seen(shown, frame.camera)
        depth = zoom / (scale * (1 + seam_px / radius_px))
        centre = np.column_stack([place, np.ones(len(shown))]) * depth[:, None]
        R = _facing(theta - [m.axis_angle for m in markers])
        origins = [_origin(m) for m in markers]
        poses = [Pose(r @ T.rotation, r @ T.position + c) for r, c, T in zip(R, centre, origins, strict=True)]
        arm = np.array([p.position for p in poses]) - centre
        noise = np.hypot(config.flat_edge_px, config.seam_share * seam_px) / radius_px
        covariances = self._covariances(place, depth, noise, arm)
        place_px = np.hypot(self._contour.contour_noise_px, self._contour.model_noise * radius_px)
        covariances[:, [0, 1], [0, 1]] += ((place_px / scale) ** 2)[:, None]
        return poses, covariances

    def _shown(self, detection: Detection) -> Instance | None:
        return detection.instance_of(self._targets[detection.object].model.required.name)

    def _marker(self, detection: Detection, shown: Instance) -> Marker:
        return self._targets[detection.object].model.required.marker(shown.marker)

    def _seam_px(self, detection: Detection, frame: ImageFrame) -> float:
        target = self._targets[detection.object]
        own = target.model.required.label
        return frame.field.seam_px(target.label if own is None else own)

    def _covariances(self, place: Array, depth: Array, noise: Array, arm: Array) -> Array:
        """(n, 6, 6) of the objects' frames, for markers whose centres are seen at x/z, y/z.

        To first order a tilt by w about the camera's axes changes a marker's size by (w_y x - w_x y) / 2, as a share,
        and its direction by (w_x x + w_y y) / 2: the even and the skew part of I - (x, y) (-w_y, w_x), which is what
        its outline is mapped by. At the image's middle only the second order is left.

        :param place: (n, 2). :param noise: (n,) deviation of the scale, a share; of the direction, radians.
        :param arm: (n, 3) from the marker's centre to the origin of the object's frame.
        """
        n, (x, y), tilt = len(place), place.T, self._tilt_rad
        ray = np.column_stack([place, np.ones(n)]) * depth[:, None]
        turns = np.tile(np.eye(3), (n, 1, 1))  # of the object, by a tilt about x and y, by its direction's error
        turns[:, 2, 0], turns[:, 2, 1] = -x / 2, -y / 2
        larger = np.column_stack([-y / 2, x / 2, np.zeros(n)])
        moves = ray[:, :, None] * larger[:, None] - skew(arm) @ turns
        cone = np.full(n, tilt / 2)  # deviation about each axis, over a cone of tilts
        causes = np.column_stack([cone, cone, np.hypot(noise, tilt**2 / 10)])
        linear = np.concatenate([moves, turns], axis=1) * causes[:, None]
        farther = np.hypot(noise, tilt**2 / (4 * np.sqrt(3.0)))  # of 1 - sqrt(cos tilt) over that cone
        covariances = linear @ linear.swapaxes(1, 2)
        covariances[:, :3, :3] += ray[:, :, None] * ray[:, None] * (farther**2)[:, None, None]
        shorter = np.sum(arm**2, axis=1) * tilt**4 / 24  # of 1 - cos tilt, which shortens the arm
        covariances[:, [0, 1, 2], [0, 1, 2]] += shorter[:, None]
        return np.asarray(covariances, np.float64)


def _seen(shown: Sequence[Instance], camera: Camera) -> tuple[Array, Array, Array]:
    """Markers through an undistorted camera: (n, 2) their places, x/z and y/z; directions; pixels per unit there."""
    at = np.array([[s.x, s.y] for s in shown])
    theta = np.array([s.theta for s in shown])
    c, s = np.cos(theta), np.sin(theta)
    pixels = np.stack([at, at + np.column_stack([c, s]), at + np.column_stack([-s, c])])  # to, along, across
    place, along, across = normalise(camera, pixels.reshape(-1, 2)).reshape(3, -1, 2)
    along, across = along - place, across - place
    area = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    return place, np.arctan2(along[:, 1], along[:, 0]), np.abs(area) ** -0.5


def _facing(turn: Array) -> Array:
    """(n, 3, 3) rotations of markers that face the camera, turned about its axis: their y is up, their z towards it."""
    c, s = np.cos(turn), np.sin(turn)
    R = np.zeros((len(turn), 3, 3))
    R[:, 0, 0], R[:, 0, 1], R[:, 1, 0], R[:, 1, 1], R[:, 2, 2] = c, s, s, -c, -1.0
    return R


def _origin(marker: Marker) -> Pose:
    """The object's frame in one with the marker's axes, and its centroid as origin."""
    T_marker_object = (marker.T_component_marker or Pose.identity()).inverse()
    return Pose(T_marker_object.rotation, T_marker_object.position - np.append(marker.centroid, 0.0))
