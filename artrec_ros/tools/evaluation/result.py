"""All that is told of one run, worked out once for the terminal, metrics.json and the page."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..replaying.summary import versions
from . import figures as f
from .breakdown import ComponentCounts, component_counts, confusion
from .calibration import Calibration, calibrate
from .comparison import Change
from .failures import FailedFrame, failed_frames
from .figures import Figures
from .intervals import CONFIDENCE, rounded
from .scoring import Evaluation
from .strata import Stratum, stratify

FORMAT = "artrec_metrics/1"


@dataclass(frozen=True)
class Result:
    """:param overall: of all objects together. :param figures: by object name. :param latency: stages included."""

    evaluation: Evaluation
    overall: Figures
    figures: Mapping[str, Figures]
    latency: Figures
    strata: tuple[Stratum, ...]
    calibration: Calibration

    @property
    def name(self) -> str:
        return self.evaluation.run.name

    def to_dict(self) -> dict[str, Any]:
        """What metrics.json holds; rates as shares, lengths in metres, angles in degrees."""
        e = self.evaluation
        return {
            "format": FORMAT,
            "run": str(e.run.folder),
            "truth": e.truth.source,
            "confidence": CONFIDENCE,
            "notes": list(e.notes),
            "all": {"counts": f.counted(e.counts()), **f.to_dict(self.overall)},
            "objects": {n: {"counts": f.counted(e.counts(n)), **f.to_dict(own)} for n, own in self.figures.items()},
            "latency": f.to_dict(self.latency),
            "components": [_component_to_dict(c) for c in component_counts(e)],
            "confusion": {true: dict(found) for true, found in confusion(e).items()},
            "calibration": _calibration_to_dict(self.calibration),
            **{f"by_{s.key}": [_bin_to_dict(b) for b in s.bins] for s in self.strata},
            "failed_frames": [_failed_to_dict(frame) for frame in failed_frames(e)],
            "parameters": dict(e.run.parameters),
            "versions": {"replay": e.run.summary.get("versions"), "evaluate": versions()},
        }


def results_of(evaluations: Sequence[Evaluation]) -> list[Result]:
    """One for each evaluation; their ranges and view angles are the same."""
    return [_result(e, tuple(strata)) for e, strata in zip(evaluations, stratify(evaluations), strict=True)]


def changes_to_dict(changes: Mapping[str, Change]) -> dict[str, Any]:
    return {
        key: {"difference": c.difference.to_dict(), "gained": c.gained, "lost": c.lost, "p": rounded(c.p)}
        for key, c in changes.items()
    }


def _result(evaluation: Evaluation, strata: tuple[Stratum, ...]) -> Result:
    figures = {name: f.figures_of(evaluation.counts(name)) for name in evaluation.names}
    calibration, latency = calibrate(evaluation.scores), f.latency(evaluation)
    overall = {
        **f.figures_of(evaluation.counts()),
        **{key: latency[key] for key in ("latency_ms_median", "latency_ms_p95")},
        "brier_score": calibration.brier,
        "calibration_error": calibration.error,
    }
    return Result(evaluation, overall, figures, latency, strata, calibration)


def _failed_to_dict(failed: FailedFrame) -> dict[str, Any]:
    failures = [{"kind": x.kind, "object": x.name, "reason": x.reason} for x in failed.failures]
    return {"frame": failed.frame.key, "index": failed.frame.index, "failures": failures}


def _component_to_dict(c: ComponentCounts) -> dict[str, Any]:
    return {**dataclasses.asdict(c), "joint_error": c.joint_error.to_dict(), "precision": c.precision.to_dict()}


def _bin_to_dict(part: Any) -> dict[str, Any]:
    limits = {"name": part.name, "low": part.low, "high": None if part.high == float("inf") else part.high}
    return {**limits, "counts": f.counted(part.counts), **f.to_dict(part.figures)}


def _calibration_to_dict(c: Calibration) -> dict[str, Any]:
    bins = [
        {"low": b.low, "high": b.high, "score_mean": rounded(b.score), "precision": b.precision.to_dict()}
        for b in c.bins
    ]
    return {"brier_score": c.brier.to_dict(), "calibration_error": c.error.to_dict(), "bins": bins}
