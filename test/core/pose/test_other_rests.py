"""What something unknown covers of a marker does not move an object of which others tell where it is."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, chain, covered, pose, render, turn_between

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_rests import likelier_rests
from artrec_ros.core.pose.poses import Poses

CAMERA = camera_of((640, 480), 600.0)
MODEL = chain()
AT = pose(0, 0, 0.8, 0.3, 0.1, MODEL)


def scene(share: float):
    """The finder, and a picture in which something unknown hides so much of the base's marker."""
    finder = WholeObjectFinder(Target(MODEL.name, MODEL, RED), DEFAULTS)
    labels = covered(render(CAMERA, [(MODEL, AT, RED)]), CAMERA, AT, MODEL, share)
    return finder, ImageFrame(LabelField(labels), CAMERA)


def off(poses) -> tuple[float, float]:
    """Of the place, as a share of the range, and of the turn, radians."""
    return float(np.linalg.norm(poses.t[0] - AT.t[0]) / AT.t[0, 2]), float(turn_between(poses.R[0], AT.R[0]))


def used_by(finder, frame, poses):
    return finder.voter.supported(finder.voter.judge(frame, poses, occlusion=True))


def test_a_marker_that_seems_to_end_is_told_by_the_others():
    finder, frame = scene(0.45)
    used = used_by(finder, frame, AT)
    wrong = Poses(AT.R, AT.t * 1.03, AT.q)  # as if what is left of it were all of it
    told, used_there, _ = likelier_rests(finder, frame, wrong, used)
    assert off(told)[0] < 0.005 and off(told)[1] < 0.02
    assert (used_there == used).all()


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_what_rests_where_it_is_stays(share):
    finder, frame = scene(share)
    told, _, (other,) = likelier_rests(finder, frame, AT, used_by(finder, frame, AT))
    assert off(told)[0] < 0.005
    assert other is None or np.linalg.norm(other.pose.position - AT.t[0]) < 0.01


def test_without_others_nothing_tells():
    finder, frame = scene(0.45)
    used = used_by(finder, frame, AT) & (np.arange(5) < 2)
    wrong = Poses(AT.R, AT.t * 1.03, AT.q)
    told, same, others = likelier_rests(finder, frame, wrong, used)
    assert off(told) == off(wrong) and same is used and others == [None]
