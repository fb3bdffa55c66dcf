"""Poses in which a rigid object shows another one of its like sides where one is seen.

Of plates on the left, the rear and the front that look the same none tells which one it is: what else is seen does. So
each is to be asked for in the others' places, by all of its marks together, whatever the required component's class is
and wherever it lies; and slanted the other way, for of a small plate that is not known either.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, Pose
from ..model.same_turns import ROUND_RAD
from .layout import Layout, Placed, moves_onto, placed_markers
from .lookalikes import turns_on
from .poses import Poses
from .required_place import mirrored_about
from .surface_model import SpatialModel

_IN_VIEW = 0.5  # cosine between markers' normals: what turns away by more is not seen with them for sure
_SAME_WAY = 0.9  # the same of a side that stays what it is
_SHARE = 0.5  # of the markers of a side, those that must lie on like ones: else what it shows tells which one it is
_ONE_TURN, _ONE_PLACE = 0.1, 0.25  # radians, and of a marker's size: moves that are nearer to one another are one


class _Side(NamedTuple):
    """What comes to lie where a like side is seen.

    :ivar moved: where the object then is, in its own frame. :ivar on: (M, M) which markers then lie on which of it now.
    :ivar normal, centre: (3,) of the side that is seen, in the object's frame.
    """

    moved: Pose
    on: NDArray[np.bool_]
    normal: Array
    centre: Array


class Others(NamedTuple):
    """H poses in which other sides lie where some are seen. :ivar of: (H,) whose each is. :ivar side: (H,) which."""

    poses: Poses
    of: NDArray[np.int64]
    side: NDArray[np.int64]


class LikeSides:
    """Those of one object; none of one that has joints."""

    def __init__(self, surface: SpatialModel) -> None:
        every = placed_markers(surface)
        found = [] if surface.kinematics.n_joints else list(_sides(every))
        self._component = np.array([m.component for m in every], int)
        self._on = np.array([s.on for s in found], bool).reshape(-1, *2 * self._component.shape)
        self._R = np.array([s.moved.rotation for s in found]).reshape(-1, 3, 3)
        self._t = np.array([s.moved.position for s in found]).reshape(-1, 3)
        self._normal, self._centre = (np.array([s[n] for s in found]).reshape(-1, 3) for n in (2, 3))

    def __len__(self) -> int:
        return len(self._on)

    def told_apart_by(self, seen: frozenset[int]) -> list[set[int]]:
        """Of an object of which some components are seen, for each side on which one of them is: which of them tell
        that it is no other one that is there."""
        out = []
        for on in np.asarray(self._on.any(axis=1)):
            lie, each = set(self._component[on].tolist()), set(self._component[~on].tolist())
            if lie & seen:
                out.append({c for c in seen if c not in lie or c in each})
        return out

    def seen_as(self, side: int, seen: frozenset[int]) -> set[int]:
        """What of the object lies where some components were seen, once another side does."""
        there = np.isin(self._component, list(seen))
        return set(self._component[self._on[side][:, there].any(axis=1)].tolist())

    def pairs(self, side: int, used: NDArray[np.bool_]) -> tuple[list[int], list[int]]:
        """Markers, and those of some in whose places they may be once another side is seen: where more than one side
        was, what lies beside the one that was taken is like another one, too. :param used: (M,) those that are seen."""
        there, here = list[int](), list[int]()
        for k in (side, *range(len(self))):
            new, old = (rows.tolist() for rows in np.nonzero(self._on[k] & used))
            if not (set(new) & set(there) or set(old) & set(here)):
                there, here = there + new, here + old
        return there, here

    def covered(self, side: int, used: NDArray[np.bool_]) -> int:
        """How many of some markers another side alone takes the places of."""
        return int((self._on[side] & used).any(axis=0).sum())

    def of(self, poses: Poses) -> Others:
        """Another side in the place of each that faces the camera, slanted as it is and the other way."""
        R, t = poses.R[:, None], poses.t[:, None]  # against K sides
        normal = (R @ self._normal[..., None])[..., 0]
        centre = (R @ self._centre[..., None])[..., 0] + t
        of, k = np.nonzero((normal * centre).sum(axis=-1) < 0)
        here = poses[of]
        slanted = mirrored_about(here, self._normal[k], self._centre[k])
        both, k = Poses.concatenate([here, slanted]), np.tile(k, 2)
        t = (both.R @ self._t[k][..., None])[..., 0] + both.t
        return Others(Poses(both.R @ self._R[k], t, both.q), np.tile(of, 2), k)


def _sides(every: list[Placed]) -> Iterator[_Side]:
    """Each move once."""
    normals = np.array([m.whole.rotation[:, 2] for m in every])
    centres = np.array([m.whole.position for m in every])
    kept, size, layout = np.zeros((0, 3, 4)), min(m.marker.area for m in every) ** 0.5, Layout(every)
    other_way = normals @ normals.T <= _SAME_WAY  # of a flat object none: there is nothing to try
    for mine, there in ((every[i], every[j]) for i, j in np.argwhere(other_way).tolist()):
        if mine.labels != there.labels or not (turns := turns_on(mine, there, every)):
            continue
        R, t = moves_onto(mine, there, turns)
        each = layout.alike(R, t)
        on: NDArray[np.bool_] = np.asarray(each.any(axis=1))
        same = on.all(axis=1)  # to the eye
        if same.sum() * ROUND_RAD > 2 * np.pi:  # as a cylinder: turned by less than one of its flat sides it does, too
            continue
        seen = normals @ there.whole.rotation[:, 2] > _IN_VIEW
        on_it = on & seen
        is_side = on_it.sum(axis=1) >= max(_SHARE * seen.sum(), min(2, seen.sum()))
        for n in np.flatnonzero(is_side & ~same).tolist():
            matrix = np.column_stack([R[n], t[n]])
            if _is_one_of(kept, matrix, size):
                continue
            kept = np.concatenate([kept, matrix[None]])
            normal = normals[on_it[n]].sum(axis=0)
            centre = centres[on_it[n]].mean(axis=0)
            yield _Side(Pose(R[n], t[n]), each[n], normal / np.linalg.norm(normal), centre)


def _is_one_of(kept: Array, moved: Array, size: float) -> bool:
    """:param kept: (K, 3, 4) moves. :param moved: (3, 4) another one."""
    off = kept - moved
    turned, shifted = np.linalg.norm(off[..., :3], axis=(1, 2)), np.linalg.norm(off[..., 3], axis=1)
    return bool(((turned < np.sqrt(2) * _ONE_TURN) & (shifted < _ONE_PLACE * size)).any())
