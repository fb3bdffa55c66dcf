"""Steps of a fit: their equations, and hypotheses that are no numbers."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, random_poses, truck

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.pose.damping_kernels import Damping, add_damping, shorten
from artrec_ros.core.pose.fit_kernels import solve
from artrec_ros.core.pose.joint_prior_kernels import JointPrior, add_joint_prior
from artrec_ros.core.pose.placed_kernels import Joints, Placed, no_equations
from artrec_ros.core.pose.pose_fit import fit_poses
from artrec_ros.core.pose.surface_model import SpatialModel

pytestmark = pytest.mark.uncompiled


@pytest.fixture
def rng():
    return np.random.default_rng(3)


@pytest.fixture
def scene(rng):
    """A truck's surface, poses of it in view, and a frame whose labels have something to say on them."""
    coarse = np.random.default_rng(4).choice([0, RED, 5, 1], (24, 32), p=[0.2, 0.4, 0.3, 0.1])
    labels = np.kron(coarse, np.ones((10, 10))).astype(np.uint8)
    frame = ImageFrame(LabelField(labels), camera_of())
    return SpatialModel(truck(), RED, DEFAULTS.votes), random_poses(rng, truck(), 12), frame


def test_hypotheses_that_are_no_numbers_score_nothing(scene):
    surface, poses, frame = scene
    broken = replace(poses, t=np.full_like(poses.t, np.nan))
    scores = surface.score(frame, broken, np.arange(len(surface.patches)), occlusion=True)
    assert not scores.votes.any() and not scores.area_px.any()


def test_equations_whose_rows_begin_late_are_solved(rng):
    """Joints that move nothing in use have no part in the others' equations."""
    n = 12
    for quiet in ([], [7], [6, 7, 11], [0, 5], list(range(6, n))):
        J = rng.normal(0, 1, (30, n))
        J[:, quiet] = 0.0
        A, b = J.T @ J + np.diag(rng.uniform(0.1, 2.0, n)), rng.normal(0, 1, n)
        A[5, 5], x = A[5, 5] + 1e9, np.empty(n)
        expected = np.linalg.solve(A, b)
        solve(A, b, x, np.empty(n, np.int64))
        np.testing.assert_allclose(x, expected, rtol=1e-9, atol=1e-12)


def placed_of(q, depth=2.0, unit=None):
    """A hypothesis with joints `q`, as terms see it; its frames say nothing."""
    n = len(q)
    units = np.ones(n) if unit is None else unit
    joints = Joints(-np.ones(n), np.ones(n), units, *np.ones((2, n), bool), np.ones((1, n), bool))
    return Placed(np.array([0.1, 0.2, depth]), q, np.eye(3)[None], np.zeros((1, 3)), *np.zeros((2, n, 3)), joints)


def test_joints_are_pulled_to_their_middle_and_held_where_they_are_not_free():
    prior = JointPrior(np.array([0.5, 0.0]), np.array([4.0, 9.0]), np.array([[True, True], [True, False]]), 1e9)
    for h, pins in ((0, [0, 0]), (1, [0, 1e9])):
        to = no_equations(2)
        add_joint_prior(prior, h, placed_of(np.array([0.2, 0.3])), to)
        np.testing.assert_allclose(np.diag(to.A), [*np.zeros(6), 4 + pins[0], 9 + pins[1]])
        np.testing.assert_allclose(to.b, [*np.zeros(6), 4 * (0.2 - 0.5), 9 * 0.3])
        assert np.count_nonzero(to.A) == 2


def test_damping_is_a_pull_to_no_step_in_each_parameters_own_unit():
    """Without any other term a step stays nothing; with one of a known weight it goes the known share of the way."""
    damping = Damping(0.7, np.array([0.05, 0.15]), np.array([0.15, 0.3]), np.zeros(6))
    to, placed = no_equations(2), placed_of(np.zeros(2), 3.0, np.array([1.0, 0.02]))
    add_damping(damping, placed, to)
    deviations = np.array([0.15, 0.15, 0.15, 0.15, 0.15, 0.15, 0.15, 0.003])
    np.testing.assert_allclose(np.diag(to.A), (0.7 / deviations) ** 2, rtol=1e-6)
    assert not to.b.any()


def test_a_long_step_is_scaled_down_and_keeps_its_direction():
    damping = Damping(0.7, np.array([0.05, 0.15]), np.array([0.15, 0.3]), np.zeros(6))
    placed, long = placed_of(np.zeros(1), 2.0), np.array([0.9, 0.0, 0.1, 0.2, 0.0, 0.0, 0.3])
    x = long.copy()
    shorten(damping, placed, x)
    np.testing.assert_allclose(x, long / 3)  # 0.3 m is the longest shift in a depth of 2 m
    short = long / 10
    shorten(damping, placed, short)
    np.testing.assert_allclose(short, long / 10)


def test_a_fit_from_no_numbers_harms_no_other(scene):
    surface, poses, frame = scene
    use = np.ones((len(poses), len(surface.markers)), bool)
    alone = fit_poses(surface, frame, poses, use, (4, 3), DEFAULTS.fit)
    broken = replace(poses, t=np.where(np.arange(len(poses))[:, None] % 3 == 0, np.nan, poses.t))
    found = fit_poses(surface, frame, broken, use, (4, 3), DEFAULTS.fit)
    good = np.arange(len(poses)) % 3 != 0
    for name in ("R", "t", "q"):
        np.testing.assert_array_equal(getattr(found, name)[good], getattr(alone, name)[good])
