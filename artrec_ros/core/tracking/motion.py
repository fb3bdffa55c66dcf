"""Where an object is expected next: a Kalman filter of place and speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.transforms import Array


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
    """Place and speed along n axes.

    :param mean: (2, n) place and speed. :param covariance: (2 n, 2 n), places first.
    """

    mean: Array
    covariance: Array

    @classmethod
    def first_seen(cls, place: Array, noise: Array, unit: Array, model: MotionModel) -> MotionState:
        """:param unit: (n,) what a metre is along each axis."""
        n = len(place)
        covariance = np.zeros((2 * n, 2 * n))
        covariance[:n, :n] = noise
        covariance[n:, n:] = np.diag((model.speed * unit) ** 2)
        return cls(np.stack([place, np.zeros(n)]), covariance)

    @property
    def place(self) -> Array:
        return self.mean[0]

    @property
    def place_covariance(self) -> Array:
        n = self.mean.shape[1]
        return self.covariance[:n, :n]

    def after(self, dt_s: float, unit: Array, model: MotionModel) -> MotionState:
        """The state a time later."""
        F, Q = model.step(dt_s)
        n = len(unit)
        blocks = self.covariance.reshape(2, n, 2, n)
        moved = np.einsum("ab,bicj,dc->aidj", F, blocks, F)
        moved[:, range(n), :, range(n)] += Q * (unit**2)[:, None, None]
        return MotionState(F @ self.mean, moved.reshape(2 * n, 2 * n))

    def seen(self, place: Array, noise: Array) -> MotionState:
        """The state once the place was measured; `noise` (n, n) is the measurement's covariance."""
        n = len(place)
        gain = np.linalg.solve(self.place_covariance + noise, self.covariance[:n]).T  # (2 n, n)
        left = np.eye(2 * n) - gain @ np.eye(n, 2 * n)
        mean = self.mean.reshape(-1) + gain @ (place - self.place)
        # Joseph's form stays symmetric and positive whatever rounding does
        return MotionState(mean.reshape(2, n), left @ self.covariance @ left.T + gain @ noise @ gain.T)
