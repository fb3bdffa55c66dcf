"""Of a body with like legs half a turn leaves all about where it was: what is seen where tells them apart, and what
frames before told of it."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import BACKGROUND, BLUE, RED, camera_of, marker, rectangle, render, turn_between

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.memory.recall import Recall
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_turns import likelier_turns
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.turn_evidence import evidence
from artrec_ros.core.pose.turns_in_place import turned_in_place
from artrec_ros.core.spatial_stage import SpatialStage
from artrec_ros.core.verdict import at_rest

CAMERA = camera_of((640, 480), 560.0)
BODY_TOP = [(-0.08, -0.034), (0.08, -0.028), (0.08, 0.028), (-0.08, 0.034)]
FROM_ABOVE = np.array([[0, 1, 0], [0.6, 0, -0.8], [-0.8, 0, -0.6]], float)
BENDS = [0.2, -0.1, -0.15, 0.25, 0.1, -0.2]
ONE_LEG = 40  # pixels around its middle, that hide it


def crawler():
    """A body that is a little narrower in front, and three like legs on either side."""
    parts = [Component("body", (marker("top", BODY_TOP, np.eye(3), (0, 0, 0.03)),), required=True)]
    for n, x in (("front", 0.075), ("middle", 0.0), ("hind", -0.075)):
        for side, y in (("left", 1), ("right", -1)):
            hinge = Joint("body", Pose.from_xyz_rpy((x, 0.045 * y, 0)), np.array([0.0, 0.0, 1.0]), -0.3, 0.3)
            turn = np.array([[0, -y, 0], [y, 0, 0], [0, 0, 1]], float)
            leg = marker("leg", rectangle(0.068, 0.02), turn, (0, 0.05 * y, 0))
            parts.append(Component(f"{n}_{side}", (leg,), label=BLUE, joint=hinge))
    return ObjectModel("crawler", tuple(parts))


MODEL = crawler()
TARGET = Target("crawler", MODEL, RED)
TRUE = Poses((FROM_ABOVE @ rotation_from_rotvec([0, 0, 0.8]))[None], np.array([[0.0, 0.0, 0.9]]), np.array([BENDS]))


def scene(hidden=()):
    """:param hidden: legs that are not seen."""
    labels, finder = render(CAMERA, [(MODEL, TRUE, RED)]), WholeObjectFinder(TARGET, DEFAULTS)
    at = finder.through_middles.places(TRUE, finder.surface.markers)[0]
    for leg in hidden:
        x, y = (CAMERA.matrix[:2] @ (at[leg] / at[leg, 2])).round().astype(int)
        near = np.hypot(*np.ogrid[-y : labels.shape[0] - y, -x : labels.shape[1] - x][::-1]) < ONE_LEG
        labels[near & (labels == BLUE)] = BACKGROUND
    return finder, ImageFrame(LabelField(labels), CAMERA)


def half_turned(finder, frame):
    """The other turn of the true pose, at rest."""
    rivals = turned_in_place(finder, frame, TRUE)
    (row,) = [n for n, R in enumerate(rivals.poses.R) if turn_between(R, TRUE.R[0]) > 3]
    return rivals.poses[row : row + 1], float(rivals.log_odds[row])


@pytest.mark.parametrize("leg", [1, 6])
def test_one_hidden_leg_leaves_what_contours_tell(leg):
    """It is another one's under each turn, but none that either has in its place lacks an edge for that."""
    finder, frame = scene([leg])
    turned, odds = half_turned(finder, frame)
    assert evidence(finder, frame, TRUE, turned, exchanged=True).contours[0] < -2
    assert evidence(finder, frame, turned, TRUE, exchanged=True).contours[0] > 2
    assert odds < -3
    told, _ = likelier_turns(finder, frame, turned)
    assert turn_between(told.R[0], TRUE.R[0]) < 0.1


def test_what_was_known_before_has_no_more_for_it_in_each_frame_anew():
    finder, frame = scene([1])
    _, new = half_turned(finder, frame)
    for known in (TRUE, half_turned(finder, frame)[0]):
        _, odds = half_turned(finder, frame.expecting({"crawler": (known.R, known.t, known.q)}))
        assert odds == pytest.approx(new + 1.5)


def test_what_leaps_tells_whence():
    """However sure one frame is."""
    finder, frame = scene()
    turned, odds = half_turned(finder, frame)
    assert odds < -4 and likelier_turns(finder, frame, TRUE)[1] == [None]
    known = frame.expecting({"crawler": (turned.R, turned.t, turned.q)})
    told, (other,) = likelier_turns(finder, known, TRUE)
    assert turn_between(told.R[0], TRUE.R[0]) < 0.1
    assert other is not None and other.probability < 0.1
    assert turn_between(other.pose.rotation, turned.R[0]) < 0.1


def test_memory_keeps_what_is_told(monkeypatch):
    """It would follow what was found, and turn it in each frame anew."""
    finder, frame = scene()
    turned, _ = half_turned(finder, frame)
    monkeypatch.setattr(at_rest, "likelier_turns", lambda finder, frame, poses: (turned, [None]))
    recall, blobs = Recall(), find_blobs(frame.field.labels, {RED, BLUE}, DEFAULTS)
    (told,) = SpatialStage((TARGET,), DEFAULTS).recognize(frame, blobs, recall).detections
    assert turn_between(told.pose.rotation, turned.R[0]) == 0
    (known,) = recall.left(frame.size, CAMERA).known["crawler"]
    assert turn_between(known.R, turned.R[0]) == 0
