"""Learned constraints between components: boxes around the examples' configurations (paper, steps 6 and 7).

The configuration T_ij of two markers is (rho, alpha, beta): distance of the centroids over the scale k (so
in metres on the marker's plane), direction of i -> j seen from i's axis, angle from i's axis to j's; and the
ratio of the scales. Where examples have rho near zero, alpha means nothing: there the place of j is kept as
(dx, dy)/k in i's frame. k is the geometric mean of both scales. T_ji follows from T_ij: each pair is kept once.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import ConfigError
from .intervals import Interval, expected_coverage, margin_for_coverage
from .objects import Marker, ObjectModel
from .shapes import Shape
from .symmetry import ANY_ANGLE
from .transforms import Array, wrap_angle

Key = tuple[str, str]  # (component, marker)
Example = Mapping[Key, Any]  # values have x, y, theta, scale: `datatypes.Instance` or its like

ANGLES = ("bearing_rad", "turn_rad")
DIMENSIONS = ("distance_m", "offset_x_m", "offset_y_m", *ANGLES, "scale_ratio", "distance_px")
_AMBIGUOUS_PX = 0.3
_NEAR_ZERO = 0.15  # of a marker's size: closer centroids have no direction from one to the other


@dataclass(frozen=True)
class PairConstraint:
    """What was seen of one pair of markers, and what is allowed.

    :param allowed: dimension -> interval that is checked; a dimension without meaning for the pair is absent.
    :param seen: dimension -> the examples' own span (the paper's box, with `distance_px`).
    :param examples: how many examples showed the pair.
    """

    first: Key
    second: Key
    examples: int
    allowed: Mapping[str, Interval]
    seen: Mapping[str, Interval]

    @property
    def coverage_seen(self) -> float:
        """Share of new examples that the bare box can be expected to hold."""
        return expected_coverage(self.examples) ** len(self.allowed)


@dataclass(frozen=True)
class ConstraintSet:
    """All pairs' constraints of one object.

    :param coverage: the share of new examples for which each pair's box was widened.
    """

    object: str
    coverage: float
    pairs: tuple[PairConstraint, ...]

    def pair(self, first: Key, second: Key) -> PairConstraint | None:
        """The constraint that relates the two in this order, or None."""
        return next((p for p in self.pairs if p.first == first and p.second == second), None)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a file."""
        rows = []
        for p in self.pairs:
            row: dict[str, Any] = {"first": "/".join(p.first), "second": "/".join(p.second), "examples": p.examples}
            row["allowed"] = {d: _interval_to_list(d, i) for d, i in p.allowed.items()}
            row["seen"] = {d: _interval_to_list(d, i) for d, i in p.seen.items()}
            rows.append(row)
        return {"object": self.object, "coverage": self.coverage, "pairs": rows}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> ConstraintSet:
        """Inverse of `to_dict`. Raises `ConfigError` naming the pair and key."""
        try:
            name, coverage, rows = str(values["object"]), float(values["coverage"]), list(values["pairs"])
        except (KeyError, TypeError, ValueError) as error:
            raise ConfigError(f"constraints need object, coverage and pairs: {error!r}") from error
        pairs = tuple(_pair_from_dict(row, n) for n, row in enumerate(rows))
        seen: set[tuple[Key, Key]] = set()
        for p in pairs:
            if (p.first, p.second) in seen or (p.second, p.first) in seen or p.first[0] == p.second[0]:
                raise ConfigError(
                    f"pairs: {'/'.join(p.first)} - {'/'.join(p.second)}: given twice, or of one component"
                )
            seen.add((p.first, p.second))
        return cls(name, coverage, pairs)

    def check_model(self, model: ObjectModel) -> None:
        """Raise `ConfigError` where a pair names a component or marker that the model lacks."""
        known = {(c.name, m.name) for c in model.components for m in c.markers}
        for key in (k for p in self.pairs for k in (p.first, p.second)):
            if key not in known:
                raise ConfigError(
                    f"pairs: '{'/'.join(key)}' is no component/marker of object '{model.name}'; "
                    f"it has {', '.join('/'.join(k) for k in sorted(known))}"
                )


def _interval_to_list(dimension: str, interval: Interval) -> list[float]:
    ends = [round(interval.low, 6), round(interval.high, 6)]
    return [*ends, round(interval.period, 6)] if dimension in ANGLES and interval.period < 6.28 else ends


def _pair_from_dict(row: Any, number: int) -> PairConstraint:
    where = f"pairs[{number}]"
    try:
        first, second = (_key(str(row[k])) for k in ("first", "second"))
        where = f"pairs[{number}] ({row['first']} - {row['second']})"
        boxes = [{d: _interval(d, v, where) for d, v in row[k].items()} for k in ("allowed", "seen")]
        return PairConstraint(first, second, int(row["examples"]), *boxes)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ConfigError(
            f"{where}: needs first and second (component/marker), examples, allowed and seen: {error!r}"
        ) from error


def _key(text: str) -> Key:
    component, marker = text.split("/")
    return component, marker


