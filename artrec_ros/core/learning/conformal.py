"""Boxes with a stated coverage, whatever the examples' distribution: margins from examples left out one at a time.

An example that is left out is, to the box of the others, what a new example is to the box of all. The margin with which
a share c of (n + 1) left-out examples come to lie inside covers a new one with probability c, to first order in 1/n
(V. Vovk, A. Gammerman, G. Shafer, Algorithmic Learning in a Random World, 2005; R. Barber et al., Predictive
inference with the jackknife+, Annals of Statistics 49(1), 2021). All dimensions of an example count together: how
they depend on each other does not matter.
"""

from __future__ import annotations

import math

import numpy as np

from ..base.config import LearningConfig
from ..constraints.intervals import Interval, margin_for_coverage
from ..geometry.transforms import Array, wrap_angle

_GREATEST = LearningConfig().greatest_margin


def left_out_scores(values: Array, least_width: Array) -> Array:
    """By how many widths each example lies outside the box of the others, in its worst dimension; 0 inside.

    :param values: (n, d), not a number where an example lacks a dimension. Angles must not wrap around.
    :param least_width: (d,) widths below which a box is not resolved.
    """
    low, high = _others(values), -_others(-values)
    width = np.maximum(high - low, least_width)
    outside = np.maximum(np.maximum(low - values, values - high), 0.0) / width
    known = np.isfinite(outside)  # a dimension that only one example shows has no box without it
    return np.where(known, outside, 0.0).max(axis=1, initial=0.0)


def _others(values: Array) -> Array:
    """(n, d) the least value of all other examples, infinite where there is none."""
    filled = np.where(np.isnan(values), np.inf, values)
    if len(filled) < 2:
        return np.full(values.shape, np.inf)
    ordered = np.sort(filled, axis=0)
    is_least = np.arange(len(values))[:, None] == filled.argmin(axis=0)
    return np.where(is_least, ordered[1], ordered[0])


def conformal_margin(scores: Array, coverage: float, dimensions: int) -> float:
    """The margin, in widths, with which the box of all examples is expected to hold a share `coverage` of new ones.

    With examples too few to tell, the greatest score or the margin for evenly spread values, whichever is more.
    """
    n = len(scores)
    rank = math.ceil((n + 1) * coverage - 1e-9)
    if 1 <= rank <= n:
        return float(min(np.sort(scores)[rank - 1], _GREATEST))
    if rank < 1:
        return 0.0
    even = margin_for_coverage(n, coverage ** (1 / max(dimensions, 1)), _GREATEST)
    return float(min(max(even, scores.max(initial=0.0)), _GREATEST))


def examples_wanted(coverage: float) -> int:
    """The fewest examples of which left-out ones can tell a coverage: n with (n + 1) coverage <= n."""
    return math.ceil(coverage / max(1 - coverage, 1e-9) - 1e-9)


def unwrapped(values: Array, interval: Interval) -> Array:
    """Values as offsets from the interval's middle: angles then do not wrap around within it."""
    offset = values - (interval.low + interval.high) / 2
    return wrap_angle(offset, interval.period) if interval.period else offset


def widened(interval: Interval, margin: float, least_width: float) -> Interval:
    """Longer by `margin` widths on each side, at most one full turn."""
    extra = margin * max(interval.width, least_width)
    if interval.period:
        extra = min(extra, max(0.0, (interval.period - interval.width) / 2))
    return Interval(interval.low - extra, interval.high + extra, interval.period)
