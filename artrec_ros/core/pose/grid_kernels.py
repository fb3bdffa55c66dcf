"""Alignments of a marker that faces the camera, at pixels of blobs, in all directions and sizes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import LANES, jit, lean
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


@lean
def keep_apart(T: Any, score: Any, x: float, y: float, k: float, value: float, apart_px: float) -> None:
    """Put an alignment among the best of its direction T (K, 3), score (K,): in place of worse ones near it, else of
    the worst; where a better one is near it, or all are better, it is left out."""
    worst = 0
    for i in range(len(score)):
        if score[i] >= value and (T[i, 0] - x) ** 2 + (T[i, 1] - y) ** 2 < apart_px * apart_px:
            return
        if score[i] < score[worst]:
            worst = i
    if score[worst] >= value:
        return
    for i in range(len(score)):  # it takes the place of all that are near it
        if score[i] > -np.inf and (T[i, 0] - x) ** 2 + (T[i, 1] - y) ** 2 < apart_px * apart_px:
            worst, score[i] = i, -np.inf
    T[worst, 0], T[worst, 1], T[worst, 2], score[worst] = x, y, k, value


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
    grid: Grid, b: int, theta: float, pixels: Any, m: BankArrays, look: Look, view: LabelView, kept: Any, value: Any,
    at: Any,
) -> None:  # fmt: skip
    """Fill kept (K, 3) and value (K,) with the best alignments in one direction about a blob's pixels (n, 2).

    :param at: scratch, see `score_similarity`.
    """
    c, s, size = math.cos(theta), math.sin(theta), math.sqrt(m.area[0])
    value[:] = -np.inf
    k = grid.scale[b, 0]
    while k <= grid.scale[b, 1] * 1.000001:
        for i in range(len(pixels)):
            least = value[0]
            for other in range(1, len(value)):
                least = min(least, value[other])
            x, y = pixels[i, 0], pixels[i, 1]
            found = score_similarity(x, y, k * c, k * s, m, 0, look, view, max(least, 0.0), at)
            if found > max(least, 0.0):
                keep_apart(kept, value, x, y, k, found, grid.apart * size * k)
        k *= grid.ratio


@jit
def best_on_grid(grid: Grid, m: BankArrays, look: Look, view: LabelView, T: Any, score: Any, blob: Any) -> int:
    """Fill T (N, 4: x, y, turn, scale), score (N,) and blob (N,) with the best alignments of view 0 of a bank in each
    direction about each blob's pixels, and say how many there are."""
    most, places, count = 0, 0, 0
    for b in range(len(grid.keep)):
        most, box, step = max(most, grid.keep[b]), grid.box[b], grid.step[b]
        places = max(places, ((box[2] - box[0]) // step + 1) * ((box[3] - box[1]) // step + 1))
    kept, value, pixels = np.empty((most, 3)), np.empty(most), np.empty((places, 2))
    at = np.empty(max(m.contour.shape[2], LANES), np.int32)
    for b in range(len(grid.keep)):
        n, seen = grid.keep[b], pixels_of(grid, b, view, pixels)
        for turn in range(grid.turns):
            theta = 2 * math.pi * turn / grid.turns
            best_of_turn(grid, b, theta, pixels[:seen], m, look, view, kept[:n], value[:n], at)
            for i in range(n):
                if value[i] > 0.0:
                    T[count, 0], T[count, 1], T[count, 2], T[count, 3] = kept[i, 0], kept[i, 1], theta, kept[i, 2]
                    score[count], blob[count] = value[i], b
                    count += 1
    return count
