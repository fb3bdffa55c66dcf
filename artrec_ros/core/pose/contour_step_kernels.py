"""Steps of least squares by edges that are found otherwise than a fit finds them, and fits of such steps to colours."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted
from ..model.chain_kernels import Chain
from .colour_edge_kernels import ColourEdges, look_for_colours
from .contour_term_kernels import ContourFit, ContourTerm, contour_rows, leave_outwards
from .damping_kernels import Damping, add_damping
from .fit_kernels import move, solve
from .floor_term_kernels import FloorTerm, add_floor
from .placed_kernels import Equations, Joints, Placed, no_equations

_FAR_PX = 3.0  # residuals are no farther: a point that lies on nothing says no more than one that lies badly


class Beside(NamedTuple):
    """What steps balance beside edges."""

    floor: FloorTerm
    damping: Damping
    at_edges: Any  # (H,) see `ContourTerm`: paint may be larger than it was measured, and light spread otherwise


@melted
def add_edges(fit: ContourFit, h: int, residual: Any, weight: Any, to: Equations) -> None:
    """Fill the equations with what edges say of hypothesis `h`: the lower half of A, and b.

    :param residual, weight: (K, m).
    """
    n = len(to.b)
    for k in range(weight.shape[0]):
        for i in range(weight.shape[1]):
            w, r, row = weight[k, i], residual[k, i], fit.jacobian[h, k, i]
            if not w > 0.0:
                continue
            to.outwards[n] += w
            to.outwards[n + 1] += w * r
            for a in range(n):
                weighed = w * row[a]
                to.b[a] += weighed * r
                to.outwards[a] += weighed
                for c in range(a + 1):
                    to.A[a, c] += weighed * row[c]


@melted
def farthest(fit: ContourFit, h: int, weight: Any, x: Any) -> float:
    """How far a step takes the contours of hypothesis `h` at most, pixels. :param weight: (K, m) 0: nobody asks."""
    most = 0.0
    for k in range(weight.shape[0]):
        for i in range(weight.shape[1]):
            if weight[k, i] > 0.0:
                moved, row = 0.0, fit.jacobian[h, k, i]
                for a in range(len(x)):
                    moved += row[a] * x[a]
                most = max(most, abs(moved))
    return most


@jit
def step_each(
    fit: ContourFit, residual: Any, weight: Any, beside: Beside, joints: Joints, R: Any, t: Any, q: Any
) -> float:
    """Take one step of hypotheses R (H, 3, 3), t (H, 3), q (H, J) in place, and say how far it takes the contours at
    most, pixels.

    :param residual, weight: (H, K, m).
    """
    n_j, most, scratch = q.shape[1], 0.0, np.empty((3, 3, 3))
    to, x, first = no_equations(n_j), np.empty(6 + n_j), np.empty(6 + n_j, np.int64)
    no_frames, nowhere = np.empty((0, 3, 3)), np.empty((0, 3))  # only terms of contours ask where components are
    for h in range(len(R)):
        to.A[:], to.b[:], to.outwards[:] = 0.0, 0.0, 0.0
        add_edges(fit, h, residual[h], weight[h], to)
        leave_outwards(beside.at_edges[h], to)
        add_floor(beside.floor, R[h], t[h], to.A, to.b)
        # of joints nothing more: those that nobody sees stay
        add_damping(beside.damping, Placed(t[h], q[h], no_frames, nowhere, nowhere, nowhere, joints), to)
        solve(to.A, to.b, x, first)
        for i in range(len(x)):
            x[i] = -x[i]
        most = max(most, farthest(fit, h, weight[h], x))
        move(x, joints, R[h], t[h], q[h], scratch)
    return most


class Rounds(NamedTuple):
    """How long fits to colours go on."""

    most: int
    still_px: float  # a step that takes no contour farther is the last


@melted
def misfits(residual: Any, weight: Any, out: Any) -> None:
    """Fill out (H, 2) with the mean size of residuals (H, K, m), and what all weigh."""
    for h in range(len(out)):
        off, total = 0.0, 0.0
        for k in range(weight.shape[1]):
            for i in range(weight.shape[2]):
                off += weight[h, k, i] * min(abs(residual[h, k, i]), _FAR_PX)
                total += weight[h, k, i]
        out[h, 0], out[h, 1] = off / max(total, 1e-9), total


@melted
def limit(residual: Any, weight: Any, out: Any) -> None:
    """Fill out (H, K, m) with weights with which far residuals pull no more than those of a pixel (Huber)."""
    for h in range(weight.shape[0]):
        for k in range(weight.shape[1]):
            for i in range(weight.shape[2]):
                out[h, k, i] = weight[h, k, i] / max(1.0, abs(residual[h, k, i]))


@jit
def look_at_colours(
    term: ContourTerm, which: Any, chain: Chain, joints: Joints, end: float, colours: ColourEdges, radius_m: Any,
    most_px: float, R: Any, t: Any, q: Any, fit: ContourFit, residual: Any, weight: Any,
) -> None:  # fmt: skip
    """Contours of hypotheses as they are, and the residuals and weights (H, K, m) of the colours' edges.

    :param radius_m: (K,) of the markers: from `most_px` on looks go no farther.
    """
    fit.shown[:] = False
    contour_rows(term, which, chain, joints, end, R, t, q, fit)
    residual[:], weight[:] = fit.residual, fit.weight
    half_px, focal_px = np.empty((len(R), len(which))), np.sqrt(term.seen.K[0, 0] * term.seen.K[1, 1])
    for h in range(len(R)):
        for k in range(len(which)):
            half_px[h, k] = min(max(radius_m[k] * focal_px / max(t[h, 2], 1e-6), 1.0), most_px)
    look_for_colours(colours, fit.point, fit.normal, half_px, residual, weight)


@jit
def fit_to_colours(
    term: ContourTerm, which: Any, chain: Chain, joints: Joints, end: float, colours: ColourEdges, radius_m: Any,
    most_px: float, rounds: Rounds, beside: Beside, R: Any, t: Any, q: Any, fit: ContourFit, said: Any,
) -> None:  # fmt: skip
    """Fit hypotheses R (H, 3, 3), t (H, 3), q (H, J) to the colours' edges, in place.

    :param said: (2, H, 2) filled with the `misfits` before and after.
    """
    residual, weight, limited = np.empty(fit.weight.shape), np.empty(fit.weight.shape), np.empty(fit.weight.shape)
    look_at_colours(term, which, chain, joints, end, colours, radius_m, most_px, R, t, q, fit, residual, weight)
    misfits(residual, weight, said[0])
    for _ in range(rounds.most):
        limit(residual, weight, limited)
        moved_px = step_each(fit, residual, limited, beside, joints, R, t, q)
        look_at_colours(term, which, chain, joints, end, colours, radius_m, most_px, R, t, q, fit, residual, weight)
        if moved_px < rounds.still_px:
            break
    misfits(residual, weight, said[1])
