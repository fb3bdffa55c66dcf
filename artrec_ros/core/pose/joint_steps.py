"""Other values of joints that carry like markers: moved on so, some of these lie where others do.

A wheel of four like spokes of which one is marked looks almost the same after a quarter turn, and a rod of like men
one place on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, rotation_from_rotvec, short_way
from .exchanges import OFF, may_be_taken_for
from .poses import Poses
from .surface_model import SpatialModel

_FACES = 0.5  # cosine between the ways that like markers face: of one on a limb's other side nothing is seen here


class Steps(NamedTuple):
    """By how much a joint is moved on for like markers to lie on each other.

    :ivar markers: (m,) those that it alone carries, among all markers. :ivar by: (K,) radians or metres.
    :ivar on: (K, m, m) bool: which of them then lies where which other one does.
    :ivar stays: (K, m) bool: which of them stays where it is, as a hub does.
    """

    markers: NDArray[np.int64]
    by: Array
    on: NDArray[np.bool_]
    stays: NDArray[np.bool_]

    @property
    def taken(self) -> NDArray[np.bool_]:
        """(K, m) whether something is where each marker was."""
        return np.asarray(self.on.any(axis=1) | self.stays)

    @property
    def lies(self) -> NDArray[np.bool_]:
        """(K, m) whether each marker is where something was."""
        return np.asarray(self.on.any(axis=2) | self.stays)


class JointSteps:
    """Those of one object. :ivar of: by the joints that have some."""

    def __init__(self, surface: SpatialModel) -> None:
        self._kin, self._component = surface.kinematics, surface.component[surface.markers]
        found = {j: _steps(surface, j) for j in range(self._kin.n_joints)}
        self.of = {j: steps for j, steps in found.items() if len(steps.by)}

    def others(self, pose: Poses, j: int, rows: NDArray[np.int64]) -> tuple[Poses, NDArray[np.int64]]:
        """One hypothesis with a joint moved on by some of its steps, as far as its limits let it; and by which."""
        by, kin, others = self.of[j].by[rows], self._kin, self.beyond_limits(pose, j)[rows]
        inside = kin.bound(others.q)
        short = np.abs(short_way(inside[:, j] - others.q[:, j], kin.endless[[j]]))
        kept = np.flatnonzero(short < OFF * np.abs(by))
        return Poses(others.R, others.t, inside)[kept], rows[kept]

    def beyond_limits(self, pose: Poses, j: int) -> Poses:
        """One hypothesis with a joint moved on by each of its steps, be it beyond its limits."""
        others = pose[np.zeros(len(self.of[j].by), int)]
        q = others.q.copy()
        q[:, j] += self.of[j].by
        return Poses(others.R, others.t, q)

    def off(self, others: Poses, pose: Poses, j: int) -> Array:
        """(n,) how far a joint is from where one hypothesis has it."""
        return np.asarray(short_way(others.q[:, j] - pose.q[0, j], self._kin.endless[[j]]), np.float64)

    def elsewhere(self, j: int) -> NDArray[np.bool_]:
        """(C,) components that a joint's steps put elsewhere: not what lies about its axis alone."""
        steps, out = self.of[j], self._kin.moves[:, j].copy()
        mine = self._component[steps.markers]
        moved = mine[~steps.stays.all(axis=0)]
        out[np.setdiff1d(mine, moved)] = False
        return out

    def stepped(self, pose: Poses, other: Poses) -> bool:
        """Whether one hypothesis has a joint moved on by a step or more, as another one has it."""
        return any(
            bool(np.abs(self.off(other, pose, j)).max() > OFF * np.abs(steps.by).min()) for j, steps in self.of.items()
        )


def _steps(surface: SpatialModel, j: int) -> Steps:
    """Those of a joint by which some of the markers that it alone carries lie on like ones, but not all of them do, or
    stay where they are: after a whole step of a wheel nothing differs."""
    kin, component = surface.kinematics, surface.component[surface.markers]
    markers = np.flatnonzero((kin.moves[component] == kin.moves[kin.carried[j]]).all(axis=1))
    patches, frames = surface.markers[markers], kin.in_object(kin.middle[None])
    like = may_be_taken_for(surface, patches) & ~np.eye(len(patches), dtype=bool)
    at = surface.place(frames, surface.centre[patches], component[markers])[0] - frames.origin[0, j]
    near, axis, turns = OFF * np.sqrt(surface.area[patches]), frames.axis[0, j], bool(kin.revolute[j])
    normal = (frames.R[0, component[markers]] @ surface.normal[patches][..., None])[..., 0]
    tried, by_each = [_between(axis, at[n], at[m], turns) for n, m in np.argwhere(like)], list[float]()
    on, stays = list[NDArray[np.bool_]](), list[NDArray[np.bool_]]()
    for by in sorted(tried):
        moved, faces = _moved(axis, at, by, turns), _moved(axis, normal, by, True) if turns else normal
        same = (np.linalg.norm(moved - at, axis=1) < near) & ((faces * normal).sum(axis=1) > _FACES)
        lies = like & (np.linalg.norm(moved[:, None] - at, axis=2) < near) & (faces @ normal.T > _FACES)
        lies[np.linalg.norm(moved - at, axis=1) < near] = False  # it is where it was
        again = any(np.array_equal(lies, other) for other in on)
        if lies.any() and not (lies.any(axis=1) | same).all() and not again:
            by_each.append(by)
            on.append(lies)
            stays.append(same)
    size = -1, len(markers)
    return Steps(
        markers, np.array(by_each), np.array(on, bool).reshape(*size, len(markers)), np.array(stays, bool).reshape(size)
    )


def _between(axis: Array, here: Array, there: Array, turns: bool) -> float:
    """By how much a joint at the origin is to be moved on for one place to come as near as it can to another (3,)."""
    if not turns:
        return float((there - here) @ axis)
    return float(np.arctan2(np.cross(here, there) @ axis, here @ there - (here @ axis) * (there @ axis)))


def _moved(axis: Array, at: Array, by: float, turns: bool) -> Array:
    """(m, 3) places after a joint is moved on."""
    return at @ rotation_from_rotvec(by * axis).T if turns else at + by * axis
