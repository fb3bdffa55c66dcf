"""A whole fit: Gauss-Newton steps of a pose and joints, a hypothesis at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, lean
from ..geometry.pixel_kernels import View
from ..model.chain_kernels import Chain, forward, turn_by
from .edge_kernels import EdgeTerms, edge_room
from .fit_kernels import Motion, normal_equations
from .surface_kernels import Surface


class Joints(NamedTuple):
    """J joints and their weak prior."""

    lower: Any  # (J,)
    upper: Any
    unit: Any
    revolute: Any  # (J,) bool
    endless: Any  # (J,) bool
    moves: Any  # (C, J) bool
    middle: Any  # (J,) where the prior pulls to
    weight: Any  # (J,) how strongly
    pin: float  # weight that holds a joint where it is


class StepTerms(NamedTuple):
    """What bounds a step: of the shift, and of turns and joints."""

    sigma_px: float
    damping: Any  # (2,) a step's standard deviation, in each parameter's unit
    limit: Any  # (2,) the longest step


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
def step(
    A: Any, b: Any, free: Any, joints: Joints, m: StepTerms, R: Any, t: Any, q: Any, x: Any, first: Any, scratch: Any
) -> None:
    """Move one hypothesis R (3, 3), t (3,), q (J,) by a damped and bounded Gauss-Newton step, joints within their
    limits; free (J,) bool."""
    n, n_joints, depth = len(b), len(q), max(t[2], 0.05)
    for j in range(n_joints):
        A[6 + j, 6 + j] += joints.weight[j] + (0.0 if free[j] else joints.pin)
        b[6 + j] += joints.weight[j] * (q[j] - joints.middle[j])
    for i in range(n):
        unit = depth if i < 3 else (1.0 if i < 6 else joints.unit[i - 6])
        A[i, i] += (m.sigma_px / (unit * m.damping[0 if i < 3 else 1])) ** 2 + 1e-9
    solve(A, b, x, first)
    longest = 1.0
    for i in range(n):
        unit = depth if i < 3 else (1.0 if i < 6 else joints.unit[i - 6])
        longest = max(longest, abs(x[i]) / (unit * m.limit[0 if i < 3 else 1]))
    for i in range(n):
        x[i] /= -longest
    turn_by(x[3], x[4], x[5], R, scratch)
    for i in range(3):
        t[i] += x[i]
    for j in range(n_joints):
        value = q[j] + x[6 + j]
        if joints.endless[j]:
            q[j] = joints.lower[j] + (value - joints.lower[j]) % (2 * math.pi)
        else:
            q[j] = min(max(value, joints.lower[j]), joints.upper[j])


@jit
def refine(
    s: Surface, chain: Chain, joints: Joints, markers: Any, use: Any, free: Any, e: EdgeTerms, m: StepTerms, view: View,
    least_cosine: float, R: Any, t: Any, q: Any,
) -> None:  # fmt: skip
    """Fit hypotheses R (H, 3, 3), t (H, 3), q (H, J) in place; one that uses no marker stays.

    :param use: (H, M) bool; free: (H, J) bool.
    """
    n_c, n_joints = len(chain.parent), q.shape[1]
    frames_R, frames_t = np.empty((1, n_c, 3, 3)), np.empty((1, n_c, 3))
    axis, origin = np.empty((1, n_joints, 3)), np.empty((1, n_joints, 3))
    A, b, x = np.empty((6 + n_joints, 6 + n_joints)), np.empty(6 + n_joints), np.empty(6 + n_joints)
    columns, first = np.empty(6 + n_joints, np.int64), np.empty(6 + n_joints, np.int64)
    scratch = np.empty((3, 3, 3))
    room = edge_room(s.contour.shape[2], e.reach.max(), 6 + n_joints)
    for h in range(len(R)):
        if not use[h].any():
            continue
        for i in range(len(e.reach)):
            forward(chain, R[h : h + 1], t[h : h + 1], q[h : h + 1], frames_R, frames_t, axis, origin)
            motion = Motion(t[h], axis[0], origin[0], joints.revolute, joints.moves)
            normal_equations(
                s, markers, use[h], frames_R[0], frames_t[0], motion, e, i, view, least_cosine, A, b,
                columns, room,
            )  # fmt: skip
            step(A, b, free[h], joints, m, R[h], t[h], q[h], x, first, scratch)
