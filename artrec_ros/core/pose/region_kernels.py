"""Fit of a figure of the image plane to raw colours: each of its regions even in itself, and unlike the others.

The piecewise constant model of Chan and Vese 2001, with a similarity and joints in place of a level set. It needs
neither classes nor their boundaries, and bears blur and the fringes of lenses and compression: they are alike on both
sides of an edge.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, lean, melted


class Regions(NamedTuple):
    """Points of a figure about its origin, in pixels at its first scale, and what bends it."""

    x: Any  # (n,)
    y: Any
    region: Any  # (n,) int64, of each
    n_regions: int
    moved: Any  # (J, n) bool: points that each joint moves; a joint comes before those that carry it
    turns: Any  # (J,) of a revolute joint 1 or -1: by what a radian turns its points in the image, else 0
    at: Any  # (J, 2) about where; of one that slides, how far a metre takes its points


@melted
def bend(r: Regions, x: Any, y: Any, joints: Any, out_x: Any, out_y: Any) -> None:
    """Fill out_x, out_y (n,) with a figure's points x, y after joints moved by so much (J,)."""
    for i in range(len(out_x)):
        out_x[i], out_y[i] = x[i], y[i]
    for j in range(len(joints)):
        if joints[j] == 0.0:
            continue
        angle, (ox, oy) = r.turns[j] * joints[j], (r.at[j, 0], r.at[j, 1])
        c, s, slides = math.cos(angle), math.sin(angle), r.turns[j] == 0.0
        for i in range(len(out_x)):
            if not r.moved[j, i]:
                continue
            if slides:
                out_x[i], out_y[i] = out_x[i] + joints[j] * ox, out_y[i] + joints[j] * oy
            else:
                u, v = out_x[i] - ox, out_y[i] - oy
                out_x[i], out_y[i] = ox + c * u - s * v, oy + s * u + c * v


@melted
def unevenness(image: Any, r: Regions, at: Any, sums: Any, xs: Any, ys: Any) -> float:
    """Share of the variance of the colours at all points that is within regions, 0 to 1, with joints moved and then
    under the similarity p -> (x0, y0) + (a -b; b a) p; 1 where a point lies outside of the image.

    :param image: (h, w, 3) uint8. :param at: (4 + J,) x, y, turn, scale, and by how much joints are moved.
    :param sums: (n_regions, 5) scratch: number, three sums, sum of squares. :param xs, ys: (n,) scratch.
    """
    h, w = image.shape[0], image.shape[1]
    x0, y0, a, b = at[0], at[1], at[3] * math.cos(at[2]), at[3] * math.sin(at[2])
    sums[:] = 0.0
    bend(r, r.x, r.y, at[4:], xs, ys)
    for i in range(len(xs)):
        u, v = x0 + a * xs[i] - b * ys[i], y0 + b * xs[i] + a * ys[i]
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
    image: Any, r: Regions, at: Any, steps: Any, rounds: int, least: Any, most: Any, sums: Any, scratch: Any
) -> float:
    """Move the similarity and the joints `at` (4 + J: x, y, turn, scale, joints), in place, to where regions are most
    even, by a search along its parameters; how uneven they are there.

    :param steps: (4 + J,) the first of each, scratch. :param least, most: (4 + J,) bounds of `at`.
    :param sums: (n_regions, 5) scratch. :param scratch: (3, at least 4 + J and n).
    """
    n, tried = len(at), scratch[0, : len(at)]
    xs, ys = scratch[1, : len(r.x)], scratch[2, : len(r.x)]
    best = unevenness(image, r, at, sums, xs, ys)
    for _ in range(rounds):
        for k in range(n):
            if least[k] == most[k]:
                continue
            for _side in range(2):
                for i in range(n):
                    tried[i] = at[i]
                tried[k] = min(max(at[k] + steps[k], least[k]), most[k])
                found = unevenness(image, r, tried, sums, xs, ys)
                if found < best:
                    best = found
                    for i in range(n):
                        at[i] = tried[i]
                    break
                steps[k] = -steps[k]
            else:
                steps[k] *= 0.5
    return best


@jit
def even_out_each(image: Any, r: Regions, at: Any, steps: Any, rounds: int, least: Any, most: Any, out: Any) -> None:
    """`even_out` of H figures of one kind, and how uneven each is there: out (H,).

    :param r: with x, y (H, n), turns (H, J), at (H, J, 2). :param at, steps, least, most: (H, 4 + J).
    """
    sums, scratch = np.empty((r.n_regions, 5)), np.empty((3, max(r.x.shape[1], at.shape[1])))
    for h in range(len(out)):
        figure = Regions(r.x[h], r.y[h], r.region, r.n_regions, r.moved, r.turns[h], r.at[h])
        out[h] = even_out(image, figure, at[h], steps[h], rounds, least[h], most[h], sums, scratch)
