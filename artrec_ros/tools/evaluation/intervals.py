"""Figures with 95 % confidence intervals. Seeded: the same data gives the same interval."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from ...core.geometry.transforms import Array

CONFIDENCE = 0.95
_RESAMPLES = 2000
_SEED = 0


@dataclass(frozen=True)
class Estimate:
    """A figure, its interval and on how many cases it rests. None: there was nothing to measure."""

    value: float | None = None
    low: float | None = None
    high: float | None = None
    n: int = 0

    def to_dict(self) -> dict[str, float | int | None]:
        return {"value": rounded(self.value), "low": rounded(self.low), "high": rounded(self.high), "n": self.n}


def rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)


def rate(part: int, whole: int) -> Estimate:
    """A share of independent cases: Wilson's score interval."""
    if not whole:
        return Estimate()
    interval = stats.binomtest(part, whole).proportion_ci(CONFIDENCE, method="wilson")
    return Estimate(part / whole, float(interval.low), float(interval.high), whole)


def rate_difference(gained: int, lost: int, cases: int) -> Estimate:
    """Of two rates of the same cases, by how many changed: Agresti and Min's interval (2005), with half a case more in
    each of the four cells; where none changed it is not sure that none would."""
    if not cases:
        return Estimate()
    more, less, n = gained + 0.5, lost + 0.5, cases + 2
    middle = (more - less) / n
    reach = stats.norm.ppf((1 + CONFIDENCE) / 2) * np.sqrt(more + less - (more - less) ** 2 / n) / n
    return Estimate((gained - lost) / cases, float(max(middle - reach, -1)), float(min(middle + reach, 1)), cases)


def per_frame(events: int, frames: int) -> Estimate:
    """Events a frame: the exact interval of a Poisson count (Garwood 1936)."""
    if not frames:
        return Estimate()
    tail = (1 - CONFIDENCE) / 2
    low = stats.chi2.ppf(tail, 2 * events) / 2 if events else 0.0
    high = stats.chi2.ppf(1 - tail, 2 * events + 2) / 2
    return Estimate(events / frames, float(low) / frames, float(high) / frames, frames)


def f1(right: int, false: int, missed: int) -> Estimate:
    """Harmonic mean of precision and recall: 2 J / (1 + J) with J = right / (right + false + missed), whose interval
    carries over."""
    j = rate(right, right + false + missed)
    if j.value is None or j.low is None or j.high is None:
        return Estimate()
    value, low, high = (2 * v / (1 + v) for v in (j.value, j.low, j.high))
    return Estimate(value, low, high, j.n)


def median(values: ArrayLike) -> Estimate:
    """The median of a sample: percentile bootstrap."""
    return _bootstrapped(values, _median)


def quantile(values: ArrayLike, q: float) -> Estimate:
    return _bootstrapped(values, lambda x, axis: np.quantile(x, q, axis=axis))


def mean(values: ArrayLike) -> Estimate:
    return _bootstrapped(values, np.mean)


def _bootstrapped(values: ArrayLike, statistic: Callable[..., Any]) -> Estimate:
    """A statistic of a sample: percentile bootstrap. One value alone has no interval.

    :param statistic: of an array along `axis`.
    """
    sample = np.asarray(values, float)
    if not sample.size:
        return Estimate()
    value = float(statistic(sample, axis=0))
    if sample.size == 1:
        return Estimate(value, None, None, 1)
    batch = max(1, int(2e6) // sample.size)
    found = stats.bootstrap(
        (sample,), statistic, n_resamples=_RESAMPLES, batch=batch, vectorized=True, confidence_level=CONFIDENCE,
        method="percentile", random_state=np.random.default_rng(_SEED),
    ).confidence_interval  # fmt: skip
    return Estimate(value, float(found.low), float(found.high), int(sample.size))


def bootstrapped_rows(rows: Array, statistic: Callable[[Array], float]) -> Estimate:
    """A statistic of rows that belong together (n, k), by the same bootstrap."""
    if not len(rows):
        return Estimate()
    value = statistic(rows)
    if len(rows) == 1:
        return Estimate(value, None, None, 1)
    random = np.random.default_rng(_SEED)
    draws = [statistic(rows[random.integers(0, len(rows), len(rows))]) for _ in range(_RESAMPLES)]
    low, high = np.quantile(draws, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2])
    return Estimate(value, float(low), float(high), len(rows))


def exact_sign_test(gained: int, lost: int) -> float:
    """P-value of McNemar's exact test: as many cases changed one way as the other."""
    return float(stats.binomtest(gained, gained + lost).pvalue) if gained + lost else 1.0


def _median(values: Array, axis: int = 0) -> Any:
    return np.median(values, axis=axis)
