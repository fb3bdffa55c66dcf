"""Do scores mean what they say? Of the detections with score 0.8, eight of ten should lie on an object.

Judged is that an object is there and at its place, which is what a score promises; not its components.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.geometry.transforms import Array
from . import intervals
from .intervals import Estimate

_BINS = 10


@dataclass(frozen=True)
class ScoreBin:
    """Detections with scores in [low, high).

    :param score: their mean. :param precision: the share that lies on an object.
    """

    low: float
    high: float
    score: float
    precision: Estimate


@dataclass(frozen=True)
class Calibration:
    """A reliability diagram, bins without detections left out.

    :param brier: mean squared difference of score and truth (Brier 1950).
    :param error: expected calibration error: mean distance of score and precision over the bins, by their counts
        (Naeini 2015).
    """

    bins: tuple[ScoreBin, ...]
    brier: Estimate
    error: Estimate


def calibrate(scores: Sequence[tuple[float, bool]]) -> Calibration:
    """:param scores: score (0 to 1) and whether the detection lies on an object."""
    rows = np.array(scores, float).reshape(-1, 2)
    rows[:, 0] = np.clip(rows[:, 0], 0, 1)
    places = _places(rows)
    bins = []
    for i in np.unique(places).tolist():
        part = rows[places == i]
        precision = intervals.rate(int(part[:, 1].sum()), len(part))
        bins.append(ScoreBin(i / _BINS, (i + 1) / _BINS, float(part[:, 0].mean()), precision))
    brier = intervals.mean((rows[:, 0] - rows[:, 1]) ** 2)
    return Calibration(tuple(bins), brier, intervals.bootstrapped_rows(rows, expected_error))


def expected_error(rows: Array) -> float:
    """:param rows: (n, 2) score and 0 or 1."""
    places = _places(rows)
    off = np.bincount(places, rows[:, 0] - rows[:, 1], _BINS)  # sum over each bin of score - truth
    return float(np.abs(off).sum() / len(rows))


def _places(rows: Array) -> np.ndarray:
    return np.minimum((rows[:, 0] * _BINS).astype(int), _BINS - 1)
