"""What a frame's detections tell of places and turns, and how well each continues what is known of an object."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from ..base.config import SightingsConfig, TrackingConfig
from ..geometry.transforms import Array, rotvec_from_rotation, wrap_angle
from ..model.found import Detection
from ..model.target import Target
from .motion import Bodies, Counts, Flags
from .tracks import Tracks

_SCALE_PER_M = 1.0  # a step of a metre changes the logarithm of the scale by this: as a metre away
_LEAST_SCALE, _LEAST_RANGE_M = 1e-9, 1e-3
_NOWHERE = np.zeros(3), np.eye(3), np.eye(6)
_UNTOLD, _LEAST_NOISE = np.zeros((6, 6)), 1e-12 * np.eye(6)


@dataclass(frozen=True)
class Sightings:
    """Where D detections were: in the image (x, y in pixels, log scale), and in the camera's space (metres).

    :param place, unit: (D, 3) in the image, and what a metre is along each axis. :param noise: (D, 3, 3).
    :param theta: (D,) direction in the image. :param posed: (D,) whether it has a pose in space that tells
        more than the image from which it is. :param placed: (D,) whether it has one that a filter follows, be it one on
        a plane, in that plane's frame. :param position, turn: (D, 3), (D, 3, 3). :param pose_noise: (D, 6, 6).
    :param range_m: (D,). :param size_m: (D,) of their required components; 0: not known.
    """

    place: Array
    noise: Array
    unit: Array
    theta: Array
    posed: Flags
    placed: Flags
    position: Array
    turn: Array
    pose_noise: Array
    range_m: Array
    size_m: Array

    def __getitem__(self, rows: Sequence[int]) -> Sightings:
        index = np.array(rows, int)
        return Sightings(*(getattr(self, f.name)[index] for f in fields(self)))

    @classmethod
    def of(cls, detections: Sequence[Detection], sizes: Mapping[str, float], config: SightingsConfig) -> Sightings:
        """:param sizes: object's name -> size of its required component, metres."""
        n = len(detections)
        image = np.array([(d.image.x, d.image.y, d.image.scale, d.image.theta) for d in detections]).reshape(n, 4)
        place, scale = image[:, :3].copy(), image[:, 2]
        place[:, 2] = np.log(np.maximum(scale, _LEAST_SCALE))
        unit = np.stack([scale, scale, np.full(n, _SCALE_PER_M)], axis=1)
        noise = np.diag([config.place_px, config.place_px, config.scale_share]) ** 2
        poses = [_pose(d) for d in detections]
        position, turn, pose_noise = (np.array([p[i] for p in poses]) for i in range(3)) if n else _NO_POSES
        untold = np.array([n for n, p in enumerate(poses) if p[2] is _UNTOLD], int)
        posed = np.array([d.pose is not None and d.pose_from == "fit" for d in detections], bool)
        placed = np.array([is_placed(d) for d in detections], bool)
        range_m = np.maximum(np.sqrt((position**2).sum(axis=1)), _LEAST_RANGE_M)
        noise = np.broadcast_to(noise, (n, 3, 3))
        usual = np.repeat([config.range_share, config.turn_rad], 3)
        pose_noise[untold] = np.square(range_m[untold, None] ** (np.arange(6) < 3) * usual)[:, None] * np.eye(6)
        pose_noise = pose_noise + _LEAST_NOISE
        size_m = np.array([sizes.get(d.object, 0.0) for d in detections])
        return cls(place, noise, unit, image[:, 3], posed, placed, position, turn, pose_noise, range_m, size_m)


def is_placed(d: Detection) -> bool:
    """Whether it has a pose of which a filter makes sense: what is known by its size alone leaps to and fro."""
    return d.pose is not None and d.pose_from in ("fit", "plane")


def sizes_of(targets: Sequence[Target]) -> dict[str, float]:
    """How large the markers of each object's required component are, metres."""
    return {
        t.name: max(float(np.ptp(marker.outline, axis=0).max()) for marker in t.model.required.markers) for t in targets
    }


_NO_POSES = np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, 6, 6))


