"""Climbs of whole hypotheses on the votes for them, between the limits of what is looked for."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base.config import RecognizerConfig, SearchConfig
from ..geometry.camera import Camera
from ..geometry.range_limits import scale_limits
from ..image.image_frame import ImageFrame
from . import climb_kernels as climbing
from .climb_kernels import Steps
from .poses import Poses
from .ranked import Ranked
from .voter import Voter

_AT_ONCE = 32  # hypotheses of what faces the camera that climb between two looks at the clock; of others one
_SWEPT_AT_ONCE = 8  # whose joints are swept between two


class Climb(NamedTuple):
    """A climb on the votes: of at most so many hypotheses, so many rounds, the first steps in units of `climbing`."""

    most: int
    rounds: int
    first_step: float

    @classmethod
    def last(cls, config: RecognizerConfig, *, facing: bool) -> Climb:
        """That of what a search has found."""
        if facing:
            return cls(0, config.facing.rounds[-1], config.facing.first_step / 2)
        return cls(0, config.search.climb_rounds[-2:][0], config.search.climb_first_steps[-1])


class Climber:
    """Moves hypotheses of one object uphill. :param facing: they turn about the optical axis alone."""

    def __init__(self, voter: Voter, config: RecognizerConfig, *, facing: bool) -> None:
        self._surface, self._value, self._config, self._facing = voter.surface, voter.value, config, facing
        self._grids, self._steps = voter.surface.kinematics.grids(config.search.joint_step), _steps(config.search)

    def sweep(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """Joints at their best by the votes of the whole object, which know what hides what."""
        kin, surface = self._surface.kinematics, self._surface
        if not kin.n_joints:
            return found
        moved = found.copied()
        for part in frame.deadline.parts(len(found), _SWEPT_AT_ONCE):
            arrays = [values[part] for values in moved.arrays]
            climbing.sweep(
                surface.compiled, kin.chain, frame.view, surface.limits, self._value, self._grids, *arrays
            )  # fmt: skip
        return moved

    def climb(self, frame: ImageFrame, found: Ranked, climb: Climb) -> Ranked:
        """Local search on the votes of the whole object: no hypothesis gets worse, and the clock ends it."""
        kin, moved, surface = self._surface.kinematics, found.copied(), self._surface
        near_m, far_m = self.depths(frame.camera)
        limits = kin.lower, kin.upper, kin.unit, kin.endless
        moves = climbing.Moves(self._steps, frame.camera.focal_px, near_m, far_m, *limits)
        steps = np.full((len(found), 6 + kin.n_joints), climb.first_step, float)
        if self._facing:
            steps[:, 3:5] = 0.0
        for part in frame.deadline.parts(len(found), _AT_ONCE if self._facing else 1):
            arrays = [values[part] for values in (steps, *moved.arrays)]
            climbing.climb(
                surface.compiled, kin.chain, frame.view, surface.limits, self._value, moves, climb.rounds, *arrays
            )  # fmt: skip
        return moved

    def within_limits(self, camera: Camera, poses: Poses) -> Poses:
        """Hypotheses that face the camera, with their origins in the image where they are, at scales that are looked
        for; others are where they are."""
        if not self._facing:
            return poses
        depth = poses.t[:, 2]
        near_m, far_m = self.depths(camera)
        return Poses(poses.R, poses.t * (np.minimum(np.maximum(depth, near_m), far_m) / depth)[:, None], poses.q)

    def depths(self, camera: Camera) -> tuple[float, float]:
        """Between which depths hypotheses stay while they move: of what faces the camera, those of its scale."""
        if not self._facing:
            return 0.0, np.inf
        limits, f = scale_limits(self._config, None), float(camera.focal_px)
        return f / float(limits.greatest), f / float(limits.least) if limits.least > 0 else np.inf


def _steps(search: SearchConfig) -> Steps:
    """Steps of a climb for compiled code; a whole number would be compiled for anew."""
    units = search.step_px, search.step_depth, search.step_rad, search.joint_step
    return Steps(*map(float, (*units, search.lengthen, search.turn, search.least_step)))
