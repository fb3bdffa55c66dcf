"""Like markers that lie on each other: each pixel is explained once."""

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import RED, camera_of, marker, rectangle, render

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer

CAMERA = camera_of((640, 480), 600.0)
TOWARDS = np.diag([1.0, -1.0, -1.0])
FOOT = rectangle(0.08, 0.04)
TORSO = np.array(
    [[-0.1, -0.06], [0.1, -0.06], [0.1, 0.1], [0.02, 0.1], [0.02, 0.16], [-0.06, 0.16], [-0.06, 0.1], [-0.1, 0.1]]
)


def legs(*feet: str) -> ObjectModel:
    """A torso with a left and a right leg, of which these have feet."""
    parts = [Component("torso", (marker("torso", TORSO, np.eye(3), (0, 0, 0)),), required=True)]
    for name, x in (("left", -0.03), ("right", 0.03)):
        if name in feet:
            hip = Joint("torso", Pose(np.eye(3), np.array([x, -0.05, 0.0])), np.array([0.0, 0.0, 1.0]), -1.2, 1.2)
            parts.append(Component(name, (marker("foot", FOOT, np.eye(3), (0, -0.18, 0)),), joint=hip))
    return ObjectModel("legs", tuple(parts))


BOTH = legs("left", "right")


def standing(*hips: float, turn: float = 0.0) -> Poses:
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ TOWARDS
    return Poses(R[None], np.array([[0.02, -0.05, 0.75]]), np.array([hips], float).reshape(1, -1))


def scores(image, pose):
    finder = WholeObjectFinder(Target("legs", BOTH, RED), DEFAULTS)
    frame = ImageFrame(LabelField(image), CAMERA)
    said = finder.voter.judge(frame, pose, occlusion=True)
    return said, float(finder.voter.total(said)[0]), float(finder.voter.votes(frame, pose, occlusion=True)[0])


def test_of_two_feet_on_one_blob_one_counts():
    image = render(CAMERA, [(legs("right"), standing(0.2), RED)])
    (away, _, alone), (over, _, both) = (scores(image, standing(left, 0.2)) for left in (-0.8, 0.56))
    assert over.votes[0, 2] == pytest.approx(away.votes[0, 2]) and over.agree[0, 2] > 0.95
    assert over.votes[0, 1] < 0.05 * over.votes[0, 2]
    assert both < 1.01 * alone


def test_what_is_counted_in_a_climb_is_counted_in_the_end():
    image = render(CAMERA, [(BOTH, standing(-0.5, 0.4), RED)])
    for hips in ((-0.5, 0.4), (0.3, 0.2), (0.52, 0.2)):
        _, told, climbed = scores(image, standing(*hips))
        assert told == pytest.approx(climbed, rel=0.02)


def test_feet_that_are_both_there_lose_only_what_they_share():
    for left, least in ((-0.6, 0.95), (0.0, 0.6)):
        pose = standing(left, 0.2)
        said, _, _ = scores(render(CAMERA, [(BOTH, pose, RED)]), pose)
        assert said.agree[0, 1:].min() > 0.9 and said.votes[0, 1:].min() > 0
        assert said.area_px[0, 1:].min() > least * said.area_px[0, 1:].max()


@pytest.mark.parametrize("camera", [CAMERA, None], ids=["space", "flat"])
@pytest.mark.parametrize("missing", ["left", "right"])
@pytest.mark.parametrize("turn, hip", [(0.3, 0.2), (-0.4, -0.3), (0.1, 0.45)])
def test_a_leg_that_is_not_seen_is_not_told_on_the_other_ones_foot(camera, missing, turn, hip):
    (other,) = {"left", "right"} - {missing}
    image = render(CAMERA, [(legs(other), standing(hip, turn=turn), RED)])
    scale = {} if camera is not None else dict(min_scale=600.0, max_scale=1000.0)
    engine = Recognizer((Target("legs", BOTH, RED),), settings(**scale), Segmenter(ImageConfig()))
    (found,) = engine.recognize(image, camera).detections
    assert {c.component for c in found.components} == {"torso", other}
