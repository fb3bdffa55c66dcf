"""Intervals of lengths and of angles, learned from examples with a margin of stated coverage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..geometry.transforms import Array, wrap_angle


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
