"""Training: constraints of pairs of markers from examples (paper, step 7)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from ..alignment.shapes import Shape
from ..alignment.symmetry import ANY_ANGLE
from ..base.config import AlignmentConfig, LearningConfig
from ..constraints.constraint_set import ConstraintSet
from ..constraints.intervals import Interval
from ..constraints.pairs import ANGLES, DIMENSIONS, Key, PairConstraint, configuration
from ..geometry.transforms import Array
from ..model.marker import Marker
from ..model.objects import ObjectModel
from .conformal import conformal_margin, left_out_scores, unwrapped, widened

Example = Mapping[Key, Any]  # values have x, y, theta, scale: `Instance` or its like

_LEARNING, _SYMMETRY_PX = LearningConfig(), AlignmentConfig().symmetry_px


def learn(
    model: ObjectModel, examples: Iterable[Example], coverage: float = 0.95, min_examples: int = 2
) -> ConstraintSet:
    """Constraints of every pair of markers that `min_examples` or more examples show together.

    :param examples: per annotated object, (component, marker) -> where it lies in the image.
    :param coverage: share of new examples that each pair's box shall hold; 0: the bare box (`conformal.py`).
    """
    rows = list(examples)
    shapes = {key: Shape.from_marker(m) for key, m in model.markers.items()}
    pairs = []
    for first, second in combinations(model.markers, 2):
        both = [(e[first], e[second]) for e in rows if first in e and second in e]
        if first[0] != second[0] and len(both) >= max(2, min_examples):
            pairs.append(_learn_pair(first, second, both, model.markers, shapes, coverage))
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
        shapes[key].symmetry.order(float(np.median([pair[n].scale for pair in both])), _SYMMETRY_PX)
        for n, key in enumerate((first, second))
    ]
    if orders[0] == ANY_ANGLE and orders[1] != ANY_ANGLE:
        # The direction to the other is measured from the one that has a direction.
        first, second, orders = second, first, orders[::-1]
        both = [(b, a) for a, b in both]
    rows = [configuration(a, b) for a, b in both]
    values = {d: np.array([float(row[d]) for row in rows]) for d in DIMENSIONS}
    size = float(np.sqrt(min(markers[first].area, markers[second].area)))
    near = bool(values["distance_m"].min() < _LEARNING.near_zero * size)
    seen = {d: _span(d, values[d], orders) for d in _meaningful(near, orders)}
    distance_px = Interval.around(values["distance_px"])
    bare = PairConstraint(first, second, len(both), seen, {**seen, "distance_px": distance_px})
    offsets = np.column_stack([unwrapped(values[d], i) for d, i in seen.items()])
    scores = left_out_scores(offsets, np.array(least_widths(bare)))
    return widened_pair(bare, conformal_margin(scores, coverage, len(seen)))


def least_widths(pair: PairConstraint) -> list[float]:
    """Per dimension that is checked, the width below which a box is not resolved by any image."""
    return [pair.least_width(d) for d in pair.allowed]


def widened_pair(pair: PairConstraint, margin: float) -> PairConstraint:
    """The pair's box of the examples, longer by `margin` widths on each side."""
    least = dict(zip(pair.allowed, least_widths(pair), strict=True))
    return replace(pair, allowed={d: widened(pair.seen[d], margin, least[d]) for d in pair.allowed})


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


def _span(dimension: str, values: Array, orders: list[int]) -> Interval:
    """The smallest span. Angles are taken modulo the markers' symmetry where the examples' own directions do not tell
    equal sides apart, so that their span over the full circle is longer than one marker's period: modulo all turns that
    look alike, or where these are too fine for what is left, modulo one marker's."""
    if dimension not in ANGLES:
        return Interval.around(values)
    full, mine = Interval.around_angles(values), orders if dimension == "turn_rad" else orders[:1]
    for order in sorted({math.lcm(*mine), *mine} - {1}, reverse=True):
        folded = Interval.around_angles(values, 2 * np.pi / order)
        if full.width > 2 * np.pi / min(order, max(mine)) and folded.width < _LEARNING.folded * folded.period:
            return folded
    return full
