"""A target's constraints made ready to check many pairs of candidates at once."""

from __future__ import annotations

import numpy as np

from ..model.target import Target
from .constraint_set import ConstraintSet
from .pair_kernels import Boxes
from .pairs import PairConstraint

# what a box is checked in, in the order of the packed arrays
CHECKED = ("distance_m", "offset_x_m", "offset_y_m", "bearing_rad", "turn_rad", "scale_ratio")


def reach_m(p: PairConstraint) -> float:
    """The greatest length that a box speaks of: excesses of lengths are told as shares of it."""
    lengths = [i for d, i in p.allowed.items() if d.endswith("_m")]
    return max([abs(end) for i in lengths for end in (i.low, i.high)] + [1e-9])


def pack_boxes(target: Target) -> Boxes:
    """All constraints of a target."""
    keys = list(target.model.markers)
    pairs = target.constraints.pairs if isinstance(target.constraints, ConstraintSet) else ()
    pair, swapped = np.full((len(keys), len(keys)), -1, np.int32), np.zeros((len(keys), len(keys)), bool)
    low, high = np.full((len(pairs), len(CHECKED)), -np.inf), np.full((len(pairs), len(CHECKED)), np.inf)
    period = np.zeros(low.shape)
    for n, p in enumerate(pairs):
        first, second = keys.index(p.first), keys.index(p.second)
        pair[first, second] = pair[second, first] = n
        swapped[second, first] = True
        for d, dimension in enumerate(CHECKED):
            if dimension in p.allowed:
                box = p.allowed[dimension]
                low[n, d], high[n, d], period[n, d] = box.low, box.high, box.period
    return Boxes(pair, swapped, low, high, period, np.array([reach_m(p) for p in pairs]))
