"""Alignments of a marker that faces the camera, at pixels of blobs, in all directions and sizes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import LANES, jit, lean, melted
from ..geometry.pixel_kernels import LabelView
from .guess_kernels import BankArrays, Look, score_similarity


class Grid(NamedTuple):
    """Where B blobs are looked at."""

    labels: Any  # padded as a `LabelView`'s codes are
    label: Any  # (B,) of each blob
    box: Any  # (B, 4) least x and y, greatest x and y: at pixels in it that have the label,
    step: Any  # (B,) so far apart
    scale: Any  # (B, 2) least and greatest
    ratio: float  # of one scale to the next
    turns: int  # directions
    keep: Any  # (B,) alignments of each direction
    apart: float  # those of one direction have their centres so far apart, as a share of the marker's size


class Kept(NamedTuple):
    """The best K alignments of one direction, -inf: none."""

    x: Any  # (K,)
    y: Any
    scale: Any
    score: Any


class Laid(NamedTuple):
    """Where the points of a view are looked up, from the pixel on that it is laid on: pixels are whole, so that these
    are the same for all of them."""

    inside: Any  # (n,) in the padded labels
    ring: Any  # (m,)
    within: Any  # (4,) least and greatest x and y of pixels around which all of these lie in the image


@lean
def keep_apart(kept: Kept, x: float, y: float, k: float, value: float, apart_px: float) -> None:
    """Put an alignment among the best of its direction: in place of worse ones near it, else of the worst; where a
    better one is near it, or all are better, it is left out."""
    score, reach, worse, better, worst = kept.score, apart_px * apart_px, False, False, 0
    for i in range(len(score)):
        near = (kept.x[i] - x) ** 2 + (kept.y[i] - y) ** 2 < reach
        better |= near & (score[i] >= value)
        worse |= near & (score[i] > -np.inf)
    if better:
        return
    for i in range(len(score)):
        if not worse:
            worst = i if score[i] < score[worst] else worst
        elif score[i] > -np.inf and (kept.x[i] - x) ** 2 + (kept.y[i] - y) ** 2 < reach:
            worst, score[i] = i, -np.inf  # it takes the place of all that are near it
    if score[worst] >= value:
        return
    kept.x[worst], kept.y[worst], kept.scale[worst], score[worst] = x, y, k, value


@lean
def lay(m: BankArrays, k: float, c: float, s: float, look: Look, view: LabelView, laid: Laid) -> None:
    """Fill `laid` with view 0 of a bank at scale `k`, turned by an angle of cosine c and sine s."""
    a, b, width, within = k * c, k * s, view.width + 2, laid.within
    within[0], within[1], within[2], within[3] = 0.0, 0.0, view.width - 1.0, view.height - 1.0
    for part in range(2):
        out, far = (laid.ring, look.ring_px) if part else (laid.inside, 0.0)
        on = m.contour[0] if part else m.inside[0]
        for i in range(len(out)):
            nu, nv = (m.normal[0, 0, i], m.normal[0, 1, i]) if part else (0.0, 0.0)
            u = math.floor(a * on[0, i] - b * on[1, i] + far * (c * nu - s * nv) + 0.5)
            v = math.floor(b * on[0, i] + a * on[1, i] + far * (s * nu + c * nv) + 0.5)
            out[i] = int(v) * width + int(u)
            within[0], within[1] = max(within[0], -u), max(within[1], -v)
            within[2], within[3] = min(within[2], view.width - 1 - u), min(within[3], view.height - 1 - v)


@melted
def score_laid(at: int, k: float, m: BankArrays, laid: Laid, look: Look, view: LabelView, wanted: float) -> float:
    """As `score_similarity`, of what lies in the image. :param at: the pixel's index in the padded labels."""
    n, total, ring = len(laid.inside), 0.0, 0.0
    share, around = m.area[0] * k * k / n, m.perimeter[0] * k * look.ring_width_px
    most_ring = max(look.most_ring, 0.0) * around
    if n * look.most_inside * share + most_ring < wanted:
        return -np.inf
    whole = n - n % LANES
    for first in range(0, whole, LANES):  # a number of them that is known makes this twice as fast
        for i in range(first, first + LANES):
            total += look.inside[view.padded[at + laid.inside[i]]]
        if (total + (n - first - LANES) * look.most_inside) * share + most_ring < wanted:
            return -np.inf
    for i in range(whole, n):
        total += look.inside[view.padded[at + laid.inside[i]]]
    for i in range(len(laid.ring)):
        ring += look.ring[view.padded[at + laid.ring[i]]]
    return total * share + ring / len(laid.ring) * around


