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

    pixels: Any  # (n, 2) of all blobs, one after the other
    starts: Any  # (B + 1,) where those of each one begin
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


@jit
def best_on_grid(grid: Grid, m: BankArrays, look: Look, view: LabelView, T: Any, score: Any, blob: Any) -> int:
    """Fill T (N, 4: x, y, turn, scale), score (N,) and blob (N,) with the best alignments of view 0 of a bank in each
    direction about each blob's pixels, and say how many there are."""
    most = 0
    for b in range(len(grid.keep)):
        most = max(most, grid.keep[b])
    kept, value = np.empty((most, 3)), np.empty(most)
    at, count, size = np.empty(max(m.contour.shape[2], LANES), np.int32), 0, math.sqrt(m.area[0])
    for b in range(len(grid.keep)):
        n = grid.keep[b]
        for turn in range(grid.turns):
            theta = 2 * math.pi * turn / grid.turns
            c, s = math.cos(theta), math.sin(theta)
            value[:n] = -np.inf
            k = grid.scale[b, 0]
            while k <= grid.scale[b, 1] * 1.000001:
                for i in range(grid.starts[b], grid.starts[b + 1]):
                    x, y = grid.pixels[i, 0], grid.pixels[i, 1]
                    least = value[0]
                    for other in range(1, n):
                        least = min(least, value[other])
                    found = score_similarity(x, y, k * c, k * s, m, 0, look, view, max(least, 0.0), at)
                    if found > max(least, 0.0):
                        keep_apart(kept[:n], value[:n], x, y, k, found, grid.apart * size * k)
                k *= grid.ratio
            for i in range(n):
                if value[i] > 0.0:
                    T[count, 0], T[count, 1], T[count, 2], T[count, 3] = kept[i, 0], kept[i, 1], theta, kept[i, 2]
                    score[count], blob[count] = value[i], b
                    count += 1
    return count
