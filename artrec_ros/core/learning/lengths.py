"""What may be measured of an object: sizes of its markers, where they lie on its components, where its joints sit."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..geometry.transforms import Array, Pose, rotation_from_rotvec
from ..model.marker import Marker
from ..model.objects import Box, Component, ObjectModel
from ..pose.poses import Poses
from .marked_views import Figure, axis_ends, markers_of

# What an object file may be off, standard deviations: lengths, a share of the object's extent; a marker's size, and its
# direction, radians. Wide: a dozen marked objects outweigh it.
_PLACE, _SIZE, _TURN = 0.05, 0.1, 0.1


@dataclass(frozen=True)
class Change:
    """What is measured of a marker: times its size, its shift (3,) in its component's frame, its turn, and the shift
    (3,) of its component's joint in the parent's; metres and radians."""

    component: str
    marker: str
    size: float
    shift: Array
    turn: float
    joint_shift: Array


class _Parts(NamedTuple):
    """(m,) times each marker's size, (m, 3) its shift in its own frame, (m,) its turn; (C, 3) shifts of joints."""

    size: Array
    shift: Array
    turn: Array
    joint_shift: Array


class Lengths:
    """Numbers in units of their standard deviations: at 0, `none`, the object is as its file has it.

    Of each shape but the required component's first one a size; of each marker but that one a shift and a turn; of each
    joint a shift. A flat object stays flat.

    :ivar extent_m: the object's diagonal. :ivar names: component and marker of each marker.
    :ivar components: (m,) number of its component. :ivar discs: (m,) which are discs.
    """

    def __init__(self, model: ObjectModel, staying: Collection[str] = ()) -> None:
        """:param staying: components whose joints stay where they are."""
        self._model, self._figure, self._known = model, Figure.of(model), markers_of(model)
        root, shapes = model.components.index(model.required), [_shape(m) for _, m, _ in self._known]
        stays = next(n for n, (c, _, _) in enumerate(self._known) if c == root)
        free = [s for s in dict.fromkeys(shapes) if s != shapes[stays]]
        self._size_of = np.array([free.index(s) if s in free else len(free) for s in shapes])  # the last one stays
        self._movable = np.array([n for n in range(len(self._known)) if n != stays], np.int64)
        jointed = [(c, part.joint) for c, part in enumerate(model.components) if part.joint is not None]
        self._joints = [(c, joint.parent) for c, joint in jointed if model.components[c].name not in staying]
        # directions of shifts: of a marker in its own frame, of a joint in that of its parent's first marker
        self._directions = np.eye(3)[: 2 if model.is_flat else 3]
        self._first_of = {model.components[c].name: T for c, _, T in reversed(self._known)}
        self._splits = np.cumsum([len(free), len(self._movable) * len(self._directions), len(self._movable)])
        self.none = np.zeros(self._splits[-1] + len(self._joints) * len(self._directions))
        self.extent_m = self._extent_m()
        self._place_m = _PLACE * self.extent_m
        self.names = [(model.components[c].name, m.name) for c, m, _ in self._known]
        self.components = self._figure.component
        self.discs = np.array([m.disc_radius is not None for _, m, _ in self._known])

    def _extent_m(self) -> float:
        """Diagonal of all axes' ends, joints at 0."""
        at_rest = Poses(np.eye(3)[None], np.zeros((1, 3)), np.zeros((1, len(self._model.joint_components))))
        return float(np.linalg.norm(np.ptp(self._figure.ends(at_rest).reshape(-1, 3), axis=0)))

    def _parts(self, values: Array) -> _Parts:
        m, components = len(self._known), len(self._model.components)
        size, shift, turn, joint = np.split(values, self._splits)
        sizes = np.exp(_SIZE * np.append(size, 0.0))[self._size_of]
        out = _Parts(sizes, np.zeros((m, 3)), np.zeros(m), np.zeros((components, 3)))
        out.shift[self._movable] = self._shifts(shift)
        out.turn[self._movable] = _TURN * turn
        for (c, parent), along in zip(self._joints, self._shifts(joint), strict=True):
            out.joint_shift[c] = self._first_of[parent].rotation @ along
        return out

    def joints(self, values: Array) -> dict[str, Array]:
        """How far each joint that may move does, in its deviations by the object file; by its component's name."""
        shifts = np.split(values, self._splits)[-1].reshape(-1, len(self._directions))
        return {self._model.components[c].name: shift for (c, _), shift in zip(self._joints, shifts, strict=True)}

    def apart(self, off: Array) -> float:
        """What a joint's shift is of the object's extent. :param off: as of `joints`."""
        return float(np.linalg.norm(off) * self._place_m / self.extent_m)

    def _shifts(self, values: Array) -> Array:
        """(n, 3) metres."""
        return np.asarray(self._place_m * values.reshape(-1, len(self._directions)) @ self._directions)

    def figure(self, values: Array) -> Figure:
        """The object's axes with these."""
        parts = self._parts(values)
        places = [
            _moved(T, turn, shift).apply(size * axis_ends(marker))
            for (_, marker, T), size, shift, turn in zip(self._known, parts.size, parts.shift, parts.turn, strict=True)
        ]
        return self._figure.with_lengths(parts.joint_shift, np.array(places))

    def model_of(self, values: Array) -> ObjectModel:
        """The object with these."""
        parts, known = self._parts(values), iter(range(len(self._known)))
        components = []
        for component, shift in zip(self._model.components, parts.joint_shift, strict=True):
            markers = tuple(self._marker(next(known), parts) for _ in component.markers)
            bodies = _along(component, markers)
            components.append(replace(_with_joint(component, shift), markers=markers, bodies=bodies))
        return replace(self._model, components=tuple(components))

    def _marker(self, n: int, parts: _Parts) -> Marker:
        (_, marker, T), size = self._known[n], float(parts.size[n])
        radius = None if marker.disc_radius is None else size * marker.disc_radius
        sized = replace(marker, outline=size * marker.outline, tail=size * marker.tail, head=size * marker.head)
        return replace(sized, disc_radius=radius, T_component_marker=_moved(T, parts.turn[n], parts.shift[n]))

    def changes(self, values: Array) -> Iterator[Change]:
        """Of each marker but the one that stays."""
        parts = self._parts(values)
        for n in self._movable.tolist():
            (c, _, T), (component, marker) = self._known[n], self.names[n]
            shift, size, turn = T.rotation @ parts.shift[n], float(parts.size[n]), float(parts.turn[n])
            yield Change(component, marker, size, shift, turn, parts.joint_shift[c])


def _with_joint(component: Component, shift: Array) -> Component:
    if component.joint is None:
        return component
    T = component.joint.T_parent_joint
    return replace(component, joint=replace(component.joint, T_parent_joint=Pose(T.rotation, T.position + shift)))


def _along(component: Component, markers: Sequence[Marker]) -> tuple[Box, ...]:
    """A component's bodies, moved as its markers are in the mean: these must not come to lie within them."""
    pairs = zip(component.markers, markers, strict=True)
    shift = np.mean([new.centre - old.centre for old, new in pairs], axis=0)
    moved = Pose(np.eye(3), shift)
    return tuple(replace(box, T_component_box=moved @ box.T_component_box) for box in component.bodies)


def _moved(T: Pose, turn: float, shift: Array) -> Pose:
    """A marker's place, turned and shifted in its own frame."""
    return T @ Pose(rotation_from_rotvec([0.0, 0.0, turn]), shift)


def _shape(marker: Marker) -> tuple[float, float, float]:
    """The same of equal and of mirrored markers: these are of one size."""
    axis = marker.axis_length
    return round(marker.area, 9), round(marker.perimeter, 6), round(axis, 6)
