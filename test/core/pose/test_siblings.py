"""Like components that hang on what is not seen: which of them one is."""

import numpy as np
import pytest
from settings import settings
from solids import RED, camera_of, marker, rectangle, render

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer

CAMERA = camera_of((640, 480), 600.0)
TOWARDS = np.diag([1.0, -1.0, -1.0])
BODY = np.array([[-0.08, -0.05], [0.08, -0.05], [0.1, 0.0], [0.08, 0.05], [-0.08, 0.05]])
UPPER, FORE = rectangle(0.09, 0.03), rectangle(0.09, 0.03)


def arms(*shown: str) -> ObjectModel:
    """A body with two arms of two halves, of which these have markers in view: others' are not drawn."""
    z, parts = (
        np.array([0.0, 0.0, 1.0]),
        [Component("body", (marker("body", BODY, np.eye(3), (0, 0, 0)),), required=True)],
    )
    for name, x in (("left", -0.05), ("right", 0.05)):
        shoulder = Joint("body", Pose(np.eye(3), np.array([x, 0.06, 0.0])), z, -0.5, np.pi + 0.5)
        elbow = Joint(f"{name}_upper", Pose(np.eye(3), np.array([0.12, 0.0, 0.0])), z, -2.2, 2.2)
        for half, outline, joint in (("upper", UPPER, shoulder), ("fore", FORE, elbow)):
            parts.append(Component(f"{name}_{half}", (marker("m", outline, np.eye(3), (0.06, 0, 0)),), joint=joint))
    return ObjectModel("arms", tuple(parts)) if not shown else _drawn(tuple(parts), shown)


def _drawn(parts, shown):
    """The same with specks in place of those that are not to be seen."""
    none = marker("m", 0.02 * UPPER, np.eye(3), (0.06, 0, 0))
    kept = ("body", *shown)
    return ObjectModel("arms", tuple(p if p.name in kept else Component(p.name, (none,), joint=p.joint) for p in parts))


def found(*shown: str, q, camera=CAMERA):
    pose = Poses(TOWARDS[None], np.array([[0.0, 0.12, 0.8]]), np.array([q], float))
    image = render(CAMERA, [(arms(*shown), pose, RED)])
    scale = {} if camera is not None else dict(min_scale=550.0, max_scale=950.0)
    engine = Recognizer((Target("arms", arms(), RED),), settings(**scale), Segmenter(ImageConfig()))
    (told,) = engine.recognize(image, camera).detections
    return {c.component: c.score for c in told.components}, told


@pytest.mark.parametrize("camera", [CAMERA, None], ids=["space", "flat"])
def test_a_lone_fore_arm_between_both_arms_may_be_either_ones(camera):
    scores, told = found("left_fore", q=[1.2, 0.3, 2.0, 0.4], camera=camera)
    (fore,) = {"left_fore", "right_fore"} & set(scores)
    assert 0.35 < scores[fore] < 0.7 and told.score > 0.9
    assert max(told.joint_deviations.values()) > 0.3 if camera is not None else True


@pytest.mark.parametrize("shown", [("left_upper", "left_fore"), ("left_upper", "left_fore", "right_fore")], ids=len)
def test_a_fore_arm_on_its_upper_arm_is_sure(shown):
    scores, _ = found(*shown, q=[2.2, 0.5, 0.6, -0.4])
    assert set(scores) == {"body", *shown} and min(scores.values()) > 0.85


def test_a_fore_arm_that_the_other_one_does_not_reach_is_sure():
    scores, _ = found("left_fore", q=[3.2, -0.3, 0.5, 0.4])
    assert set(scores) == {"body", "left_fore"} and min(scores.values()) > 0.85
