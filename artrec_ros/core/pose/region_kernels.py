"""Fit of a figure of the image plane to raw colours: each of its regions even in itself, and unlike the others.

The piecewise constant model of Chan and Vese 2001, with a similarity in place of a level set. It needs neither classes
nor their boundaries, and bears blur and the fringes of lenses and compression: they are alike on both sides of an edge.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import inlined, jit, lean


class Regions(NamedTuple):
    """Points of a figure about its middle, in pixels at its first scale."""

    x: Any  # (n,)
    y: Any
    region: Any  # (n,) int64, of each
    n_regions: int


@inlined
def unevenness(image: Any, r: Regions, x0: float, y0: float, a: float, b: float, sums: Any) -> float:
    """Share of the variance of the colours at all points that is within regions, 0 to 1, under the similarity
    p -> (x0, y0) + (a -b; b a) p; 1 where a point lies outside of the image.

    :param image: (h, w, 3) uint8. :param sums: (n_regions, 5) scratch: number, three sums, sum of squares.
    """
    h, w = image.shape[0], image.shape[1]
    sums[:] = 0.0
    for i in range(len(r.x)):
        u, v = x0 + a * r.x[i] - b * r.y[i], y0 + b * r.x[i] + a * r.y[i]
        if not (0.0 <= u < w - 1 and 0.0 <= v < h - 1):
            return 1.0
        c, q = int(u), int(v)
        du, dv = u - c, v - q
        row = sums[r.region[i]]
        row[0] += 1.0
        for k in range(3):
            top = (1 - du) * image[q, c, k] + du * image[q, c + 1, k]
            value = (1 - dv) * top + dv * ((1 - du) * image[q + 1, c, k] + du * image[q + 1, c + 1, k])
            row[1 + k] += value
            row[4] += value * value
    within, square, n = 0.0, 0.0, 0.0
    s0, s1, s2 = 0.0, 0.0, 0.0
    for g in range(r.n_regions):
        row = sums[g]
        within += row[4] - (row[1] * row[1] + row[2] * row[2] + row[3] * row[3]) / max(row[0], 1.0)
        n, square = n + row[0], square + row[4]
        s0, s1, s2 = s0 + row[1], s1 + row[2], s2 + row[3]
    return within / max(square - (s0 * s0 + s1 * s1 + s2 * s2) / n, 1e-9)


@lean
def even_out(
    image: Any, r: Regions, at: Any, steps: Any, rounds: int, least: Any, most: Any, sums: Any, tried: Any
) -> float:
    """Move the similarity `at` (4: x, y, turn, scale), in place, to where regions are most even, by a search along its
    parameters; how uneven they are there.

    :param steps: (4,) the first of each, scratch. :param least, most: (4,) bounds of `at`.
    :param sums: (n_regions, 5) scratch. :param tried: (4,) scratch.
    """
    best = unevenness(image, r, at[0], at[1], at[3] * math.cos(at[2]), at[3] * math.sin(at[2]), sums)
    for _ in range(rounds):
        for k in range(4):
            for _side in range(2):
                for i in range(4):
                    tried[i] = at[i]
                tried[k] = min(max(at[k] + steps[k], least[k]), most[k])
                a, b = tried[3] * math.cos(tried[2]), tried[3] * math.sin(tried[2])
                found = unevenness(image, r, tried[0], tried[1], a, b, sums)
                if found < best:
                    best = found
                    for i in range(4):
                        at[i] = tried[i]
                    break
                steps[k] = -steps[k]
            else:
                steps[k] *= 0.5
    return best


@jit
def even_out_each(image: Any, r: Regions, at: Any, steps: Any, rounds: int, least: Any, most: Any, out: Any) -> None:
    """`even_out` of H figures of one kind, and how uneven each is there: out (H,).

    :param r: with x, y (H, n). :param at, steps, least, most: (H, 4).
    """
    sums, tried = np.empty((r.n_regions, 5)), np.empty(4)
    for h in range(len(out)):
        figure = Regions(r.x[h], r.y[h], r.region, r.n_regions)
        out[h] = even_out(image, figure, at[h], steps[h], rounds, least[h], most[h], sums, tried)
