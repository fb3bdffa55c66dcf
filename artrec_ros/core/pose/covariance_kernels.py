"""What makes fitted hypotheses err, added up contour point by contour point: see covariance.py."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted
from .contour_term_kernels import ContourFit


class Weights(NamedTuple):
    """What sums over points are taken with."""

    square_px2: float  # of the deviation of one point
    at_edges: Any  # (H,) see `ContourTerm`, no more than a number
    least_freedom: float
    stretches: int  # of a contour, each with errors of its own


class Sums(NamedTuple):
    """What H hypotheses' residuals are like."""

    outwards_px: Any  # (H,) all together
    freedom: Any  # (H,) by how much more they would spread if the fit had not taken degrees of freedom
    square: Any  # (H,) their mean square without what they have in common
    left_open: Any  # (H,) mean of the variances of the edges' places


class Spreads(NamedTuple):
    """(H, n, n) what each sort of error makes of the n parameters."""

    spread: Any  # of each point by itself
    by_pixel: Any  # of a pixel outwards of each marker by itself
    shift: Any  # of a pixel of all edges, along x and along y
    stretch: Any  # of what the residuals of each stretch of a contour have in common


@jit
def add_up(fit: ContourFit, by: Weights, A: Any, sums: Sums) -> None:
    """Add the contours' part to the normal equations A (H, n + 1, n + 1) of n parameters and of how far all edges lie
    outwards, and fill `sums`."""
    H, K, m, n = fit.jacobian.shape
    for h in range(H):
        weight, pull, points, left_open, square = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(K):
            alone = min(1.0, fit.spacing_px[h, k])
            for i in range(m):
                w = fit.weight[h, k, i]
                if w > 0.0:
                    weight, pull, points = weight + w, pull + w * fit.residual[h, k, i], points + alone
                    left_open += 1.0 - w
                    add_outer(fit.jacobian[h, k, i], w / by.square_px2, A[h])
        sums.outwards_px[h] = pull / (weight + by.at_edges[h])
        for k in range(K):
            for i in range(m):
                off = fit.residual[h, k, i] - sums.outwards_px[h]
                square += fit.weight[h, k, i] * off * off
        sums.freedom[h] = points / max(max(points - n, by.least_freedom * points), 1e-9)
        sums.square[h], sums.left_open[h] = square / max(weight, 1e-9), left_open / max(weight, 1e-9)


@melted
def add_outer(row: Any, weight: float, A: Any) -> None:
    """Add the square of a row (n,) and of a last 1 behind it to A (n + 1, n + 1), weighed."""
    n = len(row)
    for a in range(n):
        if row[a] != 0.0:  # of joints that do not move the point
            for b in range(n):
                A[a, b] += weight * row[a] * row[b]
            A[a, n] += weight * row[a]
            A[n, a] += weight * row[a]
    A[n, n] += weight


@melted
def add_square(x: Any, weight: float, out: Any) -> None:
    """Add x x' of (n,) to out (n, n), weighed."""
    for a in range(len(x)):
        for b in range(len(x)):
            out[a, b] += weight * x[a] * x[b]


@melted
def moved_by(row: Any, gain: Any, out: Any) -> None:
    """Fill out (n,) with what a pixel's error of a point does, whose derivatives are a row (n,) and a last 1."""
    n = len(row)
    for a in range(n):
        out[a] = gain[n, a]
    for b in range(n):
        if row[b] != 0.0:
            for a in range(n):
                out[a] += row[b] * gain[b, a]


@jit
def spread_out(fit: ContourFit, by: Weights, sums: Sums, gain: Any, out: Spreads) -> None:
    """Add up what errors make of the parameters, in `out`, zeros. :param gain: (H, n + 1, n) the inverse of what
    `add_up` fills, but for its last column."""
    H, K, m, n = fit.jacobian.shape
    x, of_all, of_one, of_stretch = np.empty(n), np.empty((2, n)), np.empty(n), np.empty(n)
    for h in range(H):
        of_all[:] = 0.0
        for k in range(K):
            alone = sums.square[h] * sums.freedom[h] / max(min(1.0, fit.spacing_px[h, k]), 1e-3)
            of_one[:] = 0.0
            for s in range(by.stretches):
                of_stretch[:] = 0.0
                for i in range(m * s // by.stretches, m * (s + 1) // by.stretches):
                    w = fit.weight[h, k, i] / by.square_px2
                    if w > 0.0:
                        moved_by(fit.jacobian[h, k, i], gain[h], x)
                        add_square(x, alone * w * w, out.spread[h])
                        off = w * (fit.residual[h, k, i] - sums.outwards_px[h])
                        across, down = w * fit.normal[h, k, i, 0], w * fit.normal[h, k, i, 1]
                        for a in range(n):
                            of_one[a], of_stretch[a] = of_one[a] + w * x[a], of_stretch[a] + off * x[a]
                            of_all[0, a], of_all[1, a] = of_all[0, a] + across * x[a], of_all[1, a] + down * x[a]
                add_square(of_stretch, sums.freedom[h], out.stretch[h])
            add_square(of_one, 1.0, out.by_pixel[h])
        add_square(of_all[0], 1.0, out.shift[h])
        add_square(of_all[1], 1.0, out.shift[h])
