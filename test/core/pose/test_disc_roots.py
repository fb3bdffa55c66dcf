"""Objects whose required component is a disc: it tells no direction, and what stands on it is looked for in all."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, RIGHT_SIDE, camera_of, marker, rectangle, render, turn_between

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.seeds import Seeds
from artrec_ros.core.recognizer import Recognizer

CAMERA = camera_of((640, 480), 560.0)
ANGLES = 2 * np.pi * np.arange(48) / 48
FOOT = 0.06 * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])


def lamp(*, disc: bool = True) -> ObjectModel:
    """A foot, an arm that swings, an arm on that one, of one class. :param disc: what its foot is said to be."""
    at = Pose(np.eye(3), np.array([0.03, 0.0, 0.0]))  # not amid the object's frame
    foot = Marker("foot", FOOT, FOOT.min(axis=0), FOOT.max(axis=0), 0.06 if disc else None, at)
    arms, parent, up = [], "foot", 0.03
    for name, limit in (("lower", 0.7), ("upper", 1.5)):
        shape = marker(name, rectangle(0.02, 0.2), RIGHT_SIDE, (0.03 * (parent == "foot"), -0.01, 0.12))
        joint = Joint(parent, Pose.from_xyz_rpy((0, 0, up)), np.array([0.0, 1.0, 0.0]), -limit, limit)
        arms.append(Component(name, (shape,), label=4, joint=joint))
        parent, up = name, 0.22
    return ObjectModel("lamp", (Component("foot", (foot,), required=True), *arms))


def standing(heading: float, lower: float = 0.3, upper: float = -0.8) -> Poses:
    """Seen from above by some thirty degrees. :param heading: about the vertical; at 0 the arms face the camera."""
    upright = np.column_stack([(1, 0, 0), (0, 0, 1), (0, -1, 0)])
    R = rotation_from_rotvec([0.5, 0, 0]) @ upright @ rotation_from_rotvec([0, 0, heading])
    return Poses(R[None], np.array([[0.05, 0.15, 1.1]]), np.array([[lower, upper]]))


@pytest.mark.parametrize("heading", np.linspace(-1.2, 1.2, 9))
def test_a_lamp_on_a_round_foot_is_found_whichever_way_it_is_turned(heading):
    at = standing(heading)
    labels = render(CAMERA, [(lamp(), at, RED)])
    (found,) = (
        Recognizer([Target("lamp", lamp(), RED)], DEFAULTS, Segmenter(ImageConfig()))
        .recognize(labels, CAMERA)
        .detections
    )
    assert turn_between(found.pose.rotation, at.R[0]) < 0.08
    assert {c.component for c in found.components} == {"foot", "lower", "upper"}


@pytest.mark.parametrize("heading", [-2.6, -0.7, 0.0, 0.4, 1.9])
def test_from_a_disc_all_directions_are_begun_with(heading):
    model, at = lamp(), standing(heading)
    finder = WholeObjectFinder(Target("lamp", model, RED), DEFAULTS)
    frame = ImageFrame(LabelField(render(CAMERA, [(model, at, RED)])), CAMERA)
    (blob,) = find_blobs(frame.field.labels, {RED}, DEFAULTS)
    seeds = Seeds(finder.target, finder.surface, DEFAULTS)
    for poses in (seeds.few(frame, blob), seeds.all(frame, blob)):
        near = [k for k, R in enumerate(poses.R) if turn_between(R, at.R[0]) < 0.15]
        assert near and np.linalg.norm(poses.t[near] - at.t, axis=1).min() < 0.04
        middles = poses.R[near] @ [0.03, 0, 0] + poses.t[near]
        assert np.linalg.norm(middles - (at.R[0] @ [0.03, 0, 0] + at.t), axis=1).min() < 0.03


def test_what_is_no_disc_is_turned_as_its_outline_says():
    model = lamp(disc=False)
    finder = WholeObjectFinder(Target("lamp", model, RED), DEFAULTS)
    frame = ImageFrame(LabelField(render(CAMERA, [(model, standing(0.4), RED)])), CAMERA)
    (blob,) = find_blobs(frame.field.labels, {RED}, DEFAULTS)
    assert len(Seeds(finder.target, finder.surface, DEFAULTS).few(frame, blob)) <= DEFAULTS.guesses.few_keep
