"""What is said of an object a part of which, between others that are seen, is not."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from legs import ANKLE, HIP, KNEE, PX_PER_M, RADIUS, SIZE, TOE, along, disc
from settings import settings

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

HALF, THIGH, SHANK, ARM = np.array([0.25, 0.1]), 0.5, 0.5, 0.4  # metres
FRONT, MIDDLE, TURN = 0.3, np.array([180.0, 150.0]), 0.3
PLATE = HALF * [[-1, -1], [1, -1], [1, 1], [-1, 1]]


def swings(name, parent, at):
    return Joint(parent, along(at), np.array([0.0, 0.0, 1.0]), -1.5, 1.5, name=name)


def robot(with_arm):
    """A plate, which tells its direction; a knee and an ankle before it, an arm behind."""
    plate = Marker("plate", PLATE, np.array([-HALF[0], 0.0]), np.array([HALF[0], 0.0]), None, along(0.0))
    parts = [
        Component("hip", (plate,), required=True),
        Component("knee", (disc(THIGH),), label=KNEE, joint=swings("knee_angle", "hip", FRONT)),
        Component("ankle", (disc(SHANK),), label=ANKLE, joint=swings("ankle_angle", "knee", THIGH)),
    ]
    if with_arm:
        parts.append(Component("arm", (disc(ARM),), label=TOE, joint=swings("arm_angle", "hip", -FRONT)))
    return Target("robot", ObjectModel("robot", tuple(parts)), HIP)


def picture(knee, ankle, hidden):
    labels = np.zeros(SIZE[::-1], np.uint8)
    c, s = np.cos(TURN), np.sin(TURN)
    outline = MIDDLE + PX_PER_M * PLATE @ np.array([[c, s], [-s, c]])
    cv2.fillPoly(labels, [np.rint(16 * outline).astype(np.int32)], HIP, shift=4)
    turns = TURN + np.array([0.0, knee, knee + ankle])
    steps = np.array([FRONT, THIGH, SHANK])[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
    for label, at in zip((KNEE, ANKLE), (MIDDLE + PX_PER_M * np.cumsum(steps, axis=0))[1:], strict=True):
        if label != hidden:
            cv2.circle(labels, np.rint(16 * at).astype(int).tolist(), int(160 * RADIUS * 10), int(label), -1, shift=4)
    return labels


@pytest.mark.parametrize("hidden", [None, KNEE])
@pytest.mark.parametrize("with_arm", [False, True])
def test_a_way_to_bend_what_is_not_told_costs_no_probability(hidden, with_arm):
    """An arm that is not seen may hang in any way; so may a knee, of which no joint is told."""
    limits = {"time_budget_ms": 60000.0, "min_scale": 85.0, "max_scale": 118.0}
    engine = Recognizer((robot(with_arm),), settings(**limits), Segmenter(ImageConfig()), calibrated=False)
    (found,) = engine.recognize(picture(0.6, -1.0, hidden), None).detections
    assert found.score > 0.97 and found.as_told == 1.0
    assert set(found.joints) == (set() if hidden else {"knee_angle", "ankle_angle"})
    assert np.cos(found.image.theta - TURN) > 0.99