def _interval(dimension: str, ends: Any, where: str) -> Interval:
    if dimension not in DIMENSIONS:
        raise ConfigError(f"{where}: '{dimension}' is none of {', '.join(DIMENSIONS)}")
    period = 2 * np.pi if dimension in ANGLES else 0.0
    if len(ends) == 3 and period:
        period = float(ends[2])
    elif len(ends) != 2:
        raise ConfigError(f"{where}: {dimension}: {list(ends)} must be [low, high]")
    low, high = float(ends[0]), float(ends[1])
    if not (np.isfinite(low) and np.isfinite(high) and low <= high):
        raise ConfigError(f"{where}: {dimension}: [{low}, {high}] must run from low to high (an angle may pass pi)")
    return Interval(low, high, period)


def configuration(first: Any, second: Any) -> dict[str, Array]:
    """T_ij in every dimension, for instances or for arrays of them that broadcast (paper, step 6)."""
    dx, dy = second.x - first.x, second.y - first.y
    k = np.sqrt(first.scale * second.scale)
    rho = np.hypot(dx, dy)
    bearing = wrap_angle(np.arctan2(dy, dx) - first.theta)
    return {
        "distance_m": rho / k,
        "offset_x_m": rho / k * np.cos(bearing),
        "offset_y_m": rho / k * np.sin(bearing),
        "bearing_rad": bearing,
        "turn_rad": wrap_angle(second.theta - first.theta),
        "scale_ratio": np.asarray(second.scale / first.scale),
        "distance_px": np.asarray(rho),
    }


def learn(
    model: ObjectModel, examples: Iterable[Example], coverage: float = 0.95, min_examples: int = 2
) -> ConstraintSet:
    """Constraints of every pair of markers that `min_examples` or more examples show together.

    :param examples: per annotated object, (component, marker) -> where it lies in the image.
    :param coverage: share of new examples that each pair's box shall hold; 0: the bare box.
    """
    rows = list(examples)
    keys = [(c.name, m.name) for c in model.components for m in c.markers]
    markers = {(c.name, m.name): m for c in model.components for m in c.markers}
    shapes = {key: Shape.from_marker(m) for key, m in markers.items()}
    pairs = []
    for n, first in enumerate(keys):
        for second in keys[n + 1 :]:
            both = [(e[first], e[second]) for e in rows if first in e and second in e]
            if first[0] == second[0] or len(both) < max(2, min_examples):
                continue
            pairs.append(_learn_pair(first, second, both, markers, shapes, coverage))
    return ConstraintSet(model.name, coverage, tuple(pairs))


def _learn_pair(
    first: Key,
    second: Key,
    both: list[tuple[Any, Any]],
    markers: Mapping[Key, Marker],
    shapes: Mapping[Key, Shape],
    coverage: float,
) -> PairConstraint:
    orders = [
        shapes[key].symmetry.order(float(np.median([pair[n].scale for pair in both])), _AMBIGUOUS_PX)
        for n, key in enumerate((first, second))
    ]
    if orders[0] == ANY_ANGLE and orders[1] != ANY_ANGLE:
        # The direction to the other is measured from the one that has a direction.
        first, second, orders = second, first, orders[::-1]
        both = [(b, a) for a, b in both]
    rows = [configuration(a, b) for a, b in both]
    values = {d: np.array([float(row[d]) for row in rows]) for d in DIMENSIONS}
    size = float(np.sqrt(min(markers[first].area, markers[second].area)))
    near = bool(values["distance_m"].min() < _NEAR_ZERO * size)
    periods = [2 * np.pi / n if n != ANY_ANGLE else 0.0 for n in orders]
    seen = {d: _span(d, values[d], periods) for d in _meaningful(near, orders)}
    margin = margin_for_coverage(len(both), coverage ** (1 / len(seen)))
    allowed = {d: i.widened(margin) for d, i in seen.items()}
    return PairConstraint(
        first, second, len(both), allowed, {**seen, "distance_px": Interval.around(values["distance_px"])}
    )


def _meaningful(near: bool, orders: list[int]) -> tuple[str, ...]:
    """Dimensions that say something about the pair, given the orders of both markers' symmetries."""
    directed = orders[0] != ANY_ANGLE
    place: tuple[str, ...] = ("distance_m", "bearing_rad")
    if not directed:
        place = ("distance_m",)
    elif near:
        place = ("offset_x_m", "offset_y_m")
    turn = ("turn_rad",) if directed and orders[1] != ANY_ANGLE else ()
    return (*place, *turn, "scale_ratio")


def _span(dimension: str, values: Array, periods: list[float]) -> Interval:
    """The smallest span. Angles are taken modulo a marker's symmetry where the examples' own directions
    do not tell its equal sides apart, so that their span over the full circle is longer than the period."""
    if dimension not in ANGLES:
        return Interval.around(values)
    full = Interval.around_angles(values)
    shortest = min(periods) if dimension == "turn_rad" else periods[0]
    if 0 < shortest < full.width:
        folded = Interval.around_angles(values, shortest)
        if folded.width < 0.8 * shortest:
            return folded
    return full
