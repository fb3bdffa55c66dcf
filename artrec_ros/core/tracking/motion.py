"""Where objects are expected next: Kalman filters of places, turns and speeds, all of a frame at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, rotation_from_rotvec, rotvec_from_rotation

Counts = NDArray[np.intp]
Flags = NDArray[np.bool_]
Rows = Counts | Flags | Sequence[int]


@dataclass(frozen=True)
class MotionModel:
    """Speeds that last a while: nearly constant within `steady_s`, forgotten long after (Ornstein-Uhlenbeck).

    Unlike with constant speed, what is known of a place fades slowly and without losing touch: after a time T it
    is speed * sqrt(2 T steady_s).

    :param speed: standard deviation along each axis, units of the axis a second.
    :param steady_s: the speeds' time constant.
    """

    speed: float
    steady_s: float

    def step(self, dt_s: float) -> tuple[Array, Array]:
        """Transition (2, 2) of (place, speed) along one axis, and the noise (2, 2) that comes on top."""
        tau, left = self.steady_s, float(np.exp(-dt_s / self.steady_s))
        gone = -float(np.expm1(-dt_s / self.steady_s))
        place = tau**2 * max(2 * dt_s / tau - 2 * gone - gone**2, 0.0)
        both = tau * gone**2
        noise = self.speed**2 * np.array([[place, both], [both, 1 - left**2]])
        return np.array([[1.0, tau * gone], [0.0, left]]), noise


@dataclass(frozen=True)
class MotionState:
    """Places and speeds of T things along n axes.

    :param mean: (T, 2, n) place and speed. :param covariance: (T, 2, 2, n, n); [:, 0, 0] of places, [:, 0, 1] of places
        with speeds. :param unit: (T, n) what a unit of the model's speed is along each axis.
    """

    mean: Array
    covariance: Array
    unit: Array

    def __len__(self) -> int:
        return len(self.mean)

    def __getitem__(self, rows: Rows) -> MotionState:
        return MotionState(self.mean[rows], self.covariance[rows], self.unit[rows])

    @classmethod
    def first_seen(cls, place: Array, noise: Array, unit: Array, model: MotionModel) -> MotionState:
        """:param place: (T, n). :param noise: (T, n, n) its covariance. :param unit: (T, n)."""
        n = place.shape[1]
        covariance = np.zeros((len(place), 2, 2, n, n))
        covariance[:, 0, 0] = noise
        covariance[:, 1, 1, range(n), range(n)] = (model.speed * unit) ** 2
        return cls(np.stack([place, np.zeros(place.shape)], axis=1), covariance, unit)

    @classmethod
    def joined(cls, parts: Sequence[MotionState]) -> MotionState:
        """The rows of all, in order."""
        means, covariances, units = zip(*((p.mean, p.covariance, p.unit) for p in parts), strict=True)
        return cls(np.concatenate(means), np.concatenate(covariances), np.concatenate(units))

    def replaced(self, rows: Rows, states: MotionState) -> MotionState:
        """With some rows by others."""
        new = MotionState(self.mean.copy(), self.covariance.copy(), self.unit.copy())
        new.mean[rows], new.covariance[rows], new.unit[rows] = states.mean, states.covariance, states.unit
        return new

    @property
    def place(self) -> Array:
        return self.mean[:, 0]

    @property
    def place_covariance(self) -> Array:
        return self.covariance[:, 0, 0]

    def after(self, dt_s: float, model: MotionModel) -> MotionState:
        """The states a time later."""
        F, Q = model.step(dt_s)
        n = self.mean.shape[2]
        blocks = self.covariance.reshape(-1, 4, n * n)
        twice = (F[:, None, :, None] * F[:, None]).reshape(4, 4)
        moved = (twice @ blocks).reshape(self.covariance.shape)  # F C F'
        moved[..., range(n), range(n)] += Q[:, :, None] * (self.unit**2)[:, None, None]
        return MotionState(F @ self.mean, moved, self.unit)

    def seen(self, place: Array, noise: Array) -> MotionState:
        """The states once places (T, n) were measured; `noise` (T, n, n) is the measurements' covariance."""
        return self.corrected(place - self.place, noise)

    def corrected(self, error: Array, noise: Array) -> MotionState:
        """The same by what was measured beyond what was expected, (T, n)."""
        C = self.covariance
        gain = C[:, :, 0] @ np.linalg.inv(C[:, 0, 0] + noise)[:, None]  # (T, 2, n, n)
        mean = self.mean + (gain @ error[:, None, :, None])[..., 0]
        left = C - gain[:, :, None] @ C[:, 0, None]
        return MotionState(mean, (left + left.transpose(0, 2, 1, 4, 3)) / 2, self.unit)


