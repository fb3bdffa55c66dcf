"""Rotations that are off by turns after which an object looks the same: no picture tells these."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.geometry.transforms import Array, rotation_from_rotvec
from ...core.model.objects import ObjectModel
from ...core.model.same_turns import SameTurn, same_turns
from ...io.truth.records import TrueObject

if TYPE_CHECKING:
    from .outcomes import Outcome

_LEAST_SHARE = 0.05  # of rotations: what is rarer is not worth a line
AS_TRUE = 0.1  # radians, or units of what slides: a joint that is told with less error is told as it is
FAR_RAD = np.radians(15.0)  # an error that is less is none of another turn
_PARALLEL = 0.99  # cosine


@dataclass(frozen=True, eq=False)
class SameLooks:
    """Rotations after which an object looks as it did.

    :param turns: (k, 3, 3) of the object's frame, none among them. :param bent: (k) joints that must be bent otherwise
        for it. :param round: (r, 3) axes about which any turn does, whatever joints do. :param middle: (3,) metres: all
        axes go through it.
    """

    turns: Array
    bent: Sequence[frozenset[str]]
    round: Array
    middle: Array

    @classmethod
    def of(cls, model: ObjectModel) -> SameLooks:
        turns = same_turns(model)
        axes = [turn.axis for turn in turns if turn.is_round and not turn.bent]
        middle = turns[0].through if turns else np.zeros(3)
        return cls(*_all_of(turns), np.array(axes).reshape(-1, 3), middle)

    def error_rad(self, true: Array, found: Array, as_true: Collection[str] = ()) -> float:
        """How far a rotation is from the nearest one that looks like the true one.

        :param as_true: joints that are told as they are: where all are that must be bent otherwise, it is not turned.
        """
        if (np.abs(self.round @ self.round.T) < _PARALLEL).any():
            return 0.0  # round about two axes it is a ball
        may_be = [n for n, bent in enumerate(self.bent) if not bent or not bent <= frozenset(as_true)]
        off = (true @ self.turns[may_be]).swapaxes(1, 2) @ found
        least = np.arccos(np.clip((np.trace(off, axis1=1, axis2=2) - 1) / 2, -1, 1)).min()
        for axis in self.round:  # turned about it at will, it is off by what the axis is
            least = min(least, np.arccos(np.clip((off @ axis) @ axis, -1, 1)).min())
        return float(least)


def siblings(model: ObjectModel) -> list[dict[str, str]]:
    """What else each marker, 'COMPONENT/MARKER', may be told as, for all looks the same after turns that exchange them:
    once for each such turn, and for those that follow on each other."""
    exchanged = [turn.places for turn in same_turns(model) if turn.places]
    every, names = list[dict[str, str]](), [c.name for c in model.components]
    left = [{name: name for name in names}]
    for known in left:  # grows
        for places in exchanged:
            other = {name: places.get(to, to) for name, to in known.items()}
            if other not in left:
                left.append(other)
    for known in left[1:]:
        pairs = ((model.component(a), model.component(b)) for a, b in known.items())
        every.append(  # what looks the same has as many markers, or solids' sides that go unnamed
            {
                f"{a.name}/{m.name}": f"{b.name}/{n.name}"
                for a, b in pairs
                for m, n in zip(a.markers, b.markers, strict=False)
            }
        )
    return every


def told_otherwise(o: TrueObject, names: Mapping[str, str]) -> TrueObject:
    """A true object with other names for its components. :param names: as of `siblings`."""
    components = {key.partition("/")[0]: to.partition("/")[0] for key, to in names.items()}

    def renamed(name: str) -> str:
        component, at, marker = name.partition("@")
        to = names.get(f"{component}/{marker}", components.get(component, component) + "/" + marker)
        return to.replace("/", "@") if at else components.get(component, component)

    return replace(
        o,
        components={renamed(name): c for name, c in o.components.items()},
        axes={names.get(name, name): axis for name, axis in o.axes.items()},
        undirected=frozenset(names.get(name, name) for name in o.undirected),
    )


AS_IT_IS = SameLooks(np.eye(3)[None], (frozenset(),), np.zeros((0, 3)), np.zeros(3))


def turned_alike(outcomes: Sequence[tuple[str, Outcome]]) -> Iterator[str]:
    """A line for each object of which many rotations are off so. :param outcomes: object name and outcome."""
    for name in dict.fromkeys(name for name, _ in outcomes):
        mine = [o for n, o in outcomes if n == name and o.turn_told_rad is not None]
        alike = sum(o.turned_alike for o in mine)
        if alike > _LEAST_SHARE * len(mine):
            off = [o.turn_told_rad or 0.0 for o in mine]
            yield (
                f"'{name}' looks the same after some turns (artrec model says which): {alike} of {len(off)} "
                f"rotations are off by such a one, which no picture tells; errors of poses are those from the nearest "
                f"(from the truth as it is: {np.degrees(np.median(off)):.2f} deg in the median), joints count as told"
            )


def _all_of(turns: Sequence[SameTurn]) -> tuple[Array, list[frozenset[str]]]:
    """(k, 3, 3) rotations by none of them, by each as often as it can be done, and by two; and what each bends."""
    single = [
        (rotation_from_rotvec(k * turn.angle_rad * turn.axis), frozenset(turn.bent))
        for turn in turns
        for k in range(1, round(2 * np.pi / turn.angle_rad))
    ]
    double = [(a @ b, bent | more) for a, bent in single for b, more in single]
    every = [(np.eye(3), frozenset[str]()), *single, *double]
    return np.array([R for R, _ in every]), [bent for _, bent in every]
