"""Parts that come out from behind their own object: where their outline ends, and other places of their joints."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, RIGHT_SIDE, cabinet, camera_of, marker, pose, rectangle, render

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.climber import Climb
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.ranked import Ranked

CAMERA = camera_of((640, 480), 600.0)


@pytest.fixture(scope="module")
def finder():
    return WholeObjectFinder(Target("cabinet", cabinet(), RED), DEFAULTS)


def opened(metres, heading=0.0):
    return pose(0.0, 0.0, 1.5, heading, model=cabinet(), joints={"drawer": metres})


def frame_of(truth):
    """Nothing around bears a class, as where only markers are painted."""
    return ImageFrame(LabelField(render(CAMERA, [(cabinet(), truth, RED)], background=0)), CAMERA)


def ranked(finder, frame, poses):
    return Ranked(poses, finder.voter.votes(frame, poses, occlusion=True))


@pytest.mark.parametrize("heading", [-0.06, 0.0, 0.06])
def test_the_outline_of_what_comes_out_of_a_body_tells_how_far_it_is_out(finder, heading):
    """Four fifths of the strip are inside. A centimetre is five pixels of its 48, 80 of which cost nothing to cover."""
    truth = opened(0.04, heading)
    both = Poses.concatenate([truth, opened(0.05, heading)])
    right, too_far = finder.voter.votes(frame_of(truth), both, occlusion=True)
    assert right > too_far + 50


def test_what_is_seen_of_a_marker_behind_a_bezel_counts():
    """Four bars of its own object hide all of its outline, and nothing of its middle."""
    bars = [((x, -0.02, z), size) for (x, z), size in zip(
        ((0, 0.055), (0, -0.055), (0.085, 0), (-0.085, 0)),
        ((0.2, 0.01, 0.03), (0.2, 0.01, 0.03), (0.03, 0.01, 0.14), (0.03, 0.01, 0.14)),
        strict=True,
    )]  # fmt: skip
    boxes = tuple(Box(Pose.from_xyz_rpy(xyz), np.array(size)) for xyz, size in bars)
    plate = marker("plate", rectangle(0.16, 0.1), RIGHT_SIDE, (0, 0, 0))
    framed = ObjectModel("framed", (Component("screen", (plate,), required=True, bodies=boxes),))
    found, there = WholeObjectFinder(Target("framed", framed, RED), DEFAULTS), pose(0, 0, 0.8, model=framed)
    frame = ImageFrame(LabelField(render(CAMERA, [(framed, there, RED)])), CAMERA)
    assert found.voter.votes(frame, there, occlusion=True)[0] > 10_000


@pytest.mark.parametrize("begun", [0.0, 0.2])
def test_a_joint_is_found_far_from_where_it_was_left(finder, begun):
    truth = opened(0.1)
    frame = frame_of(truth)
    found = finder.rejointed(frame, ranked(finder, frame, opened(begun)), Climb(1, 4, 1.0))
    assert abs(found.poses.q[0, 0] - 0.1) < 0.015  # three pixels
    assert found.votes[0] > 0.97 * ranked(finder, frame, truth).votes[0]


def test_joints_of_parts_that_lie_on_their_labels_are_left_alone(finder):
    truth = opened(0.15)
    frame = frame_of(truth)
    there = ranked(finder, frame, truth)
    assert len(finder.other_joints.of(frame, truth, float(there.votes[0]))) == 0
    np.testing.assert_array_equal(finder.rejointed(frame, there, Climb(1, 4, 1.0)).poses.q, truth.q)
