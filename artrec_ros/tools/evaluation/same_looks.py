"""Rotations that are off by turns after which an object looks the same: no picture tells these."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...core.geometry.transforms import Array, rotation_from_rotvec
from ...core.model.objects import ObjectModel
from ...core.model.same_turns import SameTurn, same_turns
from ...core.model.target import Target

if TYPE_CHECKING:
    from .outcomes import Outcome

_LEAST_SHARE = 0.05  # of rotations: what is rarer is not worth a line
FAR_RAD = np.radians(15.0)  # an error that is less is none of another turn
_PARALLEL = 0.99  # cosine


@dataclass(frozen=True, eq=False)
class SameLooks:
    """Rotations after which an object looks as it did.

    :param turns: (k, 3, 3) of the object's frame, none among them. :param round: (r, 3) axes about which any turn does.
    """

    turns: Array
    round: Array

    @classmethod
    def of(cls, model: ObjectModel) -> SameLooks:
        turns = same_turns(model)
        if len(model.components) == len(Target(model.name, model, 0).balls) == 1:
            return cls(np.eye(3)[None], np.eye(3))
        return cls(_all_of(turns), np.array([turn.axis for turn in turns if turn.is_round]).reshape(-1, 3))

    def error_rad(self, true: Array, found: Array) -> float:
        """How far a rotation is from the nearest one that looks like the true one."""
        if (np.abs(self.round @ self.round.T) < _PARALLEL).any():
            return 0.0  # round about two axes it is a ball
        off = (true @ self.turns).swapaxes(1, 2) @ found
        least = np.arccos(np.clip((np.trace(off, axis1=1, axis2=2) - 1) / 2, -1, 1)).min()
        for axis in self.round:  # turned about it at will, it is off by what the axis is
            least = min(least, np.arccos(np.clip((off @ axis) @ axis, -1, 1)).min())
        return float(least)


AS_IT_IS = SameLooks(np.eye(3)[None], np.zeros((0, 3)))


def turned_alike(outcomes: Sequence[tuple[str, Outcome]]) -> Iterator[str]:
    """A line for each object of which many rotations are off so. :param outcomes: object name and outcome."""
    for name in dict.fromkeys(name for name, _ in outcomes):
        mine = [o for n, o in outcomes if n == name and o.turn_told_rad is not None]
        alike = sum(o.turned_alike for o in mine)
        if alike > _LEAST_SHARE * len(mine):
            off = [o.turn_told_rad or 0.0 for o in mine]
            yield (
                f"'{name}' looks the same after some turns (artrec model says which): {alike} of {len(off)} "
                f"rotations are off by such a one, which no picture tells; rotation errors are those from the nearest "
                f"(from the truth as it is: {np.degrees(np.median(off)):.2f} deg in the median), joints count as told"
            )


def _all_of(turns: Sequence[SameTurn]) -> Array:
    """(k, 3, 3) rotations by them, as often as they can be done, by two of them, and by none."""
    single = [
        rotation_from_rotvec(k * turn.angle_rad * turn.axis)
        for turn in turns
        for k in range(1, round(2 * np.pi / turn.angle_rad))
    ]
    return np.array([np.eye(3), *single, *(a @ b for a in single for b in single)])
