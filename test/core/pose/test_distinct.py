"""Hypotheses that differ: the best of each cell, and those that climb to places of their own."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import pose, random_poses, sign, truck

from artrec_ros.core.pose.distinct import apart, best_distinct
from artrec_ros.core.pose.distinct_kernels import few_of_places
from artrec_ros.core.pose.poses import Poses

MODEL, SEARCH = sign(), DEFAULTS.search
NICHE = SEARCH.niche_rad, SEARCH.niche_range


def poses_of(*places):
    return Poses.concatenate([pose(x, 0.0, z, turn, model=MODEL) for x, z, turn in places])


def test_of_hypotheses_that_are_one_and_the_same_the_best_stays():
    poses = poses_of((0, 1, 0), (0, 1, 0.8), (0, 1, 0.001), (0.3, 1, 0), (0, 1.5, 0))
    score = np.array([1.0, 5.0, 2.0, 3.0, 4.0])
    assert best_distinct(poses, score, 9, SEARCH).tolist() == [1, 4, 3, 2]
    assert best_distinct(poses, score, 2, SEARCH).tolist() == [1, 4]


def test_hypotheses_that_diverged_are_sorted_too():
    poses = poses_of((0, 1, 0), (0, 1, 0.5))
    poses.t[1] = np.nan
    assert sorted(best_distinct(poses, np.array([1.0, 2.0]), 5, SEARCH).tolist()) == [0, 1]
    assert not len(best_distinct(poses[np.zeros(0, int)], np.zeros(0), 5, SEARCH))


def test_niches_differ_in_turn_or_place():
    poses = poses_of((0, 1, 0), (0.02, 1.02, 0.1), (0, 1, 0.6), (0.3, 1, 0), (0, 1.3, 0), (0, 1.31, 0.1))
    assert apart(poses, np.arange(6.0, 0, -1), 0.0, *NICHE).tolist() == [0, 2, 3, 4]


def test_hypotheses_with_too_few_votes_have_no_niche():
    poses = poses_of((0, 1, 0), (0, 1, 0.6), (0.3, 1, 0))
    assert apart(poses, np.array([5.0, 3.0, -1.0]), 2.0, *NICHE).tolist() == [0, 1]
    assert apart(poses, np.array([-1.0, -2.0, -3.0]), 0.0, *NICHE).tolist() == []


@pytest.mark.uncompiled
def test_of_hypotheses_that_are_alike_the_best_is_kept():
    rng = np.random.default_rng(3)
    poses = random_poses(rng, truck(), 30)
    poses = poses[rng.integers(0, 30, 120)]
    poses.t[::2] *= rng.uniform(0.97, 1.03, (60, 1))
    poses.t[7], score = np.nan, rng.normal(size=120)
    kept = best_distinct(poses, score, 500, SEARCH)
    assert 30 <= len(kept) < 100 and (np.diff(score[kept]) <= 0).all()
    assert best_distinct(poses, score, 5, SEARCH).tolist() == kept[:5].tolist()
    for h in set(range(120)) - set(kept.tolist()) - {7}:
        near = kept[score[kept] >= score[h]]
        place = np.abs(poses.t[near, :2] / poses.t[near, 2:] - poses.t[h, :2] / poses.t[h, 2]).max(axis=1)
        depth = np.abs(np.log(poses.t[near, 2] / poses.t[h, 2]))
        axes = np.abs((poses.R[near] - poses.R[h])[:, :, [0, 2]]).max(axis=(1, 2))
        alike = (place <= SEARCH.cell_place) & (depth <= SEARCH.cell_log_depth) & (axes <= SEARCH.cell_axis)
        assert alike.any()


@pytest.mark.parametrize("most", [1, 2, 3])
def test_of_each_place_so_many_are_kept_the_first_ones_and_two_of_a_direction(most):
    rng = np.random.default_rng(most)
    at, reach, turn = rng.uniform(0, 30, (60, 2)), rng.uniform(1, 6, 60), rng.uniform(-np.pi, np.pi, 60)
    at[1:4], turn[:4], reach[:4] = at[0], (np.pi, -np.pi, np.pi - 0.1, 0.0), 6.0
    out = np.empty(60, np.int64)
    kept = out[: few_of_places(at, turn, reach, most, 2, np.cos(0.35), out)].tolist()
    expected: list[int] = []
    for i in range(60):
        near = np.linalg.norm(at[expected] - at[i], axis=1) < reach[i]
        alike = near & (np.cos(turn[expected] - turn[i]) > np.cos(0.35))
        if np.count_nonzero(near) < most and np.count_nonzero(alike) < 2:
            expected.append(i)
    assert kept == expected and 0 < len(kept) < 60
    assert kept[:most] == [0, 1, 3][:most]
