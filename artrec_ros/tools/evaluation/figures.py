"""Counts as figures to quote, each with its interval; ratios of components and objects as in `metrics`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import intervals
from .intervals import Estimate
from .metrics import Counts
from .scoring import Evaluation

Figures = dict[str, Estimate]


@dataclass(frozen=True)
class Shown:
    """How a figure is called and written. :param better: 1: more is better, -1: less is.
    :param short: its title over narrow columns."""

    title: str
    unit: str = ""
    digits: int = 3
    better: int = 1
    meaning: str = ""
    short: str = ""


# key in metrics.json -> how it is shown, in the order of tables
SHOWN = {
    "recognition_rate": Shown(
        "recognition rate", meaning="objects in view that were found (recall)", short="recognised"
    ),
    "precision": Shown("precision", meaning="detections that lie on an object", short="precision"),
    "f1": Shown("F1", meaning="harmonic mean of recognition rate and precision"),
    "right_rate": Shown(
        "right configurations",
        meaning="objects found with every component on its own marker, none missed",
        short="right",
    ),
    "false_per_frame": Shown("false per frame", better=-1, meaning="detections that lie on no object"),
    "name_rate": Shown("names right", meaning="objects found that are told by their own name", short="names"),
    "wrong_name_rate": Shown("names wrong", "", 3, -1, "objects found that are told by another's name"),
    "component_precision": Shown(
        "component precision, of objects found",
        meaning="found components that lie on their own marker; those of false detections are not judged",
    ),
    "component_recall": Shown(
        "component recall, of objects found", meaning="well visible components that were found, of objects found"
    ),
    "position_error_median": Shown(
        "position error", "% of range", 2, -1, "median, relative to the distance", short="position %"
    ),
    "position_error_m_median": Shown("position error", "mm", 1, -1, "median"),
    "rotation_error_deg_median": Shown(
        "rotation error", "deg", 2, -1, "median, from the nearest turn in which it looks the same", short="rotation deg"
    ),
    "joint_error_deg_median": Shown("joint error", "deg", 2, -1, "median, revolute joints", short="joint deg"),
    "joint_error_m_median": Shown("joint error", "mm", 1, -1, "median, prismatic joints"),
    "position_error_p95": Shown("position error, 95 %", "% of range", 2, -1, "19 of 20 objects found are less off"),
    "rotation_error_deg_p95": Shown("rotation error, 95 %", "deg", 2, -1, "the same"),
    "joint_error_deg_p95": Shown("joint error, 95 %", "deg", 2, -1, "19 of 20 revolute joints told are less off"),
    "joint_error_m_p95": Shown("joint error, 95 %", "mm", 1, -1, "the same, prismatic joints"),
    "image_error_px_median": Shown("place in the image", "px", 1, -1, "median, of markers that were annotated"),
    "direction_error_deg_median": Shown(
        "direction", "deg", 2, -1, "median, of the axes of markers that were annotated"
    ),
    "direction_error_deg_p95": Shown(
        "direction, 95 %", "deg", 2, -1, "19 of 20 axes are less off: what is turned round shows here"
    ),
    "latency_ms_median": Shown("latency, median", "ms", 1, -1, "time a frame took"),
    "latency_ms_p95": Shown("latency, 95 %", "ms", 1, -1, "95 of 100 frames took less"),
    "brier_score": Shown(
        "Brier score (place)", "", 3, -1, "mean squared difference of score and whether it lies on an object (1 or 0)"
    ),
    "calibration_error": Shown(
        "calibration error (place)",
        "",
        3,
        -1,
        "mean distance of score and the share that lies on an object, over bins; right components are not asked for",
    ),
}
FACTORS = {
    **dict.fromkeys(("position_error_median", "position_error_p95"), 100.0),
    **dict.fromkeys(("position_error_m_median", "joint_error_m_median", "joint_error_m_p95"), 1000.0),
}
OF_PARTS = ("recognition_rate", "precision", "right_rate", "position_error_median", "rotation_error_deg_median",
            "joint_error_deg_median")  # fmt: skip
"""What is told of parts: ranges and view angles."""


def figures_of(counts: Counts) -> Figures:
    """What can be told of any part of the objects. Values equal `Counts`' own ratios."""
    c = counts
    recall = intervals.rate(c.recognised, c.objects)
    return {
        "recognition_rate": recall,
        "recall": recall,  # the same by its other name
        "precision": intervals.rate(c.recognised, c.recognised + c.false),
        "f1": intervals.f1(c.recognised, c.false, c.objects - c.recognised),
        "right_rate": intervals.rate(c.right, c.judged),
        "false_per_frame": intervals.per_frame(c.false, c.frames),
        "name_rate": intervals.rate(c.names_right, c.named),
        "wrong_name_rate": intervals.rate(c.names_wrong, c.named),
        "component_precision": intervals.rate(c.components_right, c.components_right + c.components_wrong),
        "component_recall": intervals.rate(c.components_right, c.components_right + c.components_missed),
        "position_error_median": intervals.median(c.position_errors),
        "position_error_m_median": intervals.median(c.position_errors_m),
        "rotation_error_deg_median": intervals.median(np.degrees(c.rotation_errors_rad)),
        "joint_error_deg_median": intervals.median(np.degrees(c.joint_errors_rad)),
        "joint_error_m_median": intervals.median(c.joint_errors_m),
        "position_error_p95": intervals.quantile(c.position_errors, 0.95),
        "rotation_error_deg_p95": intervals.quantile(np.degrees(c.rotation_errors_rad), 0.95),
        "joint_error_deg_p95": intervals.quantile(np.degrees(c.joint_errors_rad), 0.95),
        "joint_error_m_p95": intervals.quantile(c.joint_errors_m, 0.95),
        "image_error_px_median": intervals.median(c.image_errors_px),
        "direction_error_deg_median": intervals.median(np.degrees(c.direction_errors_rad)),
        "direction_error_deg_p95": intervals.quantile(np.degrees(c.direction_errors_rad), 0.95),
    }


