"""A base that is turned by itself below what stands on it: its own outline alone tells how, and the joint gives way."""

import cv2
import numpy as np
import pytest
from settings import DEFAULTS
from solids import (
    BLUE,
    BODY,
    CAB,
    FRONT,
    GATE,
    LEFT_SIDE,
    RED,
    RIGHT_SIDE,
    camera_of,
    marker,
    rectangle,
    render,
    truck,
    turn_between,
)

from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_turns import likelier_turns
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.turned_alone import turned_alone

CAMERA = camera_of((640, 480), 600.0)


def crane():
    """A base with a patch on three of its sides, and a turret on it."""
    base = Component(
        "base",
        (
            marker("right", CAB, RIGHT_SIDE, (0, -0.0805, 0.05)),
            marker("left", CAB * (-1, 1), LEFT_SIDE, (0, 0.0805, 0.05)),
            marker("front", GATE, FRONT, (0.1105, 0, 0.05)),
        ),
        required=True,
        bodies=(Box(Pose.from_xyz_rpy((0, 0, 0.05)), np.array([0.22, 0.16, 0.1])),),
        body_label=BODY,
    )
    sides = (("right", RIGHT_SIDE, (0.0, -0.0505, 0.05)), ("left", LEFT_SIDE, (0.0, 0.0505, 0.05)))
    turret = Component(
        "turret",
        (
            *(marker(name, GATE * (0.9, 0.8), R, at) for name, R, at in sides),
            marker("front", rectangle(0.05, 0.04), FRONT, (0.0605, 0, 0.05)),
        ),
        label=BLUE,
        joint=Joint("base", Pose.from_xyz_rpy((0, 0, 0.105)), np.array([0, 0, 1.0]), -1.5, 1.5),
        bodies=(Box(Pose.from_xyz_rpy((0, 0, 0.05)), np.array([0.12, 0.1, 0.1])),),
        body_label=BODY,
    )
    return ObjectModel("crane", (base, turret))


MODEL = crane()


def placed(heading, swing):
    """Seen from a little above."""
    view = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    R = rotation_from_rotvec([0.35, 0, 0]) @ view @ rotation_from_rotvec([0, 0, heading])
    return Poses(R[None], np.array([[0.0, 0.05, 0.9]]), np.array([[swing]]))


def scene(at, covered=0.0):
    """A finder and a picture, in which something unknown lies over such a share of the base's right side."""
    labels = render(CAMERA, [(MODEL, at, RED)])
    if covered:
        low = np.array([(x, -0.081, z) for x in (-0.12, -0.12 + 0.24 * covered) for z in (0.0, 0.1)])
        hull = cv2.convexHull(project(CAMERA, low @ at.R[0].T + at.t[0]).astype(np.float32))
        cv2.fillConvexPoly(labels, np.rint(hull).astype(np.int32), int(labels[0, 0]))
    return WholeObjectFinder(Target("crane", MODEL, RED), DEFAULTS), ImageFrame(LabelField(labels), CAMERA)


def turned(at, by):
    """A pose whose base is turned by itself."""
    return Poses(at.R @ rotation_from_rotvec([0, 0, by]), at.t, at.q - by)


@pytest.mark.parametrize("covered", [0.0, 0.4])
@pytest.mark.parametrize("by", [0.7, -0.8])
def test_a_base_that_is_turned_wrong_is_turned_below_what_stands_on_it(by, covered):
    at = placed(0.4, 0.2)
    finder, frame = scene(at, covered)
    told, others = likelier_turns(finder, frame, turned(at, by))
    assert turn_between(told.R[0], at.R[0]) < 0.05 and abs(told.q[0, 0] - 0.2) < 0.05
    assert others == [None] or others[0].probability < 0.5


def test_what_stands_on_it_stays_where_it_is_and_the_joint_within_its_limits():
    at = placed(0.4, 0.2)
    finder, frame = scene(at)
    others, of = turned_alone(finder, frame, turned(at, 0.7))
    assert len(others) and (of == 0).all()
    kin = finder.surface.kinematics
    was, now = (kin.forward(p.R, p.t, p.q) for p in (at, others))
    assert now.t[:, 1] == pytest.approx(np.repeat(was.t[:, 1], len(others), axis=0), abs=0.02)
    assert (others.q >= kin.lower).all() and (others.q <= kin.upper).all()


def test_a_sure_pose_stays():
    at = placed(0.4, 0.2)
    finder, frame = scene(at)
    told, others = likelier_turns(finder, frame, at)
    assert (told.R == at.R).all() and others == [None]


def test_what_holds_on_by_several_joints_tells_how_it_is_turned():
    model = truck()
    at = Poses(np.array([[[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]]), np.array([[0.0, 0.0, 0.8]]), np.array([[0.2, -0.3]]))
    frame = ImageFrame(LabelField(render(CAMERA, [(model, at, RED)])), CAMERA)
    others, _ = turned_alone(WholeObjectFinder(Target("truck", model, RED), DEFAULTS), frame, at)
    assert not len(others)
