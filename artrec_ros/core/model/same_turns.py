"""Turns after which a whole object looks the same, whatever its joints do: no picture tells how it lies.

What a turn brings where other components of the same looks are, or could be bent to, looks as it did. The object's
components are laid on each other in their tree's order, at a few values of all joints; each joint goes to where its
component's markers fall on those of another, or on its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from ..geometry.polygons import distance_to_outline, in_space
from ..geometry.transforms import Array, Pose, rotation_from_rotvec
from .kinematics import Kinematics
from .marker import Marker
from .objects import Component, Joint, ObjectModel
from .surface import MEETING

_ORDERS = 12, 8, 6, 5, 4, 3, 2  # turns by a whole one over these are looked at
_ONE_WAY = 0.95  # cosine: normals that are the same
_ALIKE = 0.1  # logarithm of sizes that differ by less are the same
_NEAR = 6.0  # times what nobody sees: between two steps of a joint
_STEP_RAD = 0.1  # of joints; of what slides, as much of its size
ROUND_RAD = np.radians(31)  # what looks the same after so small a turn does after any other, too
_MOST_TRIED = 8_000  # placements: what takes more, as many like parts on one axle, is not called the same
_NOWHERE = 1e9  # a misfit that is a number, and none
_LOOKS, _SEED = 3, 4  # values of all joints that must agree
_WITHIN = 0.8  # of joints' limits: beyond, the turned one's own could stand in the way


class SameTurn(NamedTuple):
    """A turn about an axis.

    :param axis: (3,) a unit vector of the object's frame. :param through: (3,) a point on it, metres.
    :param angle_rad: the smallest turn.
    :param places: components that lie where others did. :param bent: those whose joints are bent otherwise.
    """

    axis: Array
    through: Array
    angle_rad: float
    places: Mapping[str, str]
    bent: Sequence[str]

    @property
    def is_round(self) -> bool:
        """Whether it is so small that others between them look the same, too."""
        return self.angle_rad < ROUND_RAD


def same_turns(model: ObjectModel) -> list[SameTurn]:
    """One for each axis about which there are some; of an object whose markers have places."""
    if not model.is_spatial:
        return []
    looks, found = Looks(model), list[SameTurn]()
    for axis in looks.axes():
        turns = (looks.after(axis, 2 * np.pi / order) for order in _ORDERS)
        found += [turn for turn in turns if turn is not None][:1]
    return found


class _TooManyError(Exception):
    """More placements than are tried."""


class _Piece(NamedTuple):
    """A marker, or a body of known class, in its component's frame: its outline or corners, and which way it faces."""

    labels: tuple[int | str, ...]
    outline: Array
    normal: Array
    off_m: float  # that nobody sees


