"""Hypotheses that differ, the best first."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base.jit import jit


@jit
def cell(value: float) -> int:
    """The nearest whole number; 0 of a NaN."""
    return int(np.rint(min(max(value, -1e9), 1e9))) if value == value else 0


@jit
def fill_cells(R: Any, t: Any, place: float, depth: float, turn: float, out: Any) -> None:
    """Nine whole numbers of one hypothesis R (3, 3), t (3,), equal where refinement would bring two to one place."""
    z = max(t[2], 1e-6)
    out[0], out[1], out[2] = cell(t[0] / z / place), cell(t[1] / z / place), cell(math.log(z) / depth)
    for i in range(3):
        out[3 + i], out[6 + i] = cell(R[i, 0] / turn), cell(R[i, 2] / turn)


@jit
def first_of_cells(order: Any, R: Any, t: Any, place: float, depth: float, turn: float, out: Any) -> int:
    """Fill `out` (n,) with the first hypotheses in `order`, one of each cell; how many these are."""
    kept, cells = 0, np.empty((len(out) + 1, 9), np.int64)
    for h in order:
        if kept == len(out):
            break
        fill_cells(R[h], t[h], place, depth, turn, cells[kept])
        new = True
        for k in range(kept):
            same = True
            for i in range(9):
                if cells[k, i] != cells[kept, i]:
                    same = False
                    break
            if same:
                new = False
                break
        if new:
            out[kept] = h
            kept += 1
    return kept


@jit
def few_of_places(at: Any, turn: Any, reach: Any, most: int, most_alike: int, cosine: float, out: Any) -> int:
    """Fill `out` (n,) with hypotheses at places (n, 2) in directions (n,), in their order, of which fewer than `most`
    of those before are within reach (n,), and of these fewer than `most_alike` in a direction with a greater cosine to
    its own: more of a kind would keep out what is turned otherwise. How many these are."""
    kept = 0
    for i in range(len(at)):
        near = alike = 0
        for k in range(kept):
            j = out[k]
            x, y = at[j, 0] - at[i, 0], at[j, 1] - at[i, 1]
            if x * x + y * y < reach[i] * reach[i]:
                near += 1
                alike += math.cos(turn[j] - turn[i]) > cosine
        if near < most and alike < most_alike:
            out[kept] = i
            kept += 1
    return kept
