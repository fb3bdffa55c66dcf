"""Every pair of candidates checked by constraints, every pair of instances by the pixels they share."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted


class Boxes(NamedTuple):
    """A target's constraints packed: its markers have keys 0 .. K - 1, its constraints numbers 0 .. P - 1.

    :param pair: (K, K) the constraint that relates two markers, or -1. :param swapped: (K, K) whether it is told from
        the second one's side.
    :param low, high, period: (P, 6) intervals of distance, offsets x and y, bearing, turn and ratio of scales; a
        dimension that is not checked allows everything.
    :param reach: (P,) what lengths are measured by, in metres.
    """

    pair: np.ndarray
    swapped: np.ndarray
    low: np.ndarray
    high: np.ndarray
    period: np.ndarray
    reach: np.ndarray


class PoseArrays(NamedTuple):
    """`candidates.ImagePoses` with what else tells candidates apart. :param key: of the marker."""

    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray
    scale: np.ndarray
    place_noise: np.ndarray
    theta_noise: np.ndarray
    scale_noise: np.ndarray
    component: np.ndarray
    key: np.ndarray
    match: np.ndarray


@melted
def wrapped(angle: float, period: float) -> float:
    return angle - period * math.floor(angle / period + 0.5)


@melted
def _excess(low: float, high: float, period: float, value: float, noise: float) -> float:
    if period > 0:
        outside = abs(wrapped(value - (low + high) / 2, period)) - (high - low) / 2
    else:
        outside = max(low - value, value - high)
    return max(outside - 2 * noise, 0.0)


@melted
def _configuration(dx: float, dy: float, theta: Any, scale: Any, place: Any, theta_noise: Any, scale_noise: Any) -> Any:
    """Values and noises of the dimensions in the order of `Boxes`, of two candidates; pairs hold (first, second)."""
    k = math.sqrt(scale[0] * scale[1])
    rho = math.sqrt(dx * dx + dy * dy)
    place_px = math.sqrt(place[0] ** 2 + place[1] ** 2)
    both_scales = math.sqrt(scale_noise[0] ** 2 + scale_noise[1] ** 2)
    both_turns = math.sqrt(theta_noise[0] ** 2 + theta_noise[1] ** 2)
    distance, place_m, ratio = rho / k, place_px / k, scale[1] / scale[0]
    bearing = wrapped(math.atan2(dy, dx) - theta[0], 2 * math.pi)
    turn = wrapped(theta[1] - theta[0], 2 * math.pi)
    across = math.sqrt(place_m**2 + (distance * theta_noise[0]) ** 2)
    along = math.sqrt(place_m**2 + (distance * both_scales / 2) ** 2)
    sideways = math.sqrt(theta_noise[0] ** 2 + (place_px / max(rho, 1e-6)) ** 2)
    return (
        (distance, distance * math.cos(bearing), distance * math.sin(bearing), bearing, turn, ratio),
        (along, across, across, sideways, both_turns, ratio * both_scales),
    )


@jit
def check_pairs(
    c: Any, rows: Any, columns: Any, boxes: Any, overlap: Any, max_overlap: float, max_ratio: float, same: bool
) -> Any:
    """(forbidden, checked, violation) of candidates `rows` x `columns`; `same`: the two are one list.

    A violation is by how much the worst dimension of their configuration lies outside its constraint.
    """
    shape = (len(rows), len(columns))
    forbidden, checked, violation = np.zeros(shape, np.bool_), np.zeros(shape, np.bool_), np.zeros(shape)
    for a in range(len(rows)):
        for b in range(len(columns)):
            i, j = rows[a], columns[b]
            if same and b < a:  # the same two in the other order
                forbidden[a, b], checked[a, b], violation[a, b] = forbidden[b, a], checked[b, a], violation[b, a]
                continue
            if (
                c.component[i] == c.component[j]
                or c.scale[i] > max_ratio * c.scale[j]
                or c.scale[j] > max_ratio * c.scale[i]
                or overlap[c.match[i], c.match[j]] > max_overlap
            ):
                forbidden[a, b] = True
                continue
            p = boxes.pair[c.key[i], c.key[j]]
            if p < 0:
                continue
            checked[a, b] = True
            if boxes.swapped[c.key[i], c.key[j]]:
                i, j = j, i
            value, noise = _configuration(
                c.x[j] - c.x[i], c.y[j] - c.y[i], (c.theta[i], c.theta[j]), (c.scale[i], c.scale[j]),
                (c.place_noise[i], c.place_noise[j]), (c.theta_noise[i], c.theta_noise[j]),
                (c.scale_noise[i], c.scale_noise[j])
            )  # fmt: skip
            worst = 0.0
            for d in range(6):
                outside = _excess(boxes.low[p, d], boxes.high[p, d], boxes.period[p, d], value[d], noise[d])
                worst = max(worst, outside / boxes.reach[p] if d < 3 else outside)
            violation[a, b] = worst
    return forbidden, checked, violation
