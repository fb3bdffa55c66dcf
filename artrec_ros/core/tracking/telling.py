"""Detections as users get them: with what has been carried on, and those that are expected where nothing was seen."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..base.config import TrackingConfig
from ..geometry.transforms import Pose, rotvec_from_rotation, short_way
from ..model.found import Detection, Filtered, ImagePose, Motion
from .joints import Joints
from .sightings import is_placed
from .tracks import Tracks

_HALF = 0.5  # probability that it is where it was


class Teller:
    """Tells of tracks, as they are after a frame."""

    def __init__(
        self,
        tracks: Tracks,
        joints: Joints,
        config: TrackingConfig,
        size: tuple[int, int],
        sizes: Mapping[str, float],
        scores: Sequence[float] | None,
    ) -> None:
        """:param sizes: of objects' required components, metres. :param scores: of the tracks; None: detections keep
        theirs."""
        self._tracks, self._config, self._size, self._scores = tracks, config, size, scores
        self._sizes = sizes
        self._joints, self._endless = joints.told(), joints.endless_ones
        self._posed, self._times = tracks.posed.tolist(), tracks.times.tolist()

    def seen(self, detection: Detection, row: int) -> Detection:
        """What was found, as the track says."""
        motion = filtered = None
        if self._posed[row] and is_placed(detection):
            motion = self._motion(row, detection) if self._times[row] > 1 else None
            filtered = self._filtered(row, detection) if self._config.smooth else None
        number, identity = self._tracks.ids[row], self._tracks.identities[row]
        assert number is not None  # it is told
        score = detection.score
        if self._scores is not None and detection.is_in_doubt:
            score = self._scores[row] * detection.as_told  # how it lies each frame tells for itself
        return replace(detection, id=number, score=score, identity=identity, motion=motion, filtered=filtered)

    def _motion(self, row: int, detection: Detection) -> Motion:
        rates = {name: rate for name, _, _, rate in self._joints.get(row, ()) if rate == rate}
        joints = {name: rates[name] for name in detection.joints if name in rates}
        return Motion(self._tracks.bodies.motion.mean[row, 1], joints)

    def _filtered(self, row: int, detection: Detection) -> Filtered:
        known = [
            (name, q, deviation) for name, q, deviation, _ in self._joints.get(row, ()) if name in detection.joints
        ]
        joints = {name: q for name, q, _ in known}
        deviations = {name: deviation for name, _, deviation in known}
        told = Filtered(self._pose(row), self._tracks.bodies.motion.place_covariance[row], joints, deviations)
        if not self._tracks.strange[row]:
            return told
        return _as_likely(told, detection, {name for name in joints if (row, name) in self._endless})

    def _pose(self, row: int) -> Pose:
        return Pose(self._tracks.bodies.turn[row], self._tracks.bodies.motion.place[row, :3])

    def expected(self, rows: Sequence[int]) -> Iterator[Detection]:
        """Those of these tracks, which were not seen, that are likely where they should be by now."""
        tracks, c = self._tracks, self._config
        likely = tracks.existence.probability
        for row in rows:
            if tracks.ids[row] is None or tracks.age_s[row] > c.predict:
                continue
            score = float(likely[row]) * self._in_its_place(row)
            if score >= c.existence.least and (detection := self._predicted(row, score)) is not None:
                yield detection

    def _in_its_place(self, row: int) -> float:
        """Probability that an object that is there lies so near to where it is expected, across the line of sight or on
        the plane, that its required component's middle would still be on itself; of one whose size is not known 1."""
        tracks, half = self._tracks, self._sizes.get(self._tracks.names[row], 0.0) / 2
        state, sight = tracks.bodies.motion, np.array([0.0, 0.0, 1.0])  # on a plane, and in the image
        if not self._posed[row]:
            state, half = tracks.image, half * float(np.exp(tracks.expected[row, 2]))  # pixels
        elif tracks.in_camera[row]:
            sight = state.place[row, :3] / max(float(np.linalg.norm(state.place[row, :3])), 1e-9)
        covariance = state.place_covariance[row][:3, :3]
        variance = float(np.trace(covariance) - sight @ covariance @ sight) / 2
        return float(-np.expm1(-(half**2) / (2 * variance))) if half and variance > 0 else 1.0

    def _predicted(self, row: int, score: float) -> Detection | None:
        """None: it would be out of view."""
        tracks, last = self._tracks, self._tracks.last[row]
        x, y, scale = tracks.expected[row].tolist()
        pose = self._pose(row) if self._posed[row] and is_placed(last) else None
        behind = pose is not None and last.pose_from == "fit" and pose.position[2] <= 0
        if behind or not (0 <= x <= self._size[0] and 0 <= y <= self._size[1]):
            return None
        number = tracks.ids[row]
        assert number is not None  # it has been told
        detection = Detection(
            last.object, number, score, ImagePose(x, y, last.image.theta, float(np.exp(scale))), (),
            pose,
            {name: q for name, q, _, _ in self._joints.get(row, ())} if pose is not None else {},
            None if pose is None else tracks.bodies.motion.place_covariance[row],
            identity=tracks.identities[row],
            frame_id="" if pose is None else last.frame_id,
            pose_from=last.pose_from,
            predicted=True,
        )  # fmt: skip
        known = pose is not None and self._times[row] > 1
        return replace(detection, motion=self._motion(row, detection)) if known else detection


def _as_likely(told: Filtered, detection: Detection, endless: Collection[str]) -> Filtered:
    """What a filter says of an object that a frame shows elsewhere: either may be right. :param endless: joints that
    turn without end."""
    pose, joints = detection.pose, detection.joints
    assert pose is not None  # else it would not be followed in space
    turned = rotvec_from_rotation(pose.rotation @ told.pose.rotation.T)
    off = np.concatenate([pose.position - told.pose.position, turned])
    deviations = {}
    for name, deviation in told.joint_deviations.items():
        bent = short_way(np.array(joints[name] - told.joints[name]), np.array(name in endless))
        deviations[name] = float(np.sqrt(deviation**2 + _HALF * bent**2))
    return replace(told, covariance=told.covariance + _HALF * np.outer(off, off), joint_deviations=deviations)
