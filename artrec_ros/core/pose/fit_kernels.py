"""A whole fit: Gauss-Newton steps of a pose and joints on what its terms add up to, a hypothesis at a time.

A term is a tuple of what it knows, and a function that adds its part of the normal equations. A further one is a file
like joint_prior_kernels.py, a field of `Terms` and a line of `add_all`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, lean, melted
from ..model.chain_kernels import Chain, place_seen, turn_by
from .contour_term_kernels import ContourTerm, add_contours, leave_outwards
from .damping_kernels import Damping, add_damping, shorten
from .edge_kernels import EdgeRoom, edge_room
from .floor_term_kernels import FloorTerm, add_floor
from .joint_prior_kernels import JointPrior, add_joint_prior
from .placed_kernels import Equations, Joints, Placed, no_equations


class Terms(NamedTuple):
    """What a fit balances."""

    contours: ContourTerm
    joints: JointPrior
    floor: FloorTerm
    damping: Damping


@melted
def add_all(
    terms: Terms, h: int, step: int, R: Any, placed: Placed, to: Equations, columns: Any, room: EdgeRoom
) -> None:
    """Fill the equations of hypothesis `h`, turned by R (3, 3), in step `step`: the lower half of A, and b."""
    to.A[:], to.b[:], to.outwards[:] = 0.0, 0.0, 0.0
    add_contours(terms.contours, h, step, placed, to, columns, room)
    leave_outwards(terms.contours.at_edges[h], to)
    add_joint_prior(terms.joints, h, placed, to)
    add_floor(terms.floor, R, placed.t, to.A, to.b)
    add_damping(terms.damping, placed, to)


@lean
def solve(A: Any, b: Any, x: Any, first: Any) -> None:
    """x of A x = b, A symmetric and positive definite (Cholesky). A's lower half is overwritten, its diagonal by what
    is multiplied with in place of a division.

    :param first: int64 scratch (n,), each row's first column that is not zero: a joint that moves no marker in use has
        nothing before its diagonal.
    """
    n = len(b)
    for i in range(n):
        first[i] = 0
        while A[i, first[i]] == 0.0 and first[i] < i:
            first[i] += 1
        for j in range(first[i], i):
            value = A[i, j]
            for k in range(max(first[i], first[j]), j):
                value -= A[i, k] * A[j, k]
            A[i, j] = value * A[j, j]
        value, pull = A[i, i], b[i]
        for k in range(first[i], i):
            value -= A[i, k] * A[i, k]
            pull -= A[i, k] * x[k]
        A[i, i] = 1.0 / math.sqrt(max(value, 1e-300))  # only ever divided by
        x[i] = pull * A[i, i]
    for i in range(n - 1, -1, -1):
        x[i] *= A[i, i]
        for k in range(first[i], i):
            x[k] -= A[i, k] * x[i]


@lean
def move(x: Any, joints: Joints, R: Any, t: Any, q: Any, scratch: Any) -> None:
    """Take a step x (6 + J,) of one hypothesis R (3, 3), t (3,), q (J,), in place."""
    turn_by(x[3], x[4], x[5], R, scratch)
    for i in range(3):
        t[i] += x[i]
    for j in range(len(q)):
        value = q[j] + x[6 + j]
        if joints.endless[j]:
            q[j] = joints.lower[j] + (value - joints.lower[j]) % (2 * math.pi)
        else:
            q[j] = min(max(value, joints.lower[j]), joints.upper[j])


class FitRoom(NamedTuple):
    """Scratch arrays of one hypothesis."""

    R: Any  # (C, 3, 3) frames of its components
    frame_t: Any  # (C, 3)
    axis: Any  # (J, 3)
    origin: Any  # (J, 3)
    equations: Equations
    x: Any  # (6 + J,)
    columns: Any  # (6 + J,) int64
    first: Any  # (6 + J,) int64
    scratch: Any  # (3, 3, 3)
    edges: EdgeRoom


@melted
def fit_one(terms: Terms, h: int, chain: Chain, joints: Joints, R: Any, t: Any, q: Any, room: FitRoom) -> None:
    """Fit hypothesis `h`, R (3, 3), t (3,), q (J,), in place."""
    for step in range(len(terms.contours.edges.reach)):
        place_seen(chain, R, t, q, room.R, room.frame_t, room.axis, room.origin, room.scratch)
        placed = Placed(t, q, room.R, room.frame_t, room.axis, room.origin, joints)
        add_all(terms, h, step, R, placed, room.equations, room.columns, room.edges)
        solve(room.equations.A, room.equations.b, room.x, room.first)
        shorten(terms.damping, placed, room.x)
        for i in range(len(room.x)):
            room.x[i] = -room.x[i]
        move(room.x, joints, R, t, q, room.scratch)


@jit
def move_each(x: Any, joints: Joints, R: Any, t: Any, q: Any) -> None:
    """Take steps x (H, 6 + J) of hypotheses R (H, 3, 3), t (H, 3), q (H, J), in place."""
    scratch = np.empty((3, 3, 3))
    for h in range(len(R)):
        move(x[h], joints, R[h], t[h], q[h], scratch)


@jit
def fit_room(terms: Terms, chain: Chain, n_joints: int) -> FitRoom:
    """Scratch arrays for the fits of these terms."""
    n_c, n, edges = len(chain.parent), 6 + n_joints, terms.contours.edges
    return FitRoom(
        np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((n_joints, 3)), np.empty((n_joints, 3)),
        no_equations(n_joints), np.empty(n), np.empty(n, np.int64), np.empty(n, np.int64), np.empty((3, 3, 3)),
        edge_room(terms.contours.surface.contour.shape[2], edges.reach.max(), n),
    )  # fmt: skip


@jit
def fit_each(terms: Terms, chain: Chain, joints: Joints, R: Any, t: Any, q: Any) -> None:
    """Fit hypotheses R (H, 3, 3), t (H, 3), q (H, J) in place; one that uses no marker stays."""
    use, room = terms.contours.use, fit_room(terms, chain, q.shape[1])
    for h in range(len(R)):
        if use[h].any():
            fit_one(terms, h, chain, joints, R[h], t[h], q[h], room)
