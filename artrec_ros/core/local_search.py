"""Search of a pose and joints on the votes themselves: they see bodies, and what hides what."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from .compiled.climbing import Moves
from .datatypes import Camera
from .deadline import Deadline
from .kinematics import Kinematics
from .spatial import Poses
from .transforms import Array, rotation_from_rotvec

STEP_PX, STEP_DEPTH, STEP_RAD, STEP_JOINT = 1.5, 0.03, 0.12, 0.15
GROW, SHRINK = 1.1, 0.98  # of the step after a try that succeeds, and one that fails
LEAST_STEP = 0.01  # smaller ones end a climb: a fit to the contours goes there in one step


def climb(
    votes_of: Callable[[Poses], Array],
    kinematics: Kinematics,
    camera: Camera,
    poses: Poses,
    votes: Array,
    tries: int,
    spread: float,
    deadline: Deadline | None = None,
    seed: int = 0,
) -> tuple[Poses, Array]:
    """Move each hypothesis to better ones nearby: (1+1) evolution (Rechenberg 1973) that repeats a move that helped.

    :param votes_of: the value of hypotheses, (H,).
    :param deadline: ends the search between two tries.
    :param spread: first step, in units of STEP_PX and the like.
    :return: hypotheses no worse than before, and their votes.
    """
    n, moves = len(poses), draws(kinematics.n_joints, tries, seed)
    if not n:
        return poses, votes
    step: Array = np.full(n, spread)
    better, which = np.zeros(n, bool), np.zeros(n, int)
    for i in range(tries):
        if (deadline is not None and deadline.expired) or step.max() < LEAST_STEP:
            break
        which = np.where(better, which, i)
        tried = _perturbed(moves[which] * step[:, None], kinematics, camera, poses)
        found = votes_of(tried)
        better = (found > votes) & (step >= LEAST_STEP)
        votes = np.where(better, found, votes)
        poses = Poses.concatenate([poses, tried])[np.arange(n) + n * better]
        step = step * np.where(better, GROW, SHRINK)
    return poses, votes


def sweep(
    votes_of: Callable[[Poses], Array], kinematics: Kinematics, poses: Poses, votes: Array, step: float
) -> tuple[Poses, Array]:
    """Move each joint in turn to the best of all its values, `step` units apart.

    :return: hypotheses no worse than before, and their votes.
    """
    every = np.arange(len(poses))
    for j in range(kinematics.n_joints):
        grid = kinematics.grid(j, step)
        tried = poses[np.repeat(every, len(grid))]
        tried.q[:, j] = np.tile(grid, len(poses))
        found = votes_of(tried).reshape(len(poses), -1)
        best = found.argmax(axis=1)
        better = found[every, best] > votes
        votes = np.where(better, found[every, best], votes)
        q = poses.q.copy()
        q[:, j] = np.where(better, grid[best], q[:, j])
        poses = Poses(poses.R, poses.t, q)
    return poses, votes


@lru_cache(maxsize=32)
def draws(n_joints: int, tries: int, seed: int = 0) -> Array:
    """(tries, 6 + J) steps in units of STEP_PX and the like; half the parameters stay put in each try.

    The same for all hypotheses: the same image gives the same answer.
    """
    rng, shape = np.random.default_rng(seed), (tries, 6 + n_joints)
    return rng.standard_normal(shape) * (rng.random(shape) < 0.5)


def moves_of(kinematics: Kinematics, camera: Camera, tries: int) -> Moves:
    """The same steps for compiled code."""
    focal = float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]))
    z = draws(kinematics.n_joints, tries)
    steps = (STEP_PX, STEP_DEPTH, STEP_RAD, STEP_JOINT, GROW, SHRINK, LEAST_STEP)
    return Moves(z, *steps, focal, kinematics.lower, kinematics.upper, kinematics.unit, kinematics.endless)


def _perturbed(z: Array, kin: Kinematics, camera: Camera, poses: Poses) -> Poses:
    """Poses moved by z (H, 6 + J): along the ray and across it, turned, bent."""
    f = np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1])
    across = z[:, :3] * np.array([STEP_PX, STEP_PX, 0.0]) / f * poses.t[:, 2:]
    t = poses.t * (1 + STEP_DEPTH * z[:, 2:3]) + across
    R = rotation_from_rotvec(STEP_RAD * z[:, 3:6]) @ poses.R
    return Poses(R, t, kin.bound(poses.q + STEP_JOINT * kin.unit * z[:, 6:]))