def _pose(d: Detection) -> tuple[Array, Array, Array]:
    if d.pose is None or not is_placed(d):
        return _NOWHERE
    return d.pose.position, d.pose.rotation, _UNTOLD if d.pose_covariance is None else d.pose_covariance


def agreement(s: Sightings, tracks: Tracks, possible: Flags, area_px: float, config: TrackingConfig) -> Array:
    """(D, T) how many times likelier each detection is if it is each of the objects than if it is a newcomer.

    A pose that is wrong altogether, by a mirrored turn or in its range, still lies where it should in the image: so a
    detection is either where it is in space, or only where it is in the image.

    :param possible: (D, T) pairs to look at; 0 for others. :param area_px: of the image.
    """
    odds, image, of = np.zeros(possible.shape), tracks.image, config.sightings
    d, t = np.nonzero(possible)
    angle = wrap_angle(s.theta[d] - tracks.theta[t])
    variance = 2 * of.turn_rad**2 + (config.turn_rate * tracks.age_s[t]) ** 2
    place = _place_ratio(s.place[d] - image.place[t], image.place_covariance[t] + s.noise[d], area_px)
    wrong = of.misturned
    odds[d, t] = place * ((1 - wrong) * _turn_ratio(angle, variance, 1) + wrong)
    both = s.posed[d] & tracks.in_camera[t]
    if both.any():
        d, t, wrong = d[both], t[both], of.misplaced
        off_px = of.off_share * s.unit[d, 0] * s.size_m[d]
        S = image.place_covariance[t] + s.noise[d]
        S[:, range(3), range(3)] += np.square([off_px, off_px, np.full(len(d), of.off_scale)]).T
        flat = _place_ratio(s.place[d] - image.place[t], S, area_px)
        odds[d, t] = (1 - wrong) * _in_space(s, d, tracks.bodies, t, config) + wrong * flat
    return odds / config.newcomer_odds


def _in_space(s: Sightings, d: Counts, bodies: Bodies, t: Counts, config: TrackingConfig) -> Array:
    """A pose that is turned wrongly is off in place, too."""
    of = config.sightings
    error = s.position[d] - bodies.motion.place[t, :3]
    P = bodies.motion.place_covariance[t] + s.pose_noise[d]
    ray, room = s.position[d], s.range_m[d] ** 3  # what is in view at a range is about a cube of that size
    along, across = ray[:, :, None] * ray[:, None], (s.range_m[d] ** 2)[:, None, None] * np.eye(3)
    tight = P[:, :3, :3] + of.range_share**2 * along + of.bearing_rad**2 * (across - along)
    angle = np.sqrt((rotvec_from_rotation(s.turn[d] @ bodies.turn[t].transpose(0, 2, 1)) ** 2).sum(axis=1))
    variance = np.trace(P[:, 3:, 3:], axis1=1, axis2=2) / 3 + of.turn_rad**2
    right = _place_ratio(error, tight, room) * _turn_ratio(angle, variance, 3)
    wrong = _place_ratio(error, P[:, :3, :3] + of.misturned_share**2 * across, room)
    return np.asarray((1 - of.misturned) * right + of.misturned * wrong)


def _place_ratio(error: Array, S: Array, room: Array | float) -> Array:
    """How much likelier errors (n, 3) of covariance S are than any place in a room of that size."""
    inverse = np.linalg.inv(S)
    far = np.einsum("ni,nij,nj->n", error, inverse, error)
    peak = np.sqrt(np.abs(np.linalg.det(inverse)) / (2 * np.pi) ** error.shape[1])
    return np.asarray(room * peak * np.exp(-0.5 * np.minimum(far, 1400)))


def _turn_ratio(angle: Array, variance: Array, axes: int) -> Array:
    """How much likelier turns are than any other."""
    anywhere = 8 * np.pi**2 if axes == 3 else 2 * np.pi
    peak = np.maximum(anywhere / (2 * np.pi * variance) ** (axes / 2), 1.0)
    return np.asarray(peak * np.exp(-0.5 * angle**2 / variance))
