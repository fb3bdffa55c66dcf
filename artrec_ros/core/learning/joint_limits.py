"""A joint's limits once lengths are measured anew: what they allowed beside the marked poses stays allowed.

Where an axis or a marker on it moves, the same picture has another value. How a component is turned at its joint's
zero marks hardly tell, so values may drift, all alike, out of limits that were laid about them. Where marked values
come near to a limit, or beyond it, and did not before, the zero is laid where they are as they were, in the median;
what limits then still lack of the room that they left is added. Elsewhere zero and limits stay as they are: limits
may be those of a mechanism, and the zero that lengths give is the likeliest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, Pose, rotation_from_rotvec, short_way
from ..model.kinematics import Kinematics
from ..model.objects import Component, Joint, ObjectModel

_LEAST_ROOM = 0.5  # of what limits left beyond marked values; with less they were laid about other values
_TOLD = 0.1  # of a joint's unit: values of a larger deviation tell nothing of its limits
_NOISE = 2.0  # deviations of a marked value: what moves by less has not moved


class JointValues(NamedTuple):
    """:param q: (n, J) values of joints in n images, radians or metres. :param deviation: (n, J) theirs; infinite where
    no mark, or a mistaken one, tells a value."""

    q: Array
    deviation: Array


@dataclass(frozen=True)
class LimitChange:
    """A joint whose zero or limits change.

    :param zero: by how much it turns or slides along its axis; radians or metres, as limits.
    :param old, new: lower and upper limit. :param shown_by: place of the image that needs the lower one, and the upper
        one; '' where it stays.
    """

    name: str
    kind: str
    zero: float
    old: tuple[float, float]
    new: tuple[float, float]
    shown_by: tuple[str, str]


@dataclass(frozen=True)
class Carried:
    """(J,) each joint's new zero, beside the old one, and its limits beside that; (2, J) the image that needs the lower
    and the upper one, -1 where it stays."""

    zero: Array
    lower: Array
    upper: Array
    shown_by: Array

    @classmethod
    def as_is(cls, kin: Kinematics) -> Carried:
        return cls(np.zeros(kin.n_joints), kin.lower, kin.upper, np.full((2, kin.n_joints), -1))

    def too_wide(self, kin: Kinematics) -> NDArray[np.bool_]:
        """(J,) joints that turn whose limits grew beyond a whole turn, and so tell nothing."""
        return np.asarray(
            kin.revolute & ~kin.endless & (self.shown_by >= 0).any(axis=0) & (self.upper - self.lower >= 2 * np.pi)
        )

    def without(self, joints: NDArray[np.bool_], kin: Kinematics) -> Carried:
        """The same with some joints (J,) as they were."""
        old = Carried.as_is(kin)
        pairs = ((getattr(old, f.name), getattr(self, f.name)) for f in fields(self))
        return Carried(*(np.where(joints, before, after) for before, after in pairs))

    def bounds(self, kin: Kinematics) -> Array:
        """(2, J) least and greatest value beside the old zero; of joints that turn without limit none."""
        least, greatest = self.zero + self.lower, self.zero + self.upper
        return np.where(kin.endless, [[-np.inf], [np.inf]], [least, np.maximum(greatest, np.nextafter(least, np.inf))])

    def model(self, model: ObjectModel) -> ObjectModel:
        """The object with these joints."""
        names = [c.name for c in model.joint_components]
        parts = [self._component(c, names.index(c.name)) if c.name in names else c for c in model.components]
        return replace(model, components=tuple(parts))

    def _component(self, component: Component, j: int) -> Component:
        assert component.joint is not None
        joint = _with_zero(component.joint, float(self.zero[j]))
        if (self.shown_by[:, j] >= 0).any():
            joint = replace(joint, lower=float(self.lower[j]), upper=float(self.upper[j]))
        return replace(component, joint=joint)

    def changes(self, model: ObjectModel, places: Sequence[str]) -> Iterator[LimitChange]:
        """Joints that have another zero or other limits. :param model: the object before. :param places: of images."""
        for j, (name, joint) in enumerate(model.joints.items()):
            shown_by = self.shown_by[:, j].tolist()
            if self.zero[j] or max(shown_by) >= 0:
                new = (float(self.lower[j]), float(self.upper[j])) if max(shown_by) >= 0 else (joint.lower, joint.upper)
                first, second = (places[n] if n >= 0 else "" for n in shown_by)
                old = (joint.lower, joint.upper)
                yield LimitChange(name, joint.kind, float(self.zero[j]), old, new, (first, second))


def carried(kin: Kinematics, before: JointValues, after: JointValues) -> Carried:
    """Joints' zeros and limits by values in the same images, with lengths as they were and as they are measured."""
    told_before, told = (v.deviation <= _TOLD * kin.unit for v in (before, after))
    old = kin.middle + short_way(before.q - kin.middle, kin.revolute)
    new = old + short_way(after.q - before.q, kin.revolute)
    old, new = np.where(told & told_before, old, np.nan), np.where(told, new, np.nan)
    noise = _NOISE * _median(np.where(told, after.deviation, np.nan))
    common = noise / np.sqrt(np.maximum(1, told.sum(axis=0)))  # of what moves all values alike
    squeezed = ~kin.endless & _squeezed(kin, old, new, noise, common)
    moved = _median(new - old)
    back = squeezed & (np.abs(moved) > common) & (_least_room(kin, new - moved) > _least_room(kin, new))
    zero = np.where(back, moved, 0.0)
    needs = np.where(squeezed, new - zero, np.nan)
    lower, below = _kept(kin.lower, old, needs, common)
    upper, above = _kept(-kin.upper, -old, -needs, common)
    return Carried(zero, lower, -upper, np.stack([below, above]))


