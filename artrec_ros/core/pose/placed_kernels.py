"""A hypothesis placed, as the terms of a fit see it: how its points move with its parameters.

The parameters are the object's place, its turn about its place (a rotation vector), both along the camera's axes, and
its J joints.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted


class Joints(NamedTuple):
    """The J joints of C components."""

    lower: Any  # (J,)
    upper: Any
    unit: Any  # (J,) of a step: a radian, or a share of a sliding joint's range
    revolute: Any  # (J,) bool
    endless: Any  # (J,) bool
    moves: Any  # (C, J) bool


class Placed(NamedTuple):
    """One hypothesis."""

    t: Any  # (3,) the object's place, about which it turns
    q: Any  # (J,)
    R: Any  # (C, 3, 3) frames of its components in the camera
    frame_t: Any  # (C, 3)
    axis: Any  # (J, 3) of the joints, in the camera
    origin: Any  # (J, 3)
    joints: Joints


class Equations(NamedTuple):
    """Normal equations A x + b = 0 of the least squares that terms add up to."""

    A: Any  # (6 + J, 6 + J)
    b: Any  # (6 + J,)
    outwards: Any  # (8 + J,) row of one more, by how far all edges lie outwards: with these, with itself, of b


@jit
def no_equations(n_joints: int) -> Equations:
    """Room for the equations of one hypothesis."""
    n = 6 + n_joints
    return Equations(np.zeros((n, n)), np.zeros(n), np.zeros(n + 2))


@melted
def moving(c: int, placed: Placed, columns: Any) -> int:
    """Fill `columns` with the parameters that move component `c`, and say how many: the pose's six, and its joints."""
    n = 6
    for i in range(6):
        columns[i] = i
    for j in range(placed.joints.moves.shape[1]):
        if placed.joints.moves[c, j]:
            columns[n] = 6 + j
            n += 1
    return n