@dataclass(frozen=True)
class Bodies:
    """Where T bodies are in space, how they are turned, and how fast both change.

    The error-state (multiplicative) filter: turns are kept apart from `motion`, whose last three axes hold how far
    off they are, about the fixed axes x, y, z, as a rotation vector (Markley, Attitude error representations for
    Kalman filtering, 2003).

    :param motion: along x, y, z and about them. :param turn: (T, 3, 3) rotations.
    """

    motion: MotionState
    turn: Array

    def __getitem__(self, rows: Rows) -> Bodies:
        return Bodies(self.motion[rows], self.turn[rows])

    @classmethod
    def joined(cls, parts: Sequence[Bodies]) -> Bodies:
        return cls(MotionState.joined([p.motion for p in parts]), np.concatenate([p.turn for p in parts]))

    @classmethod
    def first_seen(cls, place: Array, turn: Array, noise: Array, unit: Array, model: MotionModel) -> Bodies:
        """:param noise: (T, 6, 6). :param unit: (T, 6)."""
        return cls(MotionState.first_seen(_with_turn(place), noise, unit, model), turn)

    def after(self, dt_s: float, model: MotionModel) -> Bodies:
        return _settled(self.motion.after(dt_s, model), self.turn)

    def seen(self, place: Array, turn: Array, noise: Array) -> Bodies:
        """After measurements. :param place: (T, 3) metres. :param turn: (T, 3, 3). :param noise: (T, 6, 6) of both."""
        return _settled(self.motion.corrected(self.error(place, turn), noise), self.turn)

    def replaced(self, rows: Rows, bodies: Bodies) -> Bodies:
        """With some rows by others."""
        turn = self.turn.copy()
        turn[rows] = bodies.turn
        return Bodies(self.motion.replaced(rows, bodies.motion), turn)

    def error(self, place: Array, turn: Array) -> Array:
        """(T, 6) how far measured places and turns are off."""
        turned = rotvec_from_rotation(turn @ self.turn.transpose(0, 2, 1))
        return np.concatenate([place - self.motion.place[:, :3], turned], axis=1)


def calmed(state: MotionState, dt_s: float, most: Array, axes: int, model: MotionModel, least: float) -> MotionState:
    """With `unit` brought nearer to how fast each has been of late: who moves little is not expected to run off.

    :param most: (T, n) what `unit` is at most. :param axes: so many in a row have one.
    :param least: share of `most` that it is at least.
    """
    T, n = state.unit.shape
    square = state.mean[:, 1] ** 2 + np.diagonal(state.covariance[:, 1, 1], axis1=1, axis2=2)
    pace = np.repeat(square.reshape(T, n // axes, axes).mean(axis=2), axes, axis=1) / max(model.speed, 1e-9) ** 2
    share = -np.expm1(-dt_s / model.steady_s)
    unit = np.clip(np.sqrt(state.unit**2 + share * (pace - state.unit**2)), least * most, most)
    return MotionState(state.mean, state.covariance, unit)


def _with_turn(place: Array) -> Array:
    return np.concatenate([place, np.zeros(place.shape)], axis=1)


def _settled(motion: MotionState, turn: Array) -> Bodies:
    """With the turn's error taken over into the turn."""
    mean = motion.mean.copy()
    mean[:, 0, 3:] = 0.0
    return Bodies(MotionState(mean, motion.covariance, motion.unit), rotation_from_rotvec(motion.mean[:, 0, 3:]) @ turn)
