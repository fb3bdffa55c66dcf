"""How sure like markers that one joint carries are of their places: moved along it they lie on each other's.

Of three like men on a rod one is hidden: moved on by one place the rod shows the other two as well, if its limits let
it, and nothing in the image tells where on it the hidden one is. A search keeps the bend that it found first. So the
others that lay like markers where those lie that are seen are compared with it, as mirrored turns are.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, rotation_from_rotvec, short_way
from ..image.image_frame import ImageFrame
from .exchanges import OFF, may_be_taken_for
from .finder import WholeObjectFinder
from .poses import Poses
from .surface_model import SpatialModel
from .turn_evidence import turn_odds

_FACES = 0.5  # cosine between the ways that like markers face: of one on a limb's other side nothing is seen here


class Bent(NamedTuple):
    """How sure it is that an object is bent as it is told.

    :ivar stays: of components that other bends put elsewhere how probable it is that they are where they are told.
    :ivar variance: by how much joints' variances are greater for these, by their names.
    """

    stays: Mapping[str, float]
    variance: Mapping[str, float]


class _Steps(NamedTuple):
    """By how much a joint is moved on for like markers to lie on each other.

    :ivar markers: (m,) those that it alone carries, among all markers. :ivar by: (K,) radians or metres.
    :ivar on: (K, m, m) bool: which of them then lies where which other one does.
    """

    markers: NDArray[np.int64]
    by: Array
    on: NDArray[np.bool_]


class AlongJoints:
    """Other bends of one target's objects."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._kin = finder, finder.surface.kinematics
        self._component = finder.surface.component[finder.surface.markers]
        self._steps = {j: steps for j in range(self._kin.n_joints) if len((steps := _steps(finder.surface, j)).by)}

    def of(self, frames: Sequence[ImageFrame], poses: Poses, seen: Sequence[Collection[int]]) -> list[Bent]:
        """Of H poses at rest. :param frames: in which each is looked at. :param seen: of each the components that
        are."""
        return [self._of_one(frame, poses[h : h + 1], seen[h]) for h, frame in enumerate(frames)]

    def _of_one(self, frame: ImageFrame, pose: Poses, seen: Collection[int]) -> Bent:
        stays, variance, model = dict[str, float](), dict[str, float](), self._finder.surface.model
        if not self._steps or frame.deadline.expired:
            return Bent(stays, variance)
        frame, shown = frame.unhurried(), np.isin(self._component, list(seen))
        for j in self._steps:
            others = self._others(frame, pose, j, shown)
            if not len(others):
                continue
            log_odds = turn_odds(self._finder, frame, pose[np.zeros(len(others), int)], others)
            doubt = np.exp(np.minimum(log_odds, 0.0))
            doubt /= 1 + doubt.sum()
            for c in np.flatnonzero(self._kin.moves[:, j]).tolist():
                name = model.components[c].name
                stays[name] = stays.get(name, 1.0) * (1 - float(doubt.sum()))
            variance[model.joint_names[j]] = float(doubt @ self._off(others, pose, j) ** 2)
        return Bent(stays, variance)

    def _others(self, frame: ImageFrame, pose: Poses, j: int, seen: NDArray[np.bool_]) -> Poses:
        """(n,) poses at rest with one joint elsewhere, where its markers are borne out as they are as it is told.

        :param seen: (M,) markers.
        """
        (markers, by, on), kin, finder = self._steps[j], self._kin, self._finder
        mine = seen[markers]
        if mine.all() or not mine.any():
            return pose[:0]
        by = by[np.asarray(on.any(axis=1))[:, mine].all(axis=1)]  # those that lay like markers where all of these are
        q = np.repeat(pose.q, len(by), axis=0)
        q[:, j] += by
        inside = kin.bound(q)
        short = np.abs(short_way(inside[:, j] - q[:, j], kin.endless[[j]]))
        rows = np.flatnonzero(short < OFF * np.abs(by))
        others = Poses(np.repeat(pose.R, len(by), axis=0), np.repeat(pose.t, len(by), axis=0), inside)[rows]
        if not len(others):
            return others
        others = finder.rest.at_rest(frame, others, finder.voter.supports(frame, others))
        least = finder.config.verdict.mirrored_votes * finder.voter.votes(frame, pose, occlusion=True)[0]
        apart = np.abs(self._off(others, pose, j)) > OFF * np.abs(by[rows])
        return others[np.flatnonzero(apart & (finder.voter.votes(frame, others, occlusion=True) > least))]

    def _off(self, others: Poses, pose: Poses, j: int) -> Array:
        return np.asarray(short_way(others.q[:, j] - pose.q[0, j], self._kin.endless[[j]]), np.float64)


def _steps(surface: SpatialModel, j: int) -> _Steps:
    """Those of a joint by which some of the markers that it alone carries lie on like ones, but not all of them do:
    after a whole step of a wheel nothing differs."""
    kin, component = surface.kinematics, surface.component[surface.markers]
    markers = np.flatnonzero((kin.moves[component] == kin.moves[kin.carried[j]]).all(axis=1))
    patches, frames = surface.markers[markers], kin.in_object(kin.middle[None])
    like = may_be_taken_for(surface, patches) & ~np.eye(len(patches), dtype=bool)
    at = surface.place(frames, surface.centre[patches], component[markers])[0] - frames.origin[0, j]
    near, axis, turns = OFF * np.sqrt(surface.area[patches]), frames.axis[0, j], bool(kin.revolute[j])
    normal = (frames.R[0, component[markers]] @ surface.normal[patches][..., None])[..., 0]
    tried, found = [_between(axis, at[n], at[m], turns) for n, m in np.argwhere(like)], list[float]()
    on = list[NDArray[np.bool_]]()
    for by in sorted(tried):
        moved, faces = _moved(axis, at, by, turns), _moved(axis, normal, by, True) if turns else normal
        lies = like & (np.linalg.norm(moved[:, None] - at, axis=2) < near) & (faces @ normal.T > _FACES)
        lies[np.linalg.norm(moved - at, axis=1) < near] = False  # it is where it was
        again = any(np.array_equal(lies, other) for other in on)
        if lies.any() and not lies.any(axis=1).all() and not again:
            found.append(by)
            on.append(lies)
    return _Steps(markers, np.array(found), np.array(on, bool).reshape(-1, len(markers), len(markers)))


def _between(axis: Array, here: Array, there: Array, turns: bool) -> float:
    """By how much a joint at the origin is to be moved on for one place to come as near as it can to another (3,)."""
    if not turns:
        return float((there - here) @ axis)
    return float(np.arctan2(np.cross(here, there) @ axis, here @ there - (here @ axis) * (there @ axis)))


def _moved(axis: Array, at: Array, by: float, turns: bool) -> Array:
    """(m, 3) places after a joint is moved on."""
    return at @ rotation_from_rotvec(by * axis).T if turns else at + by * axis
