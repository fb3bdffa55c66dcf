"""Poses in which an object looks much like itself: its required component put where another of its kind is.

Of squares in rows a pose moved by a pitch, or turned by a quarter, covers most of them. What is said of a pose is
worth no more than what is known of these rivals: they are few, known ahead, and cost votes alone.
"""

from __future__ import annotations

from copy import copy
from functools import lru_cache

import numpy as np

from ..geometry.polygons import distance_to_outline
from ..geometry.transforms import Pose, rotation_from_rotvec
from ..model.marker import Marker
from ..model.same_turns import Looks
from ..model.surface import sample_contour
from .layout import NEAR, Layout, Placed, moves_onto, placed_markers
from .poses import Poses
from .surface_model import SpatialModel

_TURNS = 2 * np.pi * np.arange(144) / 144  # that are looked at: 2.5 degrees apart
_SAMPLES = 48  # of an outline
_ALIKE = 0.08  # outlines that differ by less are taken for one another: rms, as a share of the root of their area
ALIKE_TURN = 0.05  # radians, a step of these: turns that differ by less are one
_ROUND = 9  # turns that lay a marker onto itself: of one that has so many an outline tells no turn at all
_SHARE = 1 / 3  # of a rigid object's markers that a lookalike must have where it has some; others are no rivals


class Lookalikes:
    """One object's: poses with one of the required component's markers where the pose has one of the same class and
    outline, of any component, in each of the turns in which the two look the same; joints as they are."""

    def __init__(self, surface: SpatialModel, *, in_place: bool = False, unlike: bool = False) -> None:
        """:param in_place: only those that turn the required component's markers onto themselves, whatever else comes
        of it: its outline tells nothing of them. :param unlike: but those that leave all of the object as it looks."""
        self._kin, self._root = surface.kinematics, surface.root
        found, self._led = (_turned_in_place(surface), set[int]()) if in_place else _placements(surface)
        if unlike and found:
            found = _unlike(surface, found)
        self._on = np.array([c for c, _ in found], int)  # the required component's frame, and on which one it is
        self._R = np.array([T.rotation for _, T in found]).reshape(-1, 3, 3)
        self._t = np.array([T.position for _, T in found]).reshape(-1, 3)

    def __len__(self) -> int:
        return len(self._on)

    def on_others(self) -> Lookalikes:
        """Those that put the required component on another one."""
        some, rows = copy(self), np.flatnonzero(self._on != self._root)
        some._on, some._R, some._t = self._on[rows], self._R[rows], self._t[rows]
        return some

    def leads_to(self, component: int) -> bool:
        """Whether the required component lies on this one in some lookalike of a rigid object, or in one that looks the
        same throughout: from a pose that takes its blob for the required component's one comes to the right one."""
        return component in self._led

    def of(self, poses: Poses) -> Poses:
        """(H * K) poses, those of the first one first."""
        frames = self._kin.forward(poses.R, poses.t, poses.q)
        R_root, t_root = frames.R[:, self._root], frames.t[:, self._root]
        R_object = R_root.transpose(0, 2, 1) @ poses.R  # the object's frame in the required component's
        t_object = np.einsum("hji,hj->hi", R_root, poses.t - t_root)
        R_there = frames.R[:, self._on] @ self._R  # (H, K, 3, 3)
        t_there = np.einsum("hkij,kj->hki", frames.R[:, self._on], self._t) + frames.t[:, self._on]
        R = R_there @ R_object[:, None]
        t = np.einsum("hkij,hj->hki", R_there, t_object) + t_there
        return Poses(R.reshape(-1, 3, 3), t.reshape(-1, 3), np.repeat(poses.q, len(self), axis=0))


def _placements(surface: SpatialModel) -> tuple[list[tuple[int, Pose]], set[int]]:
    """The required component's frame where a lookalike has it, in the frame of a component, those that have most in
    common first; and the components that a rigid object's lead to. Of these poses those that have little in common are
    no rivals, but where a marker lies on itself: of what its own outline does not tell all else must be asked. Those
    that have all, those of other classes too, are the same to the eye."""
    every = placed_markers(surface)
    markers = _of_the_required_class(surface, every)
    roots = [m for m in markers if m.component == surface.root]
    pairs = [(mine, there) for mine in roots for there in markers]
    if surface.kinematics.n_joints:  # which of its own sides is seen all else tells
        elsewhere = [(mine, there) for mine, there in pairs if there.component != surface.root]
        on_them = [
            (there.component, there.inside @ _turned(turn) @ mine.inside.inverse())
            for mine, there in elsewhere
            for turn in turns_on(mine, there, markers)
        ]
        return on_them + _turned_in_place(surface), set()
    least = max(2.0, _SHARE * len(markers))
    out: dict[tuple[float, ...], tuple[int, int, Pose]] = {}
    led, own = {surface.root}, Layout(markers)
    whole = own if len(markers) == len(every) else Layout(every)
    for mine, there in pairs:
        if not (turns := turns_on(mine, there, markers)):
            continue
        R, t = moves_onto(mine, there, turns)
        covered = own.alike(R, t).any(axis=2).sum(axis=1)
        covered_of_all = covered if whole is own else whole.alike(R, t).any(axis=2).sum(axis=1)
        if (covered >= least).any():
            led.add(there.component)
        in_place = there is mine and len(_own_turns(mine.marker)) > 0
        rival = (in_place | (covered >= least)) & ((covered < len(markers)) | (covered_of_all < len(every)))
        for n in np.flatnonzero(rival).tolist():
            T = there.inside @ _turned(turns[n]) @ mine.inside.inverse()
            out.setdefault(_key(Pose(R[n], t[n]), mine.marker), (int(covered[n]), there.component, T))
    return [(c, T) for _, c, T in sorted(out.values(), key=lambda o: -o[0])], led


