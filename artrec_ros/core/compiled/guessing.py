"""Alignments of a marker's views with a blob, scored one at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .geometry import View, pixel
from .jit import jit


class Template(NamedTuple):
    """One view of a marker, and the votes for its inside and the ring around it."""

    anchors: Any  # (a, 2)
    inside: Any  # (n, 2)
    contour: Any  # (m, 2)
    normal: Any  # (m, 2)
    area: float
    perimeter: float
    inside_votes: Any  # (256,)
    ring_votes: Any  # (256,)
    ring_px: float
    ring_width_px: float


@jit
def score_similarity(
    x0: float, y0: float, a: float, b: float, k: float, m: Template, view: View, wanted: float, most: float
) -> float:
    """`views.score_view` of the similarity p -> (x0, y0) + (a -b; b a) p; some value below `wanted` where it is below.

    :param most: the greatest vote of one inside point.
    """
    n, total, ring = len(m.inside), 0.0, 0.0
    share = m.area * k * k / n
    around = m.perimeter * k * m.ring_width_px
    most_ring = max(m.ring_votes.max(), 0.0) * around
    for i in range(n):
        x = x0 + a * m.inside[i, 0] - b * m.inside[i, 1]
        y = y0 + b * m.inside[i, 0] + a * m.inside[i, 1]
        total += m.inside_votes[view.padded[pixel(x, y, view.width, view.height)]]
        if (total + (n - 1 - i) * most) * share + most_ring < wanted:
            return -np.inf
    c, s = m.ring_px * a / k, m.ring_px * b / k
    for i in range(len(m.contour)):
        x = x0 + a * m.contour[i, 0] - b * m.contour[i, 1] + c * m.normal[i, 0] - s * m.normal[i, 1]
        y = y0 + b * m.contour[i, 0] + a * m.contour[i, 1] + s * m.normal[i, 0] + c * m.normal[i, 1]
        ring += m.ring_votes[view.padded[pixel(x, y, view.width, view.height)]]
    return total * share + ring / len(m.contour) * around


@jit
def insert(T: Any, score: Any, x0: float, y0: float, a: float, b: float, k: float, value: float) -> None:
    """Keep the best similarities, best first."""
    i = len(score) - 1
    while i > 0 and score[i - 1] < value:
        score[i] = score[i - 1]
        T[i] = T[i - 1]
        i -= 1
    score[i] = value
    T[i, 0], T[i, 1], T[i, 2], T[i, 3] = x0, y0, math.atan2(b, a), k


@jit
def best_alignments(
    p1: Any, p2: Any, moments: Any, m: Template, low: float, high: float, view: View, T: Any, score: Any
) -> None:
    """Fill T (K, 4) and score (K,) with the best similarities of all couples of anchors (p1, p2), and of `moments`
    (n, 4), whose scale lies between `low` and `high`; fewer than K leave scores of -inf."""
    score[:] = -np.inf
    last, most, n = len(score) - 1, m.inside_votes.max(), len(m.anchors)
    for j in range(len(p1)):
        px, py = p2[j, 0] - p1[j, 0], p2[j, 1] - p1[j, 1]
        for i in range(n):
            q1, q2 = m.anchors[i], m.anchors[(i + 1) % n]
            qx, qy = q2[0] - q1[0], q2[1] - q1[1]
            size = qx * qx + qy * qy
            if size == 0.0:
                continue
            a, b = (px * qx + py * qy) / size, (py * qx - px * qy) / size
            k = math.sqrt(a * a + b * b)
            if not (low < k < high):
                continue
            x0, y0 = p1[j, 0] - a * q1[0] + b * q1[1], p1[j, 1] - b * q1[0] - a * q1[1]
            value = score_similarity(x0, y0, a, b, k, m, view, score[last], most)
            if value > score[last]:
                insert(T, score, x0, y0, a, b, k, value)
    for i in range(len(moments)):
        x0, y0, k = moments[i, 0], moments[i, 1], moments[i, 3]
        if low < k < high:
            a, b = k * math.cos(moments[i, 2]), k * math.sin(moments[i, 2])
            value = score_similarity(x0, y0, a, b, k, m, view, score[last], most)
            if value > score[last]:
                insert(T, score, x0, y0, a, b, k, value)
