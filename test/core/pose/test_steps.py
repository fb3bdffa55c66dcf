"""Steps of a fit: their equations, and hypotheses that are no numbers."""

from dataclasses import replace

import numpy as np
import pytest
from solids import RED, camera_of, random_poses, truck

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.pose import pose_fit as posefit
from artrec_ros.core.pose import step_kernels as refining
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
    return SpatialModel(truck(), RED), random_poses(rng, truck(), 12), ImageFrame(LabelField(labels), camera_of())


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
        refining.solve(A, b, x, np.empty(n, np.int64))
        np.testing.assert_allclose(x, expected, rtol=1e-9, atol=1e-12)


def test_a_fit_from_no_numbers_harms_no_other(scene):
    surface, poses, frame = scene
    use = np.ones((len(poses), len(surface.markers)), bool)
    alone = posefit.refine(surface, frame, poses, use, (4, 3))
    broken = replace(poses, t=np.where(np.arange(len(poses))[:, None] % 3 == 0, np.nan, poses.t))
    found = posefit.refine(surface, frame, broken, use, (4, 3))
    good = np.arange(len(poses)) % 3 != 0
    for name in ("R", "t", "q"):
        np.testing.assert_array_equal(getattr(found, name)[good], getattr(alone, name)[good])
