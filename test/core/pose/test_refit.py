"""Fits of hypotheses with the votes before and after."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, jolted, pose, render, truck

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder

CAMERA = camera_of()
ANYWHERE = 0.0, np.inf


@pytest.fixture(scope="module")
def seen():
    """A finder, a frame that shows its truck, and hypotheses near to it and far off."""
    truth = pose(0.02, 0.01, 0.9, 0.5, 0.1, truck())
    finder = WholeObjectFinder(Target("truck", truck(), RED), DEFAULTS)
    frame = ImageFrame(LabelField(render(CAMERA, [(truck(), truth, RED)])), CAMERA)
    return finder, frame, jolted(np.random.default_rng(0), truth, 20, 0.01, 0.08, 0.1)


def test_it_is_the_fit_to_supported_markers_and_both_votes(seen):
    finder, frame, poses = seen
    found, fitted = finder.refit.of(frame, poses, ANYWHERE), finder.rest.fitted(frame, poses)
    for name in ("R", "t", "q"):
        both = np.concatenate([getattr(poses, name), getattr(fitted, name)])
        np.testing.assert_array_equal(getattr(found.poses, name), both)
    np.testing.assert_array_equal(found.votes, finder.voter.votes(frame, found.poses, occlusion=True))
    assert (found.votes[20:] > found.votes[:20]).sum() > 10


def test_at_the_deadline_hypotheses_stay(seen):
    finder, frame, poses = seen
    found = finder.refit.of(ImageFrame(frame.field, CAMERA, Deadline(0.0)), poses, ANYWHERE)
    np.testing.assert_array_equal(found.poses.t[:20], found.poses.t[20:])
    np.testing.assert_array_equal(found.votes[:20], found.votes[20:])


def test_what_is_fitted_is_left_between_the_depths(seen):
    finder, frame, poses = seen
    free, held = finder.refit.of(frame, poses, ANYWHERE), finder.refit.of(frame, poses, (0.905, 2.0))
    moved = (free.poses.t[20:] != poses.t).any(axis=1)
    assert moved.any()
    t = held.poses.t[20:][moved]
    assert (t[:, 2] >= 0.905 - 1e-9).all()
    np.testing.assert_allclose(t[:, :2] / t[:, 2:], free.poses.t[20:][moved][:, :2] / free.poses.t[20:][moved][:, 2:])