def _squeezed(kin: Kinematics, old: Array, new: Array, noise: Array, common: Array) -> NDArray[np.bool_]:
    """(J,) whether limits hold values (n, J) worse than they held the old ones, or do not hold them.

    :param noise, common: (J,) of one value, and of what moves all alike.
    """
    left, had = _least_room(kin, new), _least_room(kin, old)
    worse = np.where(np.isfinite(had), left < had - common, False)
    tight = left < np.minimum(_LEAST_ROOM * np.maximum(0.0, had), _next_beyond(new))
    return np.asarray((worse & tight) | (left < -noise))


def _least_room(kin: Kinematics, values: Array) -> Array:
    """(J,) from values (n, J) to the nearest limit, below 0 beyond it; infinite where none is told."""
    return np.minimum(_least(values) - kin.lower, kin.upper + _least(-values))


def _next_beyond(values: Array) -> Array:
    """(J,) how far beyond evenly spread values (n, J) the next one may well lie: one share of their range."""
    shares = np.maximum(1, np.sum(~np.isnan(values), axis=0) - 1)
    extent = -_least(-values) - _least(values)
    return np.where(np.isfinite(extent), extent, 0.0) / shares


def _kept(limit: Array, old: Array, new: Array, noise: Array) -> tuple[Array, Array]:
    """(J,) lower limits that leave as much room as before, and the image that needs each, -1 where it stays.

    :param old, new: (n, J) values; NaN where none is told.
    """
    room = np.maximum(0.0, _least(old) - limit)
    needed = _least(new) - np.where(np.isfinite(room), room, 0.0)
    moves = needed < limit - noise
    first = np.argmin(np.where(np.isnan(new), np.inf, new), axis=0)
    return np.where(moves, needed, limit), np.where(moves, first, -1)


def _least(values: Array) -> Array:
    """(J,) of each column; infinite where it has none."""
    return np.asarray(np.min(np.where(np.isnan(values), np.inf, values), axis=0, initial=np.inf))


def _median(values: Array) -> Array:
    """(J,) of each column; 0 where it has none."""
    none = np.isnan(values).all(axis=0)
    return np.asarray(np.nanmedian(np.where(none, 0.0, values), axis=0))


def _with_zero(joint: Joint, zero: float) -> Joint:
    """Its values 0 where they were `zero`."""
    if not zero:
        return joint
    along = zero * joint.axis
    turns = joint.kind == "revolute"
    moved = Pose(rotation_from_rotvec(along), np.zeros(3)) if turns else Pose(np.eye(3), along)
    return replace(joint, T_parent_joint=joint.T_parent_joint @ moved)
