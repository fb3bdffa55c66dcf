"""Objects on a floor that lean little: what a search finds leaning is turned upright before it is refused."""

from __future__ import annotations

import numpy as np
import pytest
from solids import BLUE, RED, camera_of, pose, render

from artrec_ros.core.base.config import FloorConfig, ImageConfig, RecognizerConfig, SceneConfig
from artrec_ros.core.geometry.floor import Floor
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.objects.solids import ball_solid

CAMERA, PITCH_DEG, GREEN = camera_of((640, 480), 600.0), 25.0, 5
FLOOR = FloorConfig(
    camera_height_m=1.0, camera_pitch_deg=PITCH_DEG, object_height_m=0.35, height_tolerance_m=0.2, max_tilt_deg=3.0
)
DOWN = rotation_from_rotvec(np.radians([PITCH_DEG, 0, 0]))


def ball(name, radius, z, label, joint=None):
    sides, bodies = ball_solid(radius, Pose.from_xyz_rpy((0, 0, z)))
    return Component(name, sides, joint is None, label=label, joint=joint, bodies=bodies)


def joint(parent, z, axis):
    return Joint(parent, Pose.from_xyz_rpy((0, 0, z)), np.array(axis, float), -1.6, 1.6)


ARM = ObjectModel(
    "arm",
    (
        ball("base", 0.07, 0, RED),
        ball("elbow", 0.05, 0.2, BLUE, joint("base", 0.05, (1, 0, 0))),
        ball("hand", 0.04, 0.2, GREEN, joint("elbow", 0.2, (0, 1, 0))),
    ),
)


def standing(heading, joints):
    at = pose(0.05, 0.15, 1.2, heading, model=ARM, joints=dict(zip(ARM.joint_names, joints, strict=True)))
    return Poses((DOWN @ at.R[0])[None], at.t, at.q)


@pytest.mark.parametrize(("heading", "joints"), [(0.0, (0.5, -0.6)), (0.0, (0.3, 0.9)), (0.8, (0.3, 0.9))])
def test_an_arm_of_balls_is_found_by_how_little_it_leans(heading, joints):
    at = standing(heading, joints)
    config = RecognizerConfig(time_budget_ms=60000.0, scene=SceneConfig(floor=FLOOR))
    recognizer = Recognizer([Target("arm", ARM, RED)], config, Segmenter(ImageConfig()))
    (one,) = recognizer.recognize(render(CAMERA, [(ARM, at, RED)]), CAMERA).detections
    assert np.linalg.norm(one.pose.position - at.t[0]) < 0.01
    assert Floor.of(FLOOR).tilts_deg(one.pose.rotation[None])[0] <= FLOOR.max_tilt_deg


def test_what_leans_is_turned_about_its_required_component_to_the_limit_and_what_stands_is_not():
    finder = WholeObjectFinder(Target("arm", ARM, RED), RecognizerConfig())
    frame = ImageFrame(LabelField(np.zeros((480, 640), np.uint8)), CAMERA, scene=Scene(floor=Floor.of(FLOOR)))
    upright, by = standing(0.4, (0.2, 0.1)), np.radians([[2.0, 0, 0], [40.0, 10, 20]])
    R = rotation_from_rotvec(by) @ upright.R
    leaning = Poses(R, np.repeat(upright.t, 2, axis=0), np.repeat(upright.q, 2, axis=0))
    turned = finder.upright.of(frame, leaning)
    assert len(turned) == 1
    np.testing.assert_allclose(finder.required.anchors(turned), finder.required.anchors(leaning)[1:])
    assert frame.scene.stand(turned.R, turned.t).all()
    assert frame.scene.floor.tilts_deg(turned.R)[0] == pytest.approx(FLOOR.max_tilt_deg, rel=0.01)
