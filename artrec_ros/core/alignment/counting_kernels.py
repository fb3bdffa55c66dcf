"""How many points of placed outlines lie near contours (paper, step 4).

Functions that are called for each of many hypotheses take numbers and single arrays: to hand over a tuple of arrays
costs more than the look-ups.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted


class Field(NamedTuple):
    """A `ContourMap`'s distances; `left`, `top`: its origin; `height`: rows of a slot."""

    distance: np.ndarray
    left: int
    top: int
    height: int
    steps_per_px: float


class Tolerance(NamedTuple):
    """How far a point may lie from a contour: a share of the root of the placed shape's area, within bounds."""

    share: float
    least_px: float
    most_px: float


class Limits(NamedTuple):
    """Values of `RecognizerConfig`. `max_scale` is infinite for any."""

    coarse_step: int
    coarse_match: float
    coarse_keep: int
    min_area_ratio: float
    max_area_ratio: float
    min_area: float
    min_scale: float
    max_scale: float
    tolerance: Tolerance
    symmetry_px: float
    same_start: float


@melted
def tolerance_steps(area: float, share: float, least_px: float, most_px: float, steps_per_px: float) -> int:
    """A `Tolerance` for a shape of so many px^2, in steps of the quantised distance."""
    return int(min(max(share * np.sqrt(area), least_px), most_px) * steps_per_px)


@melted
def count_near(
    distance: Any, width: int, top: int, height: int, tx: float, ty: float, zx: float, zy: float, px: Any, py: Any,
    limit: int,
) -> int:  # fmt: skip
    """How many points t + z p lie no farther than `limit` steps from a contour.

    :param distance: flat, of all slots; `width`: of a row; `top`: the slot's first row; `height`: its rows.
    """
    right, bottom, count = width - 1.0, height - 1.0, 0
    for i in range(len(px)):  # without a branch; the map's margin lies far from any contour
        x = np.rint(min(max(tx + zx * px[i] - zy * py[i], 0.0), right))
        y = np.rint(min(max(ty + zy * px[i] + zx * py[i], 0.0), bottom))
        count += distance[np.uint32((top + y) * width + x)] <= limit
    return count


@jit
def count_all(t: Any, z: Any, area: float, slot: int, px: Any, py: Any, field: Any, tolerance: Any) -> Any:
    """(n,) points (px, py) of a shape of so many m^2, placed by (t, z), that lie in the tolerance area."""
    distance, width, height = field.distance.ravel(), field.distance.shape[1], field.height
    left, above, steps, top = field.left, field.top, field.steps_per_px, slot * field.height
    share, least_px, most_px = tolerance.share, tolerance.least_px, tolerance.most_px
    count = np.empty(len(t), np.int64)
    for i in range(len(t)):
        zx, zy = z[i].real, z[i].imag
        limit = tolerance_steps(area * (zx * zx + zy * zy), share, least_px, most_px, steps)
        tx, ty = t[i].real - left, t[i].imag - above
        count[i] = count_near(distance, width, top, height, tx, ty, zx, zy, px, py, limit)
    return count


@jit
def by_count(count: Any, n: int, most: int) -> Any:
    """Indices of the first n counts, greatest first, equal ones in their order."""
    start = np.zeros(most + 2, np.int64)
    for i in range(n):
        start[most - count[i] + 1] += 1
    start = np.cumsum(start)
    order = np.empty(n, np.int64)
    for i in range(n):
        order[start[most - count[i]]] = i
        start[most - count[i]] += 1
    return order
