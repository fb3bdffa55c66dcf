"""A small object with known places: a block with a patch in front and one arm that swings about y."""

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.simulation.simulator import pinhole_camera

FORWARD = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], float)  # marker frame on a face that looks along +x
RIGHTWARD = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)  # on a face that looks along -y


def square(side, name="patch", place=None):
    h = side / 2
    outline = np.array([[-h, -h], [h, -h], [h, h], [-h, h]])
    return Marker(name, outline, np.array([-h, 0.0]), np.array([h, 0.0]), T_component_marker=place)


@pytest.fixture
def model():
    block = Component(
        "base",
        (square(0.08, "front", Pose(FORWARD, np.array([0.0505, 0, 0]))),),
        required=True,
        bodies=(Box(Pose.identity(), np.array([0.1, 0.1, 0.1])),),
        body_label=5,
    )
    ribbon = Marker(
        "side",
        np.array([[-0.01, -0.09], [0.01, -0.09], [0.01, -0.01], [-0.01, -0.01]]),
        np.array([0, -0.09]),
        np.array([0, -0.01]),
        T_component_marker=Pose(RIGHTWARD, np.array([0, -0.001, 0])),
    )
    joint = Joint("base", Pose(np.eye(3), np.array([0, -0.06, 0.0])), np.array([0, 1.0, 0]), -0.5, 1.0)
    return ObjectModel("pump", (block, Component("arm", (ribbon,), label=7, joint=joint)))


@pytest.fixture
def target(model):
    return Target("pump", model, 3)


@pytest.fixture
def camera():
    return pinhole_camera((160, 120), 60)