class Looks:
    """A spatial model at some values of its joints."""

    def __init__(self, model: ObjectModel) -> None:
        self._model, self._kin = model, Kinematics(model)
        self._parts = model.components
        self._index = {c.name: n for n, c in enumerate(self._parts)}
        self._pieces = [[_ball(c, c.ball)] if c.ball is not None else [*_pieces(c)] for c in self._parts]
        self._middles = [np.mean([p.outline.mean(axis=0) for p in pieces], axis=0) for pieces in self._pieces]
        self._off_m = [max(p.off_m for p in pieces) for pieces in self._pieces]
        kinds = [sorted((str(p.labels), round(np.log(p.off_m) / _ALIKE)) for p in pieces) for pieces in self._pieces]
        self._alike = [[m for m, kind in enumerate(kinds) if _same_kind(kind, own)] for own in kinds]
        # parents come first, and of the rest what could lie in fewest places
        depths = [self._depth(n) for n in range(len(self._parts))]
        self._order = sorted(range(len(self._parts)), key=lambda n: (depths[n], len(self._alike[n])))
        self._tried = 0
        rng = np.random.default_rng(_SEED)
        low, high = self._kin.lower, self._kin.upper
        q = (low + high) / 2 + _WITHIN * (rng.random((_LOOKS, len(low))) - 0.5) * (high - low)
        frames = self._kin.in_object(q)
        self._looks = [[Pose(R, t) for R, t in zip(*at, strict=True)] for at in zip(frames.R, frames.t, strict=True)]
        self._values = [dict(zip(model.joint_names, row, strict=True)) for row in q.tolist()]
        rigid = [n for n, c in enumerate(self._parts) if not self._kin.moves[n].any()]
        middles = [self._looks[0][n].apply(p.outline).mean(axis=0) for n in rigid for p in self._pieces[n]]
        self._middle = np.mean(middles, axis=0)

    def axes(self) -> Iterator[Array]:
        """Those of the object's frame, and those along which markers of the required component face."""
        n = self._index[self._model.required.name]
        known = list[Array]()
        for axis in (*np.eye(3), *(self._looks[0][n].rotation @ p.normal for p in self._pieces[n])):
            if np.any(axis) and not any(abs(axis @ other) > _ONE_WAY for other in known):
                known.append(axis)
                yield axis

    def after(self, axis: Array, angle_rad: float) -> SameTurn | None:
        """A turn about an axis through the middle of what no joint moves, if all looks the same after it."""
        R = rotation_from_rotvec(angle_rad * axis)
        laid = self._after([Pose(R, self._middle - R @ self._middle)] * _LOOKS)
        return None if laid is None else SameTurn(axis, self._middle, angle_rad, *laid)

    def same_after(self, turn: Pose) -> bool:
        """Whether all looks the same after a turn in the required component's frame."""
        root = self._index[self._model.required.name]
        return self._after([own[root] @ turn @ own[root].inverse() for own in self._looks]) is not None

    def _after(self, turns: Sequence[Pose]) -> tuple[dict[str, str], list[str]] | None:
        """See `SameTurn`; None: something looks otherwise. :param turns: in the object's frame, of each look."""
        places, bent, names = dict[str, str](), set[str](), [c.name for c in self._parts]
        self._tried = 0
        try:
            for own, values, turn in zip(self._looks, self._values, turns, strict=True):
                laid = self._laid(0, own, turn, {}, {}, {})
                if laid is None:
                    return None
                images, joints = laid
                places |= {names[n]: names[m] for n, m in images.items() if n != m}
                bent |= {name for name, value in joints.items() if abs(value - values[name]) > _STEP_RAD / 2}
        except _TooManyError:
            return None
        return places, sorted(bent)

    def _depth(self, n: int) -> int:
        """How many components carry one."""
        joint = self._parts[n].joint
        return 0 if joint is None else 1 + self._depth(self._index[joint.parent])

    def _laid(
        self,
        k: int,
        own: Sequence[Pose],
        turn: Pose,
        images: dict[int, int],
        frames: dict[int, Pose],
        joints: dict[str, float],
    ) -> tuple[dict[int, int], dict[str, float]] | None:
        """Components from the `k`-th in order on laid on others; None: somewhere is none like one.

        :param own: where components are. :param images: on which one each of the first lies.
        :param frames: of these. :param joints: values at which they lie there.
        """
        if k == len(self._order):
            return images, joints
        n = self._order[k]
        for m in self._alike[n]:
            if m in frames:
                continue
            for frame, joint in self._where(n, turn @ own[n], m, frames):
                laid = self._laid(k + 1, own, turn, {**images, n: m}, {**frames, m: frame}, {**joints, **joint})
                if laid is not None:
                    return laid
        return None

    def _where(self, n: int, at: Pose, m: int, frames: Mapping[int, Pose]) -> Iterator[tuple[Pose, dict[str, float]]]:
        """Frames of component `m` in which it looks as `n` does at a pose, and its joint's value there."""
        part = self._parts[m]
        joint = part.joint
        if joint is None or joint.kind == "fixed":
            parent = None if joint is None else frames.get(self._index[joint.parent])
            if joint is not None and parent is None:
                return
            frame = Pose.identity() if joint is None or parent is None else parent @ joint.T_parent_joint
            if self._misfit(n, at, m, frame) <= 1:
                yield frame, {}
            return
        parent = frames.get(self._index[joint.parent])
        if parent is not None:
            base = parent @ joint.T_parent_joint
            for value in self._bent(n, at, m, base, joint):
                yield base @ _motion(joint, value), {joint.name or part.name: value}

    def _bent(self, n: int, at: Pose, m: int, base: Pose, joint: Joint) -> Iterator[float]:
        """Values of the joint of component `m` at which it looks as `n` does, the best first."""

        def misfit(value: float) -> float:
            return self._misfit(n, at, m, base @ _motion(joint, value))

        j = self._kin.joint_of[m]
        grid = self._kin.grid(j, self._step_rad(m, joint))
        off = np.array([misfit(value) for value in grid.tolist()])
        found = list[tuple[float, float]]()
        for k in np.flatnonzero(np.isfinite(off)).tolist():
            if off[k] <= off[max(k - 1, 0) : k + 2].min():
                ends = grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)]
                best = minimize_scalar(lambda x: min(misfit(x), _NOWHERE), bounds=ends, method="bounded")
                found.append(min((float(best.fun), float(best.x)), (float(off[k]), float(grid[k]))))
        return (value for worst, value in sorted(found) if worst <= 1)

    def _step_rad(self, m: int, joint: Joint) -> float:
        """Of the joint that carries a component: as far from it as that is, no step leads past where it would lie."""
        if joint.kind == "prismatic":
            return _STEP_RAD
        lever_m = float(np.linalg.norm(np.cross(joint.axis, self._middles[m])))
        return min(_STEP_RAD, _NEAR * self._off_m[m] / max(lever_m, 1e-9))

    def _misfit(self, n: int, at: Pose, m: int, frame: Pose) -> float:
        """How far component `n` at a pose is from component `m` in its frame, over what nobody sees; inf: they look
        otherwise, or are nowhere near."""
        self._tried += 1
        if self._tried > _MOST_TRIED:
            raise _TooManyError
        T, worst = frame.inverse() @ at, 0.0
        if np.linalg.norm(T.apply(self._middles[n]) - self._middles[m]) > _NEAR * self._off_m[m]:
            return np.inf
        for piece in self._pieces[n]:
            outline, normal = T.apply(piece.outline), T.rotation @ piece.normal
            worst = max(worst, min((_off(piece, outline, normal, p) for p in self._pieces[m]), default=np.inf))
            if np.isinf(worst):
                break
        return worst


