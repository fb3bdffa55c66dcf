"""Climbing and sweeping: never worse, the same each time, up the hill, within the joints' limits."""

import numpy as np
import pytest
from artrec_ros.core.local_search import climb, sweep
from solids import camera_of, chain, jolted, pose, sign, turn_between

from artrec_ros.core.model.kinematics import Kinematics

CAMERA = camera_of()
MODEL = chain()
KIN = Kinematics(MODEL)
TRUTH = pose(0.05, 0.02, 0.9, 0.3, model=MODEL, joints={"arm": 0.2, "rod": 0.05, "finger": 0.5})


def closeness(poses):
    """Highest at TRUTH: distance in the image and in depth, turn, joints."""
    apart = np.linalg.norm((poses.t - TRUTH.t) / (0.01, 0.01, 0.05), axis=1)
    turn = np.array([turn_between(R, TRUTH.R[0]) for R in poses.R]) / 0.1
    return -np.hypot(np.hypot(apart, turn), np.linalg.norm((poses.q - TRUTH.q) / 0.15, axis=1))


def start(n=4, seed=0):
    poses = jolted(np.random.default_rng(seed), TRUTH, n, 0.01, 0.1, 0.05)
    poses.q[:] = np.clip(poses.q, KIN.lower, KIN.upper)
    return poses


def test_the_search_climbs_towards_the_top():
    poses = start()
    before = closeness(poses)
    found, votes = climb(closeness, KIN, CAMERA, poses, before, rounds=30, spread=1.0)
    np.testing.assert_allclose(closeness(found), votes)
    assert (votes >= before).all()
    assert np.median(votes / before) < 0.6


@pytest.mark.parametrize("seed", range(3))
def test_no_hypothesis_gets_worse_where_votes_are_rough(seed):
    poses = start(seed=seed)

    def rough(p):
        return np.floor(closeness(p)) + 3 * np.sin(1e4 * p.t[:, 0])

    before = rough(poses)
    found, votes = climb(rough, KIN, CAMERA, poses, before, rounds=6, spread=2.0)
    assert (votes >= before).all()
    np.testing.assert_allclose(rough(found), votes)


def test_each_hypothesis_climbs_as_it_does_alone():
    poses = start()
    together, _ = climb(closeness, KIN, CAMERA, poses, closeness(poses), 6, 1.0)
    for h in range(len(poses)):
        alone, _ = climb(closeness, KIN, CAMERA, poses[[h]], closeness(poses[[h]]), 6, 1.0)
        for name in ("R", "t", "q"):
            np.testing.assert_allclose(getattr(alone, name)[0], getattr(together, name)[h], atol=1e-12)
            np.testing.assert_array_equal(getattr(poses, name), getattr(start(), name))


def test_where_nothing_is_better_nothing_moves():
    poses = start()
    flat = lambda p: np.zeros(len(p))  # noqa: E731
    found, votes = climb(flat, KIN, CAMERA, poses, np.zeros(4), 4, 1.0)
    for name in ("R", "t", "q"):
        np.testing.assert_array_equal(getattr(found, name), getattr(poses, name))
    assert not votes.any()


def test_joints_stay_within_their_limits_and_rotations_are_rotations():
    poses = start()
    poses.q[:] = KIN.upper
    found, _ = climb(lambda p: p.q.sum(axis=1), KIN, CAMERA, poses, poses.q.sum(axis=1), 4, 3.0)
    np.testing.assert_array_equal(found.q, poses.q)  # already as far as they go
    found, _ = climb(lambda p: -p.q.sum(axis=1), KIN, CAMERA, poses, -poses.q.sum(axis=1), 20, 3.0)
    assert (found.q >= KIN.lower).all() and (found.q < KIN.upper).any()
    np.testing.assert_allclose(found.R @ found.R.transpose(0, 2, 1), np.tile(np.eye(3), (4, 1, 1)), atol=1e-9)


def test_nothing_to_climb_and_no_rounds():
    none = start()[np.zeros(0, int)]
    found, votes = climb(closeness, KIN, CAMERA, none, np.zeros(0), 3, 1.0)
    assert len(found) == len(votes) == 0
    assert len(sweep(closeness, KIN, none, np.zeros(0), step=0.1)[0]) == 0
    poses = start()
    found, votes = climb(closeness, KIN, CAMERA, poses, closeness(poses), 0, 1.0)
    np.testing.assert_array_equal(found.t, poses.t)


def test_an_object_without_joints():
    at = pose(0, 0, 1.0, model=sign())
    goal = at.t + (0.004, 0, 0.02)
    value = lambda p: -np.linalg.norm(p.t - goal, axis=1)  # noqa: E731
    found, votes = climb(value, Kinematics(sign()), CAMERA, at, value(at), 4, 1.0)
    assert votes[0] > 0.5 * value(at)[0] and found.q.shape == (1, 0)


def test_a_sweep_finds_each_joints_best_value_from_anywhere():
    poses = start(seed=3)
    goal = KIN.lower + 0.7 * (KIN.upper - KIN.lower)
    value = lambda p: -np.abs((p.q - goal) / KIN.unit).sum(axis=1)  # noqa: E731
    found, votes = sweep(value, KIN, poses, value(poses), step=0.1)
    np.testing.assert_allclose(value(found), votes)
    assert (votes >= value(poses)).all()
    assert (np.abs(found.q - goal) <= 0.05 * KIN.unit + 1e-9).all()
    np.testing.assert_array_equal(found.t, poses.t)


def test_a_sweep_leaves_what_is_best_as_it_is():
    poses = start()
    value = lambda p: -np.abs(p.q - poses.q[0]).sum(axis=1)  # noqa: E731
    found, _ = sweep(value, KIN, poses[[0]], np.zeros(1), step=0.1)
    np.testing.assert_array_equal(found.q, poses.q[[0]])
