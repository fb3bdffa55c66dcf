"""Parts of the objects that were seen under like conditions: by range, view angle and apparent size.

A false detection belongs where its own pose puts it, so that precision can be told by range and view angle too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...core.geometry.transforms import Pose
from ...core.model.found import Detection
from ...core.model.objects import ObjectModel
from ...io.truth.records import TrueObject
from .completion import slant_rad
from .figures import Figures, figures_of
from .intervals import Estimate
from .metrics import Counts, shows
from .scoring import Evaluation

_MOST_RANGES = 6
_AZIMUTHS_DEG = tuple(range(-180, 180, 45))  # centres of the sectors; 0: seen from its +x
_ELEVATIONS_DEG = (-90, -60, -30, 0, 30, 60, 90)
_SLANTS_DEG = (0, 15, 30, 45, 60, 75, 90, 180)
_SIZES_PX = (0, 8, 12, 16, 24, 32, 48, 64, 96, np.inf)

Measure = Callable[[TrueObject | Detection, str], float | None]
Edges = list[tuple[str, float, float]]


@dataclass(frozen=True)
class Bin:
    """A part: what it is called, and what was found in it. :param low, high: its limits, high excluded.
    :param tells_false: whether it is known to which part each false detection belongs; else precision is not told."""

    name: str
    low: float
    high: float
    counts: Counts
    tells_false: bool = True

    @cached_property
    def figures(self) -> Figures:
        """Of what is in it; precision and f1 are not known where `tells_false` is not so."""
        figures = figures_of(self.counts)
        return figures if self.tells_false else figures | {key: Estimate() for key in ("precision", "f1")}

    @property
    def false(self) -> str:
        """How many false detections, as text."""
        return str(self.counts.false) if self.tells_false else "-"


@dataclass(frozen=True)
class Stratum:
    """A condition and its parts, those without any object or false detection left out."""

    key: str
    title: str
    bins: tuple[Bin, ...]


def stratify(evaluations: Sequence[Evaluation]) -> list[list[Stratum]]:
    """For each evaluation the same conditions in the same parts; conditions that nothing tells are left out."""
    strata: list[list[Stratum]] = [[] for _ in evaluations]
    for key, heading, measure_of, edges in _conditions(evaluations):
        rows = [_parts(e, measure_of(e), edges) for e in evaluations]
        kept = [i for i in range(len(edges)) if any(row[i].counts.objects + row[i].counts.false for row in rows)]
        if kept:
            for stratum, row in zip(strata, rows, strict=True):
                stratum.append(Stratum(key, heading, tuple(row[i] for i in kept)))
    return strata


def _parts(evaluation: Evaluation, measure: Measure, edges: Edges) -> list[Bin]:
    outcomes = [(measure(o.truth, name), name, o) for name, o in evaluation.outcomes()]
    false = [measure(d, d.object) for d in evaluation.false()]
    parts = []
    for title, low, high in edges:
        inside = [(name, o) for v, name, o in outcomes if v is not None and low <= v < high]
        count = sum(v is not None and low <= v < high for v in false)
        parts.append(Bin(title, low, high, evaluation.counts_of(inside, count), None not in false))
    return parts


def _conditions(evaluations: Sequence[Evaluation]) -> list[tuple[str, str, Callable[[Evaluation], Measure], Edges]]:
    ranges = [r for _, o in evaluations[0].outcomes() if o.counted and (r := _range_m(o.truth)) is not None]
    azimuths = [(f"{c}" if c > -180 else "180", c - 22.5, c + 22.5) for c in _AZIMUTHS_DEG]
    return [
        ("range", "range, m", lambda e: lambda v, n: _range_m(v), range_edges(ranges)),
        ("azimuth", "azimuth from which it is seen, deg (0: its +x, 90: its +y)",
         lambda e: lambda v, n: _azimuth_deg(v), azimuths),
        ("elevation", "elevation from which it is seen, deg (90: its +z)",
         lambda e: lambda v, n: _elevation_deg(v), _named(_ELEVATIONS_DEG)),
        ("slant", "slant of the required component's best marker, deg", _slant, _named(_SLANTS_DEG)),
        ("size", "size: square root of the visible pixels of the required component", _size, _named(_SIZES_PX)),
    ]  # fmt: skip


def range_edges(ranges_m: Sequence[float]) -> Edges:
    """Up to six parts between round numbers."""
    if not ranges_m:
        return []
    low, high = min(ranges_m), max(ranges_m)
    exponent = np.floor(np.log10(max(high - low, 1e-3 * high) / _MOST_RANGES))
    for step in (f * 10**exponent for f in (1, 2, 2.5, 5, 10, 20)):
        first, last = int(np.floor(low / step)), int(np.floor(high / step)) + 1
        if last - first <= _MOST_RANGES:
            break
    return _named([float(f"{i * step:.6g}") for i in range(first, last + 1)])


def _named(edges: Sequence[float]) -> Edges:
    return [
        (f"{a:g} to {b:g}" if np.isfinite(b) else f"{a:g} and more", float(a), float(b))
        for a, b in zip(edges[:-1], edges[1:], strict=True)
    ]


def _in_camera(v: TrueObject | Detection) -> Pose | None:
    """Its pose as the camera sees it; None where nothing, or its place on a plane, is told."""
    return None if isinstance(v, Detection) and v.pose_from == "plane" else v.pose


def _range_m(v: TrueObject | Detection) -> float | None:
    pose = _in_camera(v)
    return None if pose is None else float(np.linalg.norm(pose.position))


def _towards_camera(T_camera_object: Pose) -> np.ndarray:
    """(3,) unit vector in the object's frame."""
    direction = T_camera_object.inverse().position
    return direction / np.linalg.norm(direction)


def _azimuth_deg(v: TrueObject | Detection) -> float | None:
    """About the object's z, in the sectors' range [-202.5, 157.5)."""
    pose = _in_camera(v)
    if pose is None:
        return None
    x, y, _ = _towards_camera(pose)
    return float((np.degrees(np.arctan2(y, x)) + 202.5) % 360 - 202.5)


def _elevation_deg(v: TrueObject | Detection) -> float | None:
    pose = _in_camera(v)
    return None if pose is None else float(np.degrees(np.arcsin(np.clip(_towards_camera(pose)[2], -1, 0.999999))))


def _slant(evaluation: Evaluation) -> Measure:
    models: dict[str, ObjectModel] = dict(evaluation.run.models)

    def measure(v: TrueObject | Detection, name: str) -> float | None:
        pose = _in_camera(v)
        if pose is None or name not in models:
            return None
        angle = slant_rad(pose, models[name].required)
        return None if angle is None else float(np.degrees(angle))

    return measure


def _size(evaluation: Evaluation) -> Measure:
    """Of true objects alone: what a false detection's marker covers is not known."""
    objects = evaluation.run.objects

    def measure(v: TrueObject | Detection, name: str) -> float | None:
        if isinstance(v, Detection):
            return None
        seen = [c.visible_px for part, c in v.components.items() if shows(part, objects[name].required)]
        return max(seen, default=0.0) ** 0.5

    return measure