def counted(counts: Counts) -> dict[str, int]:
    """The whole numbers behind the figures."""
    names = ("frames", "frames_without_result", "objects", "recognised", "judged", "right", "false", "named",
             "names_right", "names_wrong", "components_right",
             "components_wrong", "components_missed")  # fmt: skip
    return {name: getattr(counts, name) for name in names}


def latency(evaluation: Evaluation) -> Figures:
    """Of the frames that could be used, milliseconds: all of it, and the medians of the stages."""
    records = evaluation.used_records
    total = [r.timing_ms["total"] for r in records if "total" in r.timing_ms]
    stages = sorted({stage for r in records for stage in r.timing_ms} - {"total"})
    return {
        "latency_ms_median": intervals.median(total),
        "latency_ms_p95": intervals.quantile(total, 0.95),
        "latency_ms_max": Estimate(max(total), n=len(total)) if total else Estimate(),
        **{f"{s}_ms_median": intervals.median([r.timing_ms[s] for r in records if s in r.timing_ms]) for s in stages},
    }


def written(key: str, estimate: Estimate, interval: bool = True) -> str:
    """A figure as text: '0.940 (0.88 to 0.97)'; '-': nothing to measure."""
    if estimate.value is None:
        return "-"
    factor, digits = FACTORS.get(key, 1.0), SHOWN[key].digits
    text = f"{factor * estimate.value:.{digits}f}"
    if not interval or estimate.low is None or estimate.high is None:
        return text
    return f"{text} ({factor * estimate.low:.{digits}f} to {factor * estimate.high:.{digits}f})"


def title(key: str) -> str:
    """A figure's heading, with its unit."""
    shown = SHOWN[key]
    return f"{shown.title}, {shown.unit}" if shown.unit else shown.title


def to_dict(figures: Figures) -> dict[str, Any]:
    return {key: estimate.to_dict() for key, estimate in figures.items()}
