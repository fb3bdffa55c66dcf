"""Objects of one class that overlap until their markers are one blob, in images in which nothing else is known."""

import numpy as np
from settings import settings
from solids import RED, camera_of, marker, rectangle, render
from test_spatial_stage import agrees

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer

CAMERA = camera_of((640, 480), 600.0)
PALM = np.array([(-0.05, -0.06), (0.05, -0.06), (0.06, 0.02), (0.03, 0.06), (-0.05, 0.06)])


def hand():
    """Three fingers about a palm, in its plane."""
    up = np.eye(3)
    palm = Component("palm", (marker("face", PALM, up, (0, 0, 0)),), required=True)
    fingers = []
    for name, x, y, angle in (("thumb", 0.058, 0.0, -0.2), ("index", 0.025, 0.065, 1.4), ("little", -0.03, 0.065, 1.7)):
        turn = rotation_from_rotvec([0.0, 0.0, angle])
        joint = Joint("palm", Pose(turn, np.array([x, y, 0.0])), np.array([0.0, 0.0, 1.0]), -0.4, 0.4)
        fingers.append(
            Component(name, (marker("face", rectangle(0.08, 0.022, (0.045, 0)), up, (0, 0, 0)),), joint=joint)
        )
    return ObjectModel("hand", (palm, *fingers))


TARGET = Target("hand", hand(), RED)


def laid(x, y, z, turn, joints):
    """Face to the camera."""
    R = rotation_from_rotvec([0.15, 0.1, 0.0]) @ np.diag([1.0, -1.0, -1.0]) @ rotation_from_rotvec([0.0, 0.0, turn])
    return Poses(R[None], np.array([[x, y, z]]), np.array(joints)[None])


def scenes(count=20):
    """Two or three at one place, most of them in one blob or two."""
    rng = np.random.default_rng(0)
    for _ in range(count):
        yield [
            laid(*rng.uniform(-0.08, 0.08, 2), rng.uniform(0.55, 0.7), rng.uniform(-3, 3), rng.uniform(-0.35, 0.35, 3))
            for _ in range(int(rng.integers(2, 4)))
        ]


def found(**values):
    """So many of them, with all that is told of them right."""
    recognizer, count = Recognizer([TARGET], settings(**values), Segmenter(ImageConfig())), 0
    for scene in scenes():
        labels = render(CAMERA, [(TARGET.model, at, RED) for at in scene], 0)
        told = recognizer.recognize(labels, CAMERA).detections
        count += sum(any(agrees(TARGET.model, d, at) for d in told) for at in scene)
    return count


def test_large_blobs_are_searched_for_the_objects_that_make_them_up():
    count = found()
    assert count >= 21  # of 50, many of them all but hidden
    assert count > found(pieces=0)


def test_a_mask_without_a_background_is_no_room_for_huge_objects():
    """As long as unknown pixels say little wherever they are, a huge palm covers several small ones; what lay on one of
    them is kept aside, but not always found again."""
    assert found() >= found(inside_empty=settings().votes.inside[1]) + 2
