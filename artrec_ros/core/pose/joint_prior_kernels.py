"""The term of a fit that holds joints: a weak pull keeps unseen ones determined, a strong one those not free."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..base.jit import melted
from .placed_kernels import Equations, Placed


class JointPrior(NamedTuple):
    """What is known of joints before the image is looked at."""

    middle: Any  # (J,) where they are pulled to
    weight: Any  # (J,) how strongly
    free: Any  # (H, J) bool
    pin: float  # weight that holds a joint where it is


@melted
def add_joint_prior(term: JointPrior, h: int, placed: Placed, to: Equations) -> None:
    """Add the equations of hypothesis `h`."""
    for j in range(len(placed.q)):
        to.A[6 + j, 6 + j] += term.weight[j] + (0.0 if term.free[h, j] else term.pin)
        to.b[6 + j] += term.weight[j] * (placed.q[j] - term.middle[j])
