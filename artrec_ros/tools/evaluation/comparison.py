"""What changed from one run to another, on the same objects and frames: paired differences."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ...core.geometry.transforms import Array
from . import intervals
from .intervals import Estimate
from .outcomes import Outcome
from .scoring import Evaluation


@dataclass(frozen=True)
class Change:
    """A figure's difference, second run minus first, over the cases that both can tell.

    :param p: McNemar's exact test for rates, None for others.
    """

    difference: Estimate
    gained: int | None = None
    lost: int | None = None
    p: float | None = None


def compare(first: Evaluation, second: Evaluation) -> dict[str, Change]:
    """Changes by the figures' keys. Both have the same truth, so frames and objects come in the same order.

    Means differ by the mean of the differences; medians by the median of the differences.
    """
    pairs = [(a, b) for (_, a), (_, b) in zip(*_common_outcomes(first, second), strict=True) if a.counted and b.counted]
    judged = [(a, b) for a, b in pairs if a.right is not None and b.right is not None]
    slower = _latencies(second) - _latencies(first)
    return {
        "recognition_rate": _rates([(a.recognised, b.recognised) for a, b in pairs]),
        "right_rate": _rates([(a.right is True, b.right is True) for a, b in judged]),
        "false_per_frame": Change(intervals.mean(_false(second) - _false(first))),
        "position_error_median": _medians(pairs, lambda o: o.position_error),
        "position_error_m_median": _medians(pairs, lambda o: o.position_error_m),
        "rotation_error_deg_median": _medians(pairs, lambda o: _degrees(o.rotation_error_rad)),
        "latency_ms_median": Change(intervals.median(slower[np.isfinite(slower)])),
    }


def _common_outcomes(first: Evaluation, second: Evaluation) -> tuple[Iterable[tuple[str, Outcome]], ...]:
    common = [name for name, choice in first.choices.items() if second.choices.get(name) == choice]
    return first.outcomes(common), second.outcomes(common)


def _rates(pairs: list[tuple[bool, bool]]) -> Change:
    gained, lost = sum(b and not a for a, b in pairs), sum(a and not b for a, b in pairs)
    change = intervals.rate_difference(gained, lost, len(pairs))
    return Change(change, gained, lost, intervals.exact_sign_test(gained, lost))


def _medians(pairs: list[tuple[Outcome, Outcome]], measure: Callable[[Outcome], float | None]) -> Change:
    values = [(measure(a), measure(b)) for a, b in pairs]
    return Change(intervals.median([b - a for a, b in values if a is not None and b is not None]))


def _false(evaluation: Evaluation) -> Array:
    """(n,) false detections in each frame."""
    return np.array([sum(len(of_name.false) for of_name in f.by_name.values()) for f in evaluation.frames], float)


def _latencies(evaluation: Evaluation) -> Array:
    """(n,) milliseconds that each frame took; NaN: it was not timed."""
    times = [f.record.timing_ms.get("total", np.nan) if f.record else np.nan for f in evaluation.frames]
    return np.array(times, float)


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else float(np.degrees(angle))