@lean
def pixels_of(grid: Grid, b: int, view: LabelView, out: Any) -> int:
    """Fill out (n, 2) with where blob `b` is looked at, and say how many that are."""
    n, step = 0, grid.step[b]
    for y in range(grid.box[b, 1], grid.box[b, 3] + 1, step):
        for x in range(grid.box[b, 0], grid.box[b, 2] + 1, step):
            if grid.labels[(y + 1) * (view.width + 2) + x + 1] == grid.label[b]:
                out[n, 0], out[n, 1] = x, y
                n += 1
    return n


@lean
def best_of_turn(
    grid: Grid, b: int, theta: float, pixels: Any, m: BankArrays, look: Look, view: LabelView, kept: Kept, laid: Laid,
    at: Any,
) -> None:  # fmt: skip
    """Fill `kept` with the best alignments in one direction about a blob's pixels (n, 2).

    :param laid: scratch. :param at: scratch, see `score_similarity`.
    """
    c, s, size, least = math.cos(theta), math.sin(theta), math.sqrt(m.area[0]), -np.inf
    kept.score[:] = -np.inf
    k, within = grid.scale[b, 0], laid.within
    while k <= grid.scale[b, 1] * 1.000001:
        lay(m, k, c, s, look, view, laid)
        for i in range(len(pixels)):
            x, y = pixels[i, 0], pixels[i, 1]
            if within[0] <= x <= within[2] and within[1] <= y <= within[3]:
                here = (int(y) + 1) * (view.width + 2) + int(x) + 1
                found = score_laid(here, k, m, laid, look, view, max(least, 0.0))
            else:
                found = score_similarity(x, y, k * c, k * s, m, 0, look, view, max(least, 0.0), at)
            if found > max(least, 0.0):
                keep_apart(kept, x, y, k, found, grid.apart * size * k)
                least = kept.score[0]
                for other in range(1, len(kept.score)):
                    least = min(least, kept.score[other])
        k *= grid.ratio


@jit
def best_on_grid(grid: Grid, m: BankArrays, look: Look, view: LabelView, T: Any, score: Any, blob: Any) -> int:
    """Fill T (N, 4: x, y, turn, scale), score (N,) and blob (N,) with the best alignments of view 0 of a bank in each
    direction about each blob's pixels, and say how many there are."""
    most, places, count, n_on, n_ring = 0, 0, 0, m.inside.shape[2], m.contour.shape[2]
    for b in range(len(grid.keep)):
        most, box, step = max(most, grid.keep[b]), grid.box[b], grid.step[b]
        places = max(places, ((box[2] - box[0]) // step + 1) * ((box[3] - box[1]) // step + 1))
    best, pixels, at = np.empty((4, most)), np.empty((places, 2)), np.empty(max(n_ring, LANES), np.int32)
    laid = Laid(np.empty(n_on, np.int64), np.empty(n_ring, np.int64), np.empty(4))
    for b in range(len(grid.keep)):
        n, seen = grid.keep[b], pixels_of(grid, b, view, pixels)
        kept = Kept(best[0, :n], best[1, :n], best[2, :n], best[3, :n])
        for turn in range(grid.turns):
            theta = 2 * math.pi * turn / grid.turns
            best_of_turn(grid, b, theta, pixels[:seen], m, look, view, kept, laid, at)
            for i in range(n):
                if kept.score[i] > 0.0:
                    T[count, 0], T[count, 1], T[count, 2], T[count, 3] = kept.x[i], kept.y[i], theta, kept.scale[i]
                    score[count], blob[count] = kept.score[i], b
                    count += 1
    return count
