from __future__ import annotations

import numpy as np

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.found import Detection, ImagePose
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.io.objects.solids import box_solid
from artrec_ros.io.truth.records import TrueObject
from artrec_ros.tools.evaluation.outcomes import Outcome
from artrec_ros.tools.evaluation.same_looks import turned_alike

BOX = Box(Pose.identity(), np.array([0.2, 0.1, 0.05]))
CRATE = ObjectModel("crate", (Component("crate", box_solid(BOX)[0], required=True, bodies=(BOX,)),))
TRUE = Pose.from_xyz_rpy((0.1, 0.0, 1.0), (0.4, -0.2, 1.0))


def outcome(turn):
    """Told as a turn (a rotation vector in the object's frame) of the truth."""
    told = Pose(TRUE.rotation @ rotation_from_rotvec(turn), TRUE.position)
    found = Detection("crate", 0, 0.9, ImagePose(0, 0, 0, 1), (), told)
    return "crate", Outcome(TrueObject(3, TRUE, {}, np.zeros(2)), True, found)


def test_turns_after_which_it_looks_the_same_are_counted():
    turns = [(np.pi, 0, 0), (0, np.pi, 0), (0.02, 0, 0), (0, 0, np.pi - 0.02)]
    (line,) = turned_alike([outcome(turn) for turn in turns], {"crate": CRATE})
    assert line.startswith("'crate' looks the same after some turns")
    assert "3 of 4 rotations are off by such a one" in line


def test_other_errors_are_no_such_turns():
    assert not list(turned_alike([outcome((0, 0, 1.5)), outcome((0.3, 0, 0))], {"crate": CRATE}))
    assert not list(turned_alike([outcome((np.pi, 0, 0))], {}))