def _turned_in_place(surface: SpatialModel) -> list[tuple[int, Pose]]:
    """As of `_placements`; each turn of the object once. Of a ball, which looks the same in any, there are none."""
    if surface.root in surface.sides.balls:
        return []
    out: dict[tuple[float, ...], Pose] = {}
    for m in (m for m in placed_markers(surface) if m.component == surface.root):
        for turn in _own_turns(m.marker):
            T = _turned(turn)
            out.setdefault(_key(m.whole @ T @ m.whole.inverse(), m.marker), m.inside @ T @ m.inside.inverse())
    return [(surface.root, T) for T in out.values()]


def _unlike(surface: SpatialModel, found: list[tuple[int, Pose]]) -> list[tuple[int, Pose]]:
    """Those of the turns of the required component after which something looks otherwise."""
    looks = Looks(surface.model)
    return [(c, T) for c, T in found if not looks.same_after(T)]


def _own_turns(marker: Marker) -> list[float]:
    """Those that lay a marker onto itself; of one that is round, be it drawn as a disc or not, none: it looks the same
    in any turn. What is alike in one turn and not in the one back, as a T askew, only resembles itself."""
    own = turns_onto_itself(marker)
    return own if len(own) < _ROUND else []


def turns_onto_itself(marker: Marker) -> list[float]:
    """The same of what is nearly round, too; of discs none."""
    if marker.disc_radius:
        return []
    turns = np.array([turn for turn in turns_alike(marker, marker) if np.cos(turn) < 1 - 1e-6])
    back = np.cos(turns[:, None] + turns) > np.cos(1.5 * _TURNS[1])
    return turns[back.any(axis=1)].tolist()


def _key(moved: Pose, marker: Marker) -> tuple[float, ...]:
    """The same of poses that are alike to a twentieth of a marker's size."""
    return tuple(np.rint(np.append(moved.rotation[:, :2].ravel(), moved.position / marker.area**0.5) * 20))


def _of_the_required_class(surface: SpatialModel, markers: list[Placed]) -> list[Placed]:
    return [m for m in markers if m.labels == surface.labels[surface.root]]


def turns_on(mine: Placed, there: Placed, markers: list[Placed]) -> list[float]:
    """How a marker may be turned in the place of one of its class. :param markers: beside which they lie."""
    both = mine.marker, there.marker
    discs = all(m.disc_radius for m in both) and _same_size(*both)
    turns = _turns_of_discs(mine, there, markers) if discs else turns_alike(*both)
    return [turn for turn in turns if there is not mine or np.cos(turn) < 1 - 1e-6]


def _turned(angle: float) -> Pose:
    """A marker in its own frame."""
    return Pose(rotation_from_rotvec([0.0, 0.0, angle]), np.zeros(3))


def _turns_of_discs(mine: Placed, there: Placed, markers: list[Placed]) -> list[float]:
    """Turns of a disc on another one that bring some other marker's centre to another one's; of several that differ by
    less than a tenth that which brings most, for a pose that is a degree off is no rival of one that fits."""
    polar = []
    for at in (mine, there):
        others = np.array([m.whole.position for m in markers if m is not at]).reshape(-1, 3)
        polar.append(at.whole.inverse().apply(others)[:, :2] @ np.array([1, 1j]))
    first, second = polar[0], polar[1][:, None]
    same = np.abs(np.abs(second) - np.abs(first)) < NEAR * mine.marker.area**0.5
    turns = np.angle((second * first.conj())[same])
    cells, cell, count = np.unique(np.rint(100 * turns), return_inverse=True, return_counts=True)
    mean = np.bincount(cell, turns, len(cells)) / count
    best = {round(float(mean[n]), 1): float(mean[n]) for n in np.argsort(count, kind="stable").tolist()}
    return sorted(best.values())


def turns_alike(mine: Marker, there: Marker) -> list[float]:
    """Turns of one marker in which it looks like another."""
    if not _same_size(mine, there):
        return []
    both = ((m.outline - m.centroid).round(9).tobytes() for m in (mine, there))
    return list(_turns_alike(*both, there.area**0.5))


@lru_cache(maxsize=4096)
def _turns_alike(mine: bytes, there: bytes, size: float) -> tuple[float, ...]:
    """Of outlines about their middles: many markers of an object are the same, and several ask for each pair.

    :param size: the root of the other one's area.
    """
    outline = np.frombuffer(there).reshape(-1, 2)
    points = sample_contour(np.frombuffer(mine).reshape(-1, 2), _SAMPLES)[0] @ np.array([1, 1j])
    turned = np.exp(1j * _TURNS)[:, None] * points
    flat = np.column_stack([turned.real.ravel(), turned.imag.ravel()])
    off = np.sqrt(np.mean(distance_to_outline(flat, outline).reshape(turned.shape) ** 2, axis=1)) / size
    lowest = (off <= np.roll(off, 1)) & (off < np.roll(off, -1)) & (off < _ALIKE)
    return tuple(_TURNS[lowest].tolist())


def _same_size(a: Marker, b: Marker) -> bool:
    return abs(float(np.log(a.area / b.area))) < 2 * _ALIKE
