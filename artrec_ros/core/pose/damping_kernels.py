"""The term of a fit that keeps its steps short (Levenberg), each parameter in its own unit."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..base.jit import melted
from .placed_kernels import Equations, Placed

SHIFT, BEND = 0, 1  # kinds of parameters: of the place; of the turn and the joints
_LEAST_DEPTH_M = 0.05


class Damping(NamedTuple):
    """How far one step should go, and may."""

    sigma_px: float  # of a contour point
    deviation: Any  # (2,) of a step of each kind, in its parameter's unit
    limit: Any  # (2,) the longest step, likewise
    held: Any  # (6,) weights that hold parameters of the pose where they are


@melted
def unit_of(i: int, placed: Placed) -> float:
    """What parameter `i` is measured in: the depth, a radian, a joint's unit."""
    if i < 3:
        return max(placed.t[2], _LEAST_DEPTH_M)
    return 1.0 if i < 6 else placed.joints.unit[i - 6]


@melted
def add_damping(term: Damping, placed: Placed, to: Equations) -> None:
    """Add the equations that pull the step to nothing."""
    for i in range(len(to.b)):
        deviation = unit_of(i, placed) * term.deviation[SHIFT if i < 3 else BEND]
        to.A[i, i] += (term.sigma_px / deviation) ** 2 + 1e-9 + (term.held[i] if i < 6 else 0.0)


@melted
def shorten(term: Damping, placed: Placed, x: Any) -> None:
    """Scale a step down to its longest."""
    longest = 1.0
    for i in range(len(x)):
        longest = max(longest, abs(x[i]) / (unit_of(i, placed) * term.limit[SHIFT if i < 3 else BEND]))
    for i in range(len(x)):
        x[i] /= longest
