"""Intervals of lengths and of angles, learned from examples with a margin of stated coverage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..base.errors import ConfigError
from ..geometry.transforms import Array, wrap_angle

_TURN = 2 * np.pi
_ROUNDED = 0.02  # radians: a whole turn that somebody wrote with two decimals is one


@dataclass(frozen=True)
class Interval:
    """Closed interval [low, high]; of angles where `period` > 0 (low <= high, high may pass pi)."""

    low: float
    high: float
    period: float = 0.0

    @property
    def width(self) -> float:
        return self.high - self.low

    def excess(self, values: ArrayLike) -> Array:
        """How far each value lies outside, 0 inside; along the shorter way round for angles."""
        v = np.asarray(values, float)
        if self.period > 0:
            middle = (self.low + self.high) / 2
            return np.maximum(np.abs(wrap_angle(v - middle, self.period)) - self.width / 2, 0.0)
        return np.maximum(np.maximum(self.low - v, v - self.high), 0.0)

    @classmethod
    def around(cls, values: ArrayLike) -> Interval:
        """The smallest interval that holds all values: the paper's box, one side of it."""
        v = np.asarray(values, float)
        return cls(float(v.min()), float(v.max()))

    @classmethod
    def around_angles(cls, values: ArrayLike, period: float = 2 * np.pi) -> Interval:
        """The complement of the largest empty arc between angles; its low end lies in [-period/2, period/2)."""
        v = np.sort(wrap_angle(values, period).ravel())
        gaps = np.append(v[1:], v[0] + period) - v
        widest = int(np.argmax(gaps))
        low = float(v[(widest + 1) % len(v)])
        return cls(low, low + period - float(gaps[widest]), period)


def interval_from_list(ends: Sequence[float], where: str, period: float = 0.0) -> Interval:
    """Of [low, high], or [low, high, period] of an angle. Raises `ConfigError` naming `where`.

    :param period: of an angle that names none; 0: it is an angle only where it names one.
    """
    if len(ends) not in (2, 3):
        raise ConfigError(f"{where}: {list(ends)} must be [low, high], or [low, high, period] of an angle")
    low, high, period = (*map(float, ends), period)[:3]
    if not (np.isfinite(low) and np.isfinite(high) and low <= high):
        raise ConfigError(f"{where}: [{low:g}, {high:g}] must run from low to high (an angle may pass pi)")
    if len(ends) == 3:
        order = _TURN / max(period, 1e-6)
        if not (order > 0.99 and abs(order - round(order)) < 0.01):
            raise ConfigError(f"{where}: its period {period:g} must be 2 pi over a whole number")
    if period and (abs(low) > _TURN + _ROUNDED or high - low > _TURN + _ROUNDED):
        raise ConfigError(
            f"{where}: [{low:g}, {high:g}] is no range of an angle in radians: low lies between -2 pi and 2 pi, "
            "high at most one turn, 2 pi, above it"
        )
    return Interval(low, high, period)


def expected_coverage(examples: int, margin: float = 0.0) -> float:
    """Share of new values expected inside the span of `examples` values widened by `margin` of it on each side.

    Without margin (E - 1)/(E + 1), whatever the distribution: each of E + 1 exchangeable values is as likely
    to be the least or the greatest. With one: by how much it is exceeded is known for even spread, where the
    ratio a of the outermost gap to the span of the rest has P(> a) = (1 + a)^-(E - 1).
    """
    if examples < 2:
        return 0.0
    return 1 - 2 / (examples + 1) * (1 + margin) ** -(examples - 1)


def margin_for_coverage(examples: int, coverage: float, greatest: float = 2.0) -> float:
    """The margin with which `expected_coverage` reaches `coverage`; no more than `greatest`."""
    if examples < 2:
        return greatest
    missing = (examples + 1) * (1 - coverage) / 2
    if missing >= 1:
        return 0.0
    return greatest if missing <= 0 else min(greatest, missing ** (-1 / (examples - 1)) - 1)
