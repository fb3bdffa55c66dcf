"""Turns that the outline of a component does not tell: about the axis of one that is round, all of a ball's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base.config import GuessesConfig, SearchConfig
from ..geometry.spread import all_turns
from ..geometry.transforms import Array, rotation_from_rotvec
from ..model.objects import ObjectModel
from ..model.same_turns import same_turns
from .poses import Poses
from .surface_model import SpatialModel


class Headings:
    """Those of one object."""

    def __init__(self, surface: SpatialModel, guesses: GuessesConfig, search: SearchConfig) -> None:
        self._surface, self._config, self._search = surface, guesses, search
        self._round = round_about(surface)
        self._balls = surface.sides.balls if len(surface.model.components) > 1 else frozenset()
        about = 2 * np.pi * np.arange(guesses.disc_turns)[:, None] / guesses.disc_turns
        self._about = rotation_from_rotvec(about * self._round[0]) if self._round else None  # in the object
        self._all = all_turns(guesses.disc_poses * guesses.disc_turns) if self._balls else np.zeros((0, 3, 3))

    def of_required(self, roots: Poses) -> Poses:
        """Poses, best first, turned about the required component where that is round: the few that lie or slant
        otherwise in all directions, of a ball the first in all ways. Else these poses."""
        if not self._round or self._about is None or not len(roots):
            return self.of_ball(roots, self._surface.root)
        axis, middle = self._round
        normal, at = roots.R @ axis, roots.R @ middle + roots.t
        niche, kept = self._search, list[int]()
        for n in range(len(roots)):
            near = np.linalg.norm(at[kept] - at[n], axis=1) < niche.niche_range * np.linalg.norm(at[n])
            if not (near & (normal[kept] @ normal[n] > np.cos(niche.niche_rad))).any():
                kept.append(n)
        kept = kept[: self._config.disc_poses]
        return _turned(roots[kept], at[kept], roots.R[kept, None] @ self._about, middle)

    def of_ball(self, poses: Poses, component: int) -> Poses:
        """The first of poses, best first, turned in all ways about a component that is a ball; of others these poses.
        Joints mid-range, as poses have them that begin with it."""
        if component not in self._balls or not len(poses):
            return poses
        kin, ball = self._surface.kinematics, self._surface.model.components[component].ball
        assert ball is not None
        frames = kin.in_object(kin.middle[None])
        middle = frames.R[0, component] @ ball.centre + frames.t[0, component]
        return _turned(poses[:1], poses.R[:1] @ middle + poses.t[:1], self._all[None], middle)


def _turned(poses: Poses, at: Array, R: Array, middle: Array) -> Poses:
    """Poses (n) with other turns (n, k, 3, 3) that leave a point of the object (3,) where it is (n, 3)."""
    turns = R.shape[1]
    R = R.reshape(-1, 3, 3)
    return Poses(R, np.repeat(at, turns, axis=0) - R @ middle, np.repeat(poses.q, turns, axis=0))


def round_about(surface: SpatialModel) -> tuple[Array, Array] | tuple[()]:
    """The axis (3,) about which the required component looks the same in any direction, as a disc or a cylinder does,
    and a point (3,) on it, in the object; joints mid-range, as poses have them that begin with it. Empty: it does not,
    or there is nothing else."""
    model, markers = surface.model, surface.markers_of[surface.root]
    if len(model.components) == 1 or model.required.ball is not None:
        return ()
    if model.needs_another:  # a disc
        patch = surface.patches[markers[0]]
        axis, middle = patch.normal, patch.drawn[0]
    elif surface.root not in surface.solids:  # an outline that is drawn tells what it can
        return ()
    else:
        alone = ObjectModel(model.name, (replace(model.required, joint=None),))
        turns = [turn for turn in same_turns(alone) if turn.is_round]
        if len(turns) != 1:
            return ()
        axis, middle = turns[0].axis, np.mean([surface.patches[p].drawn[3:].mean(axis=0) for p in markers], axis=0)
    frames = surface.kinematics.in_object(surface.kinematics.middle[None])
    R, t = frames.R[0, surface.root], frames.t[0, surface.root]
    return R @ axis, R @ middle + t
