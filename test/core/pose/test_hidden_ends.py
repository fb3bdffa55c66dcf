"""A tape on an arm of which something unknown hides the end is not told tilted, as sure as if all of it were seen."""

import cv2
import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, marker, rectangle, render, turn_between

from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_rests import likelier_rests
from artrec_ros.core.pose.poses import Poses

CAMERA, BLUE = camera_of((640, 480), 600.0), 5
UPPER, LOWER = rectangle(0.2, 0.04), rectangle(0.14, 0.035, (0.08, 0))


def arm() -> ObjectModel:
    """Two tapes and the joint between them."""
    elbow = Joint("upper", Pose(np.eye(3), np.array([0.11, 0.0, 0.0])), np.array([0, 0, 1.0]), -1.8, 1.8)
    upper = Component("upper", (marker("tape", UPPER, np.eye(3), (0, 0, 0)),), required=True)
    return ObjectModel(
        "arm", (upper, Component("lower", (marker("tape", LOWER, np.eye(3), (0, 0, 0)),), False, BLUE, elbow))
    )


def placed(tilt: float, heading: float) -> Poses:
    """A metre before the camera, looked at from straight ahead but for a tilt."""
    R = rotation_from_rotvec([np.pi + tilt, 0.0, 0.0]) @ rotation_from_rotvec([0.0, 0.0, heading])
    return Poses(R[None], np.array([[-0.05, 0.0, 0.9]]), np.array([[0.7]]))


MODEL = arm()


def scene(at: Poses, hidden_m: float):
    """The finder, and a picture in which something unknown hides so much of the upper tape's free end, slantwise."""
    labels = render(CAMERA, [(MODEL, at, RED)])
    if hidden_m:
        cut = np.array([(-0.2, -0.1), (-0.1 + hidden_m - 0.012, -0.1), (-0.1 + hidden_m + 0.012, 0.1), (-0.2, 0.1)])
        corners = np.column_stack([cut, np.zeros(4)]) @ at.R[0].T + at.t[0]
        cv2.fillPoly(labels, [np.rint(project(CAMERA, corners)).astype(np.int32)], int(labels[0, 0]))
    return WholeObjectFinder(Target("arm", MODEL, RED), DEFAULTS), ImageFrame(LabelField(labels), CAMERA)


def best_fit(finder, frame, at: Poses) -> Poses:
    """Where fits to all contours come to rest that begin slanted along the tape, the one with most votes."""
    along = at.R[0] @ (0.0, 1.0, 0.0)
    begun = Poses.concatenate([
        Poses(rotation_from_rotvec(slant * along) @ at.R, at.t, at.q) for slant in (-1.0, -0.7, 0.7, 1.0)
    ])  # fmt: skip
    for _ in range(4):
        begun = finder.fit_all(frame, begun).best(4, DEFAULTS.search).poses
    return begun[:1]


@pytest.mark.parametrize("heading", [0.3, 1.9])
def test_what_a_hidden_end_makes_look_slanted_is_told_as_it_is_or_in_doubt(heading):
    at = placed(0.3, heading)
    finder, frame = scene(at, 0.07)
    wrong = best_fit(finder, frame, at)
    assert turn_between(wrong.R[0], at.R[0]) > 0.5
    told, _, (other,) = likelier_rests(finder, frame, wrong, finder.voter.supports(frame, wrong))
    right = [turn_between(R, at.R[0]) < 0.15 for R in (told.R[0], *([] if other is None else [other.pose.rotation]))]
    assert any(right) and (right[0] or other.probability > 0.3)


@pytest.mark.parametrize("tilt", [0.1, 0.3, 0.6])
@pytest.mark.parametrize("heading", [0.3, 1.9, -2.6])
def test_of_what_is_wholly_seen_no_end_is_hidden(heading, tilt):
    at = placed(tilt, heading)
    finder, frame = scene(at, 0.0)
    told, _, (other,) = likelier_rests(finder, frame, at, finder.voter.supports(frame, at))
    assert (told.R == at.R).all() and (other is None or other.probability < 0.15)
