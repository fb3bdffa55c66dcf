"""Joints that are bent otherwise where what they carry is not seen."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, pose, rectangle, render, truck

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, Joint, Marker, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import Climb, WholeObjectFinder
from artrec_ros.core.pose.ranked import Ranked
from artrec_ros.core.pose.rebends import Rebends

CAMERA = camera_of()


def plate(name, outline, at=(0.0, 0.0, 0.0)):
    side = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
    points = outline.min(axis=0), outline.max(axis=0)
    return Marker(name, outline, *points, T_component_marker=Pose(side, np.array(at)))


def arm():
    """An upper link that leans to the camera or away from it, and below it a lower one that swings in its plane."""
    base = Component("base", (plate("face", rectangle(0.16, 0.1)),), required=True)
    lean = Joint("base", Pose.from_xyz_rpy((0.0, 0.0, 0.06)), np.array([1.0, 0, 0]), -1.2, 1.2)
    swing = Joint("upper", Pose.from_xyz_rpy((0.0, 0.0, 0.16)), np.array([0.0, 1.0, 0.0]), -1.4, 1.4)
    link = rectangle(0.03, 0.14, (0.0, 0.08))
    return ObjectModel(
        "arm",
        (
            base,
            Component("upper", (plate("face", link),), joint=lean),
            Component("fore", (plate("face", link),), joint=swing),
        ),
    )


@pytest.fixture(scope="module")
def finder():
    return WholeObjectFinder(Target("arm", arm(), RED), DEFAULTS)


def ranked(finder, frame, poses):
    return Ranked(poses, finder.votes(frame, poses, occlusion=True))


@pytest.mark.parametrize("lean", [0.8, -0.8])
def test_what_hangs_on_a_link_tells_which_way_it_leans(finder, lean):
    truth = pose(0.0, 0.05, 0.7, 0.2, model=arm(), joints={"upper": lean, "fore": 0.9})
    wrong = pose(0.0, 0.05, 0.7, 0.2, model=arm(), joints={"upper": -lean, "fore": -1.3})
    frame = ImageFrame(LabelField(render(CAMERA, [(arm(), truth, RED)])), CAMERA)
    found = ranked(finder, frame, wrong)
    better = finder.rebent(frame, found, Climb(1, 4, 1.0))
    best = ranked(finder, frame, truth).votes[0]
    assert found.votes[0] < 0.8 * best
    assert better.votes[0] > 0.95 * best and len(better) == 2
    np.testing.assert_allclose(better.poses.q[0], truth.q[0], atol=0.08)
    assert finder.rebent(frame, better[:1], Climb(1, 4, 1.0)).votes[0] == better.votes[0]  # nothing is lacking any more


def test_joints_at_the_end_of_a_chain_are_left_to_the_climb():
    surface = WholeObjectFinder(Target("truck", truck(), RED), DEFAULTS).surface
    rebends = Rebends(surface, surface.kinematics.grids(0.25))
    assert not len(rebends.joints(np.ones(3, bool)))  # each leg has a joint of its own
    surface = WholeObjectFinder(Target("arm", arm(), RED), DEFAULTS).surface
    rebends = Rebends(surface, surface.kinematics.grids(0.25))
    assert rebends.joints(np.array([False, False, True])).tolist() == [0]
    assert rebends.joints(np.array([False, True, False])).tolist() == []
