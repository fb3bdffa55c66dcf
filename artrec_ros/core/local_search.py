"""Random local search of a pose and joints on the votes themselves: they see bodies, and what hides what."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .compiled.climbing import Moves
from .datatypes import Camera
from .deadline import Deadline
from .kinematics import Kinematics
from .spatial import Poses
from .transforms import Array, rotation_from_rotvec

TRIES = 24  # a hypothesis and round
STEP_PX, STEP_DEPTH, STEP_RAD, STEP_JOINT = 1.5, 0.03, 0.12, 0.15
SHRINK = 0.75  # after a round without success


def climb(
    votes_of: Callable[[Poses], Array],
    kinematics: Kinematics,
    camera: Camera,
    poses: Poses,
    votes: Array,
    rounds: int,
    spread: float,
    deadline: Deadline | None = None,
    seed: int = 0,
) -> tuple[Poses, Array]:
    """Move each hypothesis to better ones nearby: (1+TRIES) evolution with a step that shrinks on failure.

    :param votes_of: the value of hypotheses, (H,).
    :param deadline: ends the search between two rounds.
    :param spread: first step, in units of STEP_PX and the like.
    :return: hypotheses no worse than before, and their votes.
    """
    n, moves = len(poses), draws(kinematics, rounds, seed)
    if not n:
        return poses, votes
    step: Array = np.full(n, spread)
    for z in moves:
        if deadline is not None and deadline.expired:
            break
        tried = _perturbed(z, kinematics, camera, poses, step)
        found = votes_of(tried).reshape(n, TRIES)
        best = found.argmax(axis=1)
        better = found[np.arange(n), best] > votes
        pick = np.where(better, n + np.arange(n) * TRIES + best, np.arange(n))
        votes = np.where(better, found[np.arange(n), best], votes)
        poses = Poses.concatenate([poses, tried])[pick]
        step = np.where(better, step, step * SHRINK)
    return poses, votes


def draws(kinematics: Kinematics, rounds: int, seed: int = 0) -> Array:
    """(rounds, TRIES, 6 + J) steps in units of STEP_PX and the like; half the parameters stay put in each try.

    The same for all hypotheses: the same image gives the same answer.
    """
    rng, shape = np.random.default_rng(seed), (rounds, TRIES, 6 + kinematics.n_joints)
    return rng.standard_normal(shape) * (rng.random(shape) < 0.5)


def moves_of(kinematics: Kinematics, camera: Camera, rounds: int) -> Moves:
    """The same steps for compiled code."""
    focal = float(np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]))
    z = draws(kinematics, rounds)
    steps = (STEP_PX, STEP_DEPTH, STEP_RAD, STEP_JOINT, SHRINK)
    return Moves(z, *steps, focal, kinematics.lower, kinematics.upper, kinematics.unit, kinematics.endless)


def _perturbed(z: Array, kin: Kinematics, camera: Camera, poses: Poses, step: Array) -> Poses:
    n = len(poses)
    z = z * step[:, None, None]  # (H, TRIES, 6 + J)
    f = np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1])
    depth = poses.t[:, None, 2:]
    across = z[..., :3] * np.array([STEP_PX, STEP_PX, 0.0]) / f * depth
    t = poses.t[:, None] * (1 + STEP_DEPTH * z[..., 2:3]) + across  # along the ray, and across it
    R = rotation_from_rotvec(STEP_RAD * z[..., 3:6]) @ poses.R[:, None]
    q = kin.bound(poses.q[:, None] + STEP_JOINT * kin.unit * z[..., 6:])
    return Poses(R.reshape(-1, 3, 3), t.reshape(-1, 3), q.reshape(n * TRIES, -1))
