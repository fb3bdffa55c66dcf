"""What is wanted of parameters: one figure as good as can be, others within limits."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...core.base.errors import ConfigError
from ..evaluation.figures import SHOWN
from ..evaluation.scoring import Evaluation

_LIMIT = re.compile(r"\s*(\w+)\s*(<=|>=)\s*([-+.\deE]+)\s*")
_MISSED = -1e9  # what parameters are worth that miss a limit, before it is told by how much


def measures(evaluation: Evaluation) -> dict[str, float | None]:
    """The figures that a goal can name, as `artrec evaluate` has them; None: there was nothing to measure."""
    counts = evaluation.counts()
    wrong = counts.false + counts.objects - counts.recognised
    whole = 2 * counts.recognised + wrong
    times = [r.timing_ms["total"] for r in evaluation.used_records if "total" in r.timing_ms]
    return {
        **counts.rates(),
        "f1": round(2 * counts.recognised / whole, 4) if whole else None,
        "latency_ms_median": round(float(np.median(times)), 3) if times else None,
        "latency_ms_p95": round(float(np.quantile(times, 0.95)), 3) if times else None,
    }


FIGURES = (
    "f1", "recognition_rate", "precision", "right_rate", "false_per_frame", "component_precision", "component_recall",
    "position_error_median", "rotation_error_deg_median", "latency_ms_median", "latency_ms_p95",
)  # fmt: skip


@dataclass(frozen=True)
class Limit:
    """A figure's bound. :param most: it must be no more than `value`; else no less."""

    figure: str
    most: bool
    value: float

    def __str__(self) -> str:
        return f"{self.figure}{'<=' if self.most else '>='}{self.value:g}"

    def missed_by(self, measured: Mapping[str, float | None]) -> float:
        """As a share of the bound; 0: it is kept."""
        value = measured[self.figure]
        if value is None:
            return math.inf
        excess = value - self.value if self.most else self.value - value
        return max(0.0, excess) / max(abs(self.value), 1e-9)


@dataclass(frozen=True)
class Goal:
    """The figure to improve, and limits that go before it."""

    figure: str
    limits: tuple[Limit, ...] = ()

    def __str__(self) -> str:
        return " with ".join([self.figure, *([" and ".join(map(str, self.limits))] if self.limits else [])])

    def worth(self, measured: Mapping[str, float | None]) -> float:
        """The more the better. Whatever keeps the limits is worth more than what does not."""
        missed = sum(min(limit.missed_by(measured), 1e6) for limit in self.limits)
        value = measured[self.figure]
        if missed or value is None:
            return _MISSED * (1 + missed)
        return SHOWN[self.figure].better * value

    def keeps_limits(self, measured: Mapping[str, float | None]) -> bool:
        return all(limit.missed_by(measured) == 0 for limit in self.limits)


def limit(text: str) -> Limit:
    """A limit as users write it. :raises argparse.ArgumentTypeError: it is none."""
    match = _LIMIT.fullmatch(text)
    try:
        value = float(match[3]) if match else math.nan
    except ValueError:
        value = math.nan
    if match is None or not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}': FIGURE<=NUMBER or FIGURE>=NUMBER is expected: latency_ms_p95<=30")
    if match[1] not in FIGURES:
        raise argparse.ArgumentTypeError(f"'{match[1]}' is no figure ({', '.join(FIGURES)})")
    return Limit(match[1], match[2] == "<=", value)


def goal_of(figure: str, limits: Sequence[Limit]) -> Goal:
    """:raises ConfigError: speed alone is no goal."""
    if figure.startswith("latency") and not limits:
        raise ConfigError(f"--objective {figure}: needs a --limit, such as 'f1>=0.9': finding nothing is fastest")
    return Goal(figure, tuple(limits))
