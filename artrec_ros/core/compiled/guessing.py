"""Alignments of a marker's views with a blob, scored one at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .geometry import View, pixel
from .jit import inlined, jit


class Bank(NamedTuple):
    """V views of a marker."""

    anchors: Any  # (V, a, 2)
    n_anchors: Any  # (V,) so many of them count
    inside: Any  # (V, n, 2)
    contour: Any  # (V, m, 2)
    normal: Any  # (V, m, 2)
    area: Any  # (V,)
    perimeter: Any  # (V,)
    scale: Any  # (V, 2) least and greatest


class Look(NamedTuple):
    """Votes for what lies inside a marker, and in the ring around it."""

    inside: Any  # (256,)
    ring: Any  # (256,)
    most_inside: float  # the greatest of each
    most_ring: float
    ring_px: float
    ring_width_px: float


@jit
def score_similarity(
    x0: float, y0: float, a: float, b: float, m: Bank, v: int, look: Look, view: View, wanted: float
) -> float:
    """`views.score_view` of the similarity p -> (x0, y0) + (a -b; b a) p; -inf where it is below `wanted`."""
    k = math.sqrt(a * a + b * b)
    inside, contour, normal = m.inside[v], m.contour[v], m.normal[v]
    n, total, ring, most = len(inside), 0.0, 0.0, look.most_inside
    share = m.area[v] * k * k / n
    around = m.perimeter[v] * k * look.ring_width_px
    most_ring = max(look.most_ring, 0.0) * around
    for i in range(n):
        x = x0 + a * inside[i, 0] - b * inside[i, 1]
        y = y0 + b * inside[i, 0] + a * inside[i, 1]
        total += look.inside[view.padded[pixel(x, y, view.width, view.height)]]
        if (total + (n - 1 - i) * most) * share + most_ring < wanted:
            return -np.inf
    c, s = look.ring_px * a / k, look.ring_px * b / k
    for i in range(len(contour)):
        x = x0 + a * contour[i, 0] - b * contour[i, 1] + c * normal[i, 0] - s * normal[i, 1]
        y = y0 + b * contour[i, 0] + a * contour[i, 1] + s * normal[i, 0] + c * normal[i, 1]
        ring += look.ring[view.padded[pixel(x, y, view.width, view.height)]]
    return total * share + ring / len(contour) * around


@jit
def insert(T: Any, score: Any, x0: float, y0: float, a: float, b: float, value: float) -> None:
    """Keep the best similarities, best first."""
    i = len(score) - 1
    while i > 0 and score[i - 1] < value:
        score[i] = score[i - 1]
        T[i] = T[i - 1]
        i -= 1
    score[i] = value
    T[i, 0], T[i, 1], T[i, 2], T[i, 3] = x0, y0, math.atan2(b, a), math.sqrt(a * a + b * b)


@inlined
def offer(
    x0: float, y0: float, a: float, b: float, m: Bank, v: int, look: Look, view: View, least: float, T: Any, score: Any
) -> float:
    """Keep a similarity of view `v` if it is among its best and reaches `least`; its score, -inf where it cannot be."""
    value = score_similarity(x0, y0, a, b, m, v, look, view, max(score[-1], least))
    if value > score[-1]:
        insert(T, score, x0, y0, a, b, value)
    return value


@jit
def best_alignments(
    p1: Any, p2: Any, moments: Any, m: Bank, look: Look, least_share: float, view: View, T: Any, score: Any
) -> None:
    """Fill T (V, K, 4) and score (V, K) with each view's best similarities: of `moments` (V, n, 4) and of all couples
    of anchors (p1, p2); fewer than K that have `least_share` of the best one's score leave scores of -inf."""
    score[:] = -np.inf
    best = 0.0
    for v in range(len(m.area)):
        for x0, y0, theta, k in moments[v]:
            if m.scale[v, 0] < k < m.scale[v, 1]:
                a, b = k * math.cos(theta), k * math.sin(theta)
                best = max(best, offer(x0, y0, a, b, m, v, look, view, least_share * best, T[v], score[v]))
    for v in range(len(m.area)):
        low, high, n = m.scale[v, 0], m.scale[v, 1], m.n_anchors[v]
        for j in range(len(p1)):
            px, py = p2[j, 0] - p1[j, 0], p2[j, 1] - p1[j, 1]
            for i in range(n):
                q1, q2 = m.anchors[v, i], m.anchors[v, (i + 1) % n]
                qx, qy = q2[0] - q1[0], q2[1] - q1[1]
                size = qx * qx + qy * qy
                if size == 0.0:
                    continue
                a, b = (px * qx + py * qy) / size, (py * qx - px * qy) / size
                if not (low * low < a * a + b * b < high * high):
                    continue
                x0, y0 = p1[j, 0] - a * q1[0] + b * q1[1], p1[j, 1] - b * q1[0] - a * q1[1]
                best = max(best, offer(x0, y0, a, b, m, v, look, view, least_share * best, T[v], score[v]))
    for v in range(len(m.area)):
        for i in range(score.shape[1]):
            if score[v, i] < least_share * best:
                score[v, i] = -np.inf