def _same_kind(a: Sequence[tuple[str, int]], b: Sequence[tuple[str, int]]) -> bool:
    """Whether pieces have the same labels and about the same sizes."""
    return len(a) == len(b) and all(p[0] == q[0] and abs(p[1] - q[1]) <= 1 for p, q in zip(a, b, strict=True))


def _off(piece: _Piece, outline: Array, normal: Array, other: _Piece) -> float:
    if piece.labels != other.labels or np.any(piece.normal) != np.any(other.normal):
        return np.inf
    if np.any(normal) and normal @ other.normal < _ONE_WAY:
        return np.inf
    if not np.any(normal):  # corners of bodies
        apart = np.linalg.norm(outline[:, None] - other.outline, axis=2)
        return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()) / piece.off_m)
    there, back = distance_to_outline(outline, other.outline), distance_to_outline(other.outline, outline)
    return float(max(there.max(), back.max()) / piece.off_m)


def _ball(component: Component, ball: Marker) -> _Piece:
    """A place and a size."""
    labels = (component.name,) if component.classes else component.labels(0)
    return _Piece((*labels, "ball"), ball.centre[None], np.zeros(3), MEETING * float(np.sqrt(ball.area)))


def _pieces(component: Component) -> Iterator[_Piece]:
    labels = (component.name,) if component.classes else component.labels(0)  # which of several it has tells it apart
    for marker in component.markers:
        T = marker.T_component_marker
        assert T is not None  # the model is spatial
        outline = T.apply(in_space(marker.outline))
        yield _Piece(labels, outline, T.rotation[:, 2], MEETING * float(np.sqrt(marker.area)))
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    for box in component.bodies:
        if component.body_label is not None:
            at, off_m = box.T_component_box.apply(corners * box.size), MEETING * float(box.size.max())
            yield _Piece((component.body_label,), at, np.zeros(3), off_m)


def _motion(joint: Joint, value: float) -> Pose:
    if joint.kind == "prismatic":
        return Pose(np.eye(3), value * joint.axis)
    return Pose(rotation_from_rotvec(value * joint.axis), np.zeros(3))
