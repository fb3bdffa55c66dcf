"""How well a detection continues what is known of an object: in space where both have a pose, else in the image."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base.config import SightingsConfig, TrackingConfig
from ..geometry.transforms import Array, rotation_from_rotvec
from ..model.found import Detection
from .motion import MotionModel, MotionState

_SCALE_PER_M = 1.0  # a step of a metre changes the logarithm of the scale by this: as a metre away


@dataclass(frozen=True)
class Sighting:
    """Where a detection was, in one of two spaces: the camera's (metres), or the image's (x, y in pixels, log scale).

    :param place: (3,). :param noise: (3, 3) its covariance. :param unit: (3,) what a metre is along each axis.
    :param rotation: (3, 3). :param turn_variance: rad^2 about each axis. :param turn_axes: about how many it turns.
    :param newcomer: density of newcomers, per unit of place.
    """

    place: Array
    noise: Array
    unit: Array
    rotation: Array
    turn_variance: float
    turn_axes: int
    newcomer: float

    @classmethod
    def in_space(cls, detection: Detection, config: SightingsConfig) -> Sighting | None:
        """None: the detection has no pose, or one that tells no more than the image from which it is."""
        if detection.pose is None or detection.pose_from != "fit":
            return None
        place, covariance = detection.pose.position, detection.pose_covariance
        noise = np.zeros((6, 6)) if covariance is None else covariance
        range_m = max(float(np.linalg.norm(place)), 1e-3)
        least = (config.range_share * range_m) ** 2 * np.eye(3)
        turn = float(np.trace(noise[3:, 3:])) / 3 + config.turn_rad**2
        # what is in view at a range is about a cube of that size
        return cls(place, noise[:3, :3] + least, np.ones(3), detection.pose.rotation, turn, 3, range_m**-3)

    @classmethod
    def in_image(cls, detection: Detection, size: tuple[int, int], config: SightingsConfig) -> Sighting:
        """:param size: (width, height) pixels."""
        image = detection.image
        place = np.array([image.x, image.y, np.log(max(image.scale, 1e-9))])
        noise = np.diag([config.place_px, config.place_px, config.scale_share]) ** 2
        unit = np.array([image.scale, image.scale, _SCALE_PER_M])
        rotation = rotation_from_rotvec([0.0, 0.0, image.theta])
        return cls(place, noise, unit, rotation, config.turn_rad**2, 1, 1.0 / (size[0] * size[1]))


@dataclass(frozen=True)
class Trace:
    """What is known of an object's motion in one of the two spaces.

    :param state: as it is expected to be now, `age_s` after the last sighting.
    """

    state: MotionState
    last: Sighting
    age_s: float = 0.0

    @classmethod
    def begun(cls, sighting: Sighting, model: MotionModel) -> Trace:
        return cls(MotionState.first_seen(sighting.place, sighting.noise, sighting.unit, model), sighting)

    def continued(self, sighting: Sighting) -> Trace:
        return Trace(self.state.seen(sighting.place, sighting.noise), sighting)

    def older(self, dt_s: float, model: MotionModel) -> Trace:
        return replace(self, state=self.state.after(dt_s, self.last.unit, model), age_s=self.age_s + dt_s)


def surprise(sighting: Sighting, traces: Sequence[Trace], config: TrackingConfig) -> Array:
    """(T,) -2 log of how much likelier a sighting is if it is this object than if it is a newcomer."""
    S = np.array([t.state.place_covariance for t in traces]) + sighting.noise
    error = sighting.place - np.array([t.state.place for t in traces])
    place = np.sum(error * np.linalg.solve(S, error[..., None])[..., 0], axis=1)
    spread = np.linalg.slogdet(2 * np.pi * S)[1]
    newcomer = 2 * np.log(config.newcomer_odds * sighting.newcomer)
    return place + spread + newcomer - 2 * np.log(_turn_ratio(sighting, traces, config))


def _turn_ratio(sighting: Sighting, traces: Sequence[Trace], config: TrackingConfig) -> Array:
    """(T,) how much likelier its turn is than any other; a wrong one speaks only so much against it."""
    cosine = (np.sum([t.last.rotation * sighting.rotation for t in traces], axis=(1, 2)) - 1) / 2
    angle = np.arccos(np.clip(cosine, -1, 1))
    variance = (
        np.array([t.last.turn_variance + (config.turn_rate * t.age_s) ** 2 for t in traces]) + sighting.turn_variance
    )
    anywhere = 8 * np.pi**2 if sighting.turn_axes == 3 else 2 * np.pi
    peak = np.maximum(anywhere / (2 * np.pi * variance) ** (sighting.turn_axes / 2), 1.0)
    misturned = config.sightings.misturned
    return (1 - misturned) * peak * np.exp(-0.5 * angle**2 / variance) + misturned
