"""Search of a pose and joints on the votes themselves: they see bodies, and what hides what."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .compiled.climbing import Moves
from .datatypes import Camera
from .deadline import Deadline
from .kinematics import Kinematics
from .spatial import Poses
from .transforms import Array, rotation_from_rotvec

STEP_PX, STEP_DEPTH, STEP_RAD, STEP_JOINT = 1.5, 0.03, 0.12, 0.15
LENGTHEN, TURN = 1.6, -0.7  # of a parameter's step after it helped, and after it did not
LEAST_STEP = 0.01  # a shorter one is not taken: a fit to the contours goes there in one step


def climb(
    votes_of: Callable[[Poses], Array],
    kinematics: Kinematics,
    camera: Camera,
    poses: Poses,
    votes: Array,
    rounds: int,
    spread: float,
    deadline: Deadline | None = None,
) -> tuple[Poses, Array]:
    """Move each hypothesis to better ones nearby, one parameter after the other, so many rounds of all of them.

    Each parameter has a step of its own. One that helps is taken, and the next one is longer; one that does not is
    turned round and shortened (Rosenbrock 1960, along the parameters' own axes throughout).

    :param votes_of: the value of hypotheses, (H,).
    :param deadline: ends the search between two rounds.
    :param spread: first steps, in units of STEP_PX and the like.
    :return: hypotheses no worse than before, and their votes.
    """
    steps = np.full((len(poses), 6 + kinematics.n_joints), float(spread))
    for _ in range(rounds if len(poses) else 0):
        if (deadline is not None and deadline.expired) or (np.abs(steps) < LEAST_STEP).all():
            break
        for k in range(steps.shape[1]):
            step = np.zeros_like(steps)
            step[:, k] = steps[:, k]
            tried = _stepped(step, kinematics, camera, poses)
            found, taken = votes_of(tried), np.abs(steps[:, k]) >= LEAST_STEP
            better = (found > votes) & taken
            votes = np.where(better, found, votes)
            poses = Poses.concatenate([poses, tried])[np.arange(len(poses)) + len(poses) * better]
            steps[:, k] *= np.where(better, LENGTHEN, np.where(taken, TURN, 1.0))
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
        found = votes_of(tried).reshape(len(poses), len(grid))
        best = found.argmax(axis=1)
        better = found[every, best] > votes
        votes = np.where(better, found[every, best], votes)
        q = poses.q.copy()
        q[:, j] = np.where(better, grid[best], q[:, j])
        poses = Poses(poses.R, poses.t, q)
    return poses, votes


def moves_of(kinematics: Kinematics, camera: Camera) -> Moves:
    """The same steps for compiled code."""
    focal = float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]))
    steps = (STEP_PX, STEP_DEPTH, STEP_RAD, STEP_JOINT, LENGTHEN, TURN, LEAST_STEP)
    return Moves(*steps, focal, kinematics.lower, kinematics.upper, kinematics.unit, kinematics.endless)


def _stepped(z: Array, kin: Kinematics, camera: Camera, poses: Poses) -> Poses:
    """Poses moved by z (H, 6 + J), in units of STEP_PX and the like: across the ray and along it, turned, bent."""
    f = np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1])
    across = z[:, :3] * np.array([STEP_PX, STEP_PX, 0.0]) / f * poses.t[:, 2:]
    t = poses.t * (1 + STEP_DEPTH * z[:, 2:3]) + across
    R = rotation_from_rotvec(STEP_RAD * z[:, 3:6]) @ poses.R
    return Poses(R, t, kin.bound(poses.q + STEP_JOINT * kin.unit * z[:, 6:]))
