"""What changed from one run to another, on the same objects and frames: paired differences."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from . import intervals
from .intervals import Estimate
from .outcomes import Outcome
from .scoring import Evaluation, ScoredFrame


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
    return {
        "recognition_rate": _rates([(a.recognised, b.recognised) for a, b in pairs]),
        "right_rate": _rates([(a.right is True, b.right is True) for a, b in judged]),
        "false_per_frame": _means(_false(first, second)),
        "position_error_median": _medians(pairs, lambda o: o.position_error),
        "position_error_m_median": _medians(pairs, lambda o: o.position_error_m),
        "rotation_error_deg_median": _medians(pairs, lambda o: _degrees(o.rotation_error_rad)),
        "latency_ms_median": Change(intervals.median(list(_latencies(first, second)))),
    }


def _common_outcomes(first: Evaluation, second: Evaluation) -> tuple[Iterable[tuple[str, Outcome]], ...]:
    common = [name for name, choice in first.choices.items() if second.choices.get(name) == choice]
    return first.outcomes(common), second.outcomes(common)


def _rates(pairs: list[tuple[bool, bool]]) -> Change:
    gained, lost = sum(b and not a for a, b in pairs), sum(a and not b for a, b in pairs)
    change = intervals.rate_difference(gained, lost, len(pairs))
    return Change(change, gained, lost, intervals.exact_sign_test(gained, lost))


def _means(pairs: list[tuple[int, int]]) -> Change:
    return Change(intervals.mean([b - a for a, b in pairs]))


def _medians(pairs: list[tuple[Outcome, Outcome]], measure: Callable[[Outcome], float | None]) -> Change:
    values = [(measure(a), measure(b)) for a, b in pairs]
    return Change(intervals.median([b - a for a, b in values if a is not None and b is not None]))


def _false(first: Evaluation, second: Evaluation) -> list[tuple[int, int]]:
    return [(_count_false(a), _count_false(b)) for a, b in zip(first.frames, second.frames, strict=True)]


def _count_false(frame: ScoredFrame) -> int:
    return sum(len(outcome.false) for outcome in frame.by_name.values())


def _latencies(first: Evaluation, second: Evaluation) -> Iterable[float]:
    for a, b in zip(first.frames, second.frames, strict=True):
        if (
            a.record is not None
            and b.record is not None
            and "total" in a.record.timing_ms
            and "total" in b.record.timing_ms
        ):
            yield b.record.timing_ms["total"] - a.record.timing_ms["total"]


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else float(np.degrees(angle))
