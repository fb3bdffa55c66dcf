"""Alignments of a marker's views with a blob, scored one at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import LANES, lean, melted
from ..geometry.pixel_kernels import LabelView, padded_pixel

SLACK = 1e-6  # votes: more than rounding makes a bound smaller than what it bounds


class BankArrays(NamedTuple):
    """V views of a marker."""

    anchors: Any  # (V, a, 2)
    n_anchors: Any  # (V,) so many of them count
    inside: Any  # (V, 2, n)
    contour: Any  # (V, 2, m)
    normal: Any  # (V, 2, m)
    area: Any  # (V,)
    perimeter: Any  # (V,)
    scale: Any  # (V, 2) least and greatest
    centroid: Any  # (V, 2)
    direction: Any  # (V,) of the principal axis


class Moments(NamedTuple):
    """Of a blob: centroid, direction of the principal axis, area."""

    x: float
    y: float
    turn: float
    area_px: float


class Look(NamedTuple):
    """Votes for what lies inside a marker, and in the ring around it."""

    inside: Any  # (256,)
    ring: Any  # (256,)
    most_inside: float  # the greatest of each
    most_ring: float
    ring_px: float
    ring_width_px: float


@melted
def score_similarity(
    x0: float, y0: float, a: float, b: float, m: BankArrays, v: int, look: Look, view: LabelView, wanted: float, at: Any
) -> float:
    """Summed votes of pixels inside a view's outline and in a ring just outside of it, under the similarity
    p -> (x0, y0) + (a -b; b a) p; -inf where they are below `wanted`.

    :param at: scratch for pixels, of the samples looked at together, and of the contour's.
    """
    k = math.sqrt(a * a + b * b)
    n, total, ring = m.inside.shape[2], 0.0, 0.0
    share = m.area[v] * k * k / n
    around = m.perimeter[v] * k * look.ring_width_px
    most_ring = max(look.most_ring, 0.0) * around
    if n * look.most_inside * share + most_ring < wanted:
        return -np.inf
    for first in range(0, n, LANES):  # between two of these it looks whether the rest can still be enough
        xs, ys = m.inside[v, 0, first : first + LANES], m.inside[v, 1, first : first + LANES]
        for i in range(len(xs)):
            at[i] = padded_pixel(x0 + a * xs[i] - b * ys[i], y0 + b * xs[i] + a * ys[i], view)
        for i in range(len(xs)):
            total += look.inside[view.padded[at[i]]]
        if (total + (n - first - len(xs)) * look.most_inside) * share + most_ring < wanted:
            return -np.inf
    c, s = look.ring_px * a / k, look.ring_px * b / k
    xs, ys, us, vs = m.contour[v, 0], m.contour[v, 1], m.normal[v, 0], m.normal[v, 1]
    for i in range(len(xs)):
        x = x0 + a * xs[i] - b * ys[i] + c * us[i] - s * vs[i]
        y = y0 + b * xs[i] + a * ys[i] + s * us[i] + c * vs[i]
        at[i] = padded_pixel(x, y, view)
    for i in range(len(xs)):
        ring += look.ring[view.padded[at[i]]]
    return total * share + ring / len(xs) * around


@lean
def insert(T: Any, score: Any, x0: float, y0: float, a: float, b: float, value: float) -> None:
    """Keep the best similarities, best first."""
    i = len(score) - 1
    while i > 0 and score[i - 1] < value:
        score[i] = score[i - 1]
        for column in range(4):
            T[i, column] = T[i - 1, column]
        i -= 1
    score[i] = value
    T[i, 0], T[i, 1], T[i, 2], T[i, 3] = x0, y0, math.atan2(b, a), math.sqrt(a * a + b * b)


@melted
def offer(
    x0: float, y0: float, a: float, b: float, m: BankArrays, v: int, look: Look, view: LabelView, least: float, at: Any,
    T: Any, score: Any,
) -> float:  # fmt: skip
    """Keep a similarity of view `v` if it is among its best and reaches `least`; its score, -inf where it cannot be."""
    value = score_similarity(x0, y0, a, b, m, v, look, view, max(score[-1], least), at)
    if value > score[-1]:
        insert(T, score, x0, y0, a, b, value)
    return value


@lean
def note(most: Any, value: float) -> None:
    """Put a score among the best ones (N,), best first."""
    i = len(most) - 1
    if not value > most[i]:
        return
    while i > 0 and most[i - 1] < value:
        most[i] = most[i - 1]
        i -= 1
    most[i] = value


class Kept(NamedTuple):
    """The best K similarities of each view, best first; and room to read them in order."""

    T: Any  # (V, K, 4)
    score: Any  # (V, K), -inf: none
    next: Any  # (V,)
    most: Any  # (N,) the scores of the best N of all views so far, best first


@lean
def in_order(kept: Kept, least: float, T: Any, score: Any, of: Any) -> int:
    """Fill T (N, 4), score (N,) and of (N,) with the best of all views, best first, and say how many reach `least`."""
    kept.next[:] = 0
    for n in range(len(score)):
        v, best = -1, least
        for u in range(len(kept.next)):
            if kept.next[u] < kept.score.shape[1]:
                value = kept.score[u, kept.next[u]]
                if value > best or (v < 0 and value == best):
                    v, best = u, value
        if v < 0:
            return n
        for column in range(4):
            T[n, column] = kept.T[v, kept.next[v], column]
        score[n], of[n] = best, v
        kept.next[v] += 1
    return len(score)


@melted
def tried(
    x0: float, y0: float, a: float, b: float, m: BankArrays, v: int, look: Look, view: LabelView, least_share: float,
    best: float, at: Any, kept: Kept,
) -> float:  # fmt: skip
    """The best score so far, with that of a similarity of view `v`, which is kept if it is among the best.

    :param best: before it.
    """
    wanted = max(least_share * best, kept.most[-1] - SLACK)
    value = offer(x0, y0, a, b, m, v, look, view, wanted, at, kept.T[v], kept.score[v])
    note(kept.most, value)
    return max(best, value)


@lean
def try_moments(
    moments: Moments, m: BankArrays, look: Look, least_share: float, view: LabelView, at: Any, kept: Kept
) -> float:  # fmt: skip
    """The best score of what brings area, centroid and principal axis of a view and the blob together."""
    best = 0.0
    for v in range(len(m.area)):
        k = math.sqrt(moments.area_px / m.area[v])
        if not m.scale[v, 0] < k < m.scale[v, 1]:
            continue
        for quarter in (0, 2, 1, 3):
            theta = moments.turn - m.direction[v] + quarter * math.pi / 2
            a, b = k * math.cos(theta), k * math.sin(theta)
            x, y = m.centroid[v, 0], m.centroid[v, 1]
            x0, y0 = moments.x - a * x + b * y, moments.y - b * x - a * y
            best = tried(x0, y0, a, b, m, v, look, view, least_share, best, at, kept)
    return best


@lean
def try_anchors(
    p1: Any, p2: Any, m: BankArrays, look: Look, least_share: float, best: float, view: LabelView, at: Any, kept: Kept
) -> float:  # fmt: skip
    """The best score so far, with those of what brings couples of anchors together. :param best: before it."""
    for v in range(len(m.area)):
        low, high, n = m.scale[v, 0], m.scale[v, 1], m.n_anchors[v]
        for i in range(n):
            q1, q2 = m.anchors[v, i], m.anchors[v, (i + 1) % n]
            qx, qy = q2[0] - q1[0], q2[1] - q1[1]
            size = qx * qx + qy * qy
            if size == 0.0:
                continue
            qx, qy = qx / size, qy / size
            for j in range(len(p1)):
                px, py = p2[j, 0] - p1[j, 0], p2[j, 1] - p1[j, 1]
                a, b = px * qx + py * qy, py * qx - px * qy
                if low * low < a * a + b * b < high * high:
                    x0, y0 = p1[j, 0] - a * q1[0] + b * q1[1], p1[j, 1] - b * q1[0] - a * q1[1]
                    best = tried(x0, y0, a, b, m, v, look, view, least_share, best, at, kept)
    return best


@lean
def best_alignments(
    p1: Any, p2: Any, moments: Moments, m: BankArrays, look: Look, least_share: float, view: LabelView, at: Any,
    kept: Kept, T: Any, score: Any, of: Any,
) -> int:  # fmt: skip
    """Fill T (N, 4), score (N,) and of (N,) with the best of each view's best similarities: of
    those that bring area, centroid and principal axis together, in the axis' four turns, and of all couples of anchors
    (p1, p2), of which both contours' run the same way round. Says how many have `least_share` of the best one's score,
    which may be fewer than N.

    :param at: scratch, see `score_similarity`; kept: scratch, `most` as long as T.
    """
    kept.score[:] = -np.inf
    kept.most[:] = -np.inf
    best = try_moments(moments, m, look, least_share, view, at, kept)
    best = try_anchors(p1, p2, m, look, least_share, best, view, at, kept)
    return in_order(kept, least_share * best, T, score, of)
