"""What is told of lengths, and of limits of joints, that marked images measure."""

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.learning.joint_limits import LimitChange
from artrec_ros.core.learning.lengths import Change
from artrec_ros.core.learning.size_fit import Kept, Measured
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.tools.training.marked_lengths import lines

CORNERS = np.array([(0.0, 0.0), (0.1, 0.0), (0.0, 0.1)])
PLATE = Marker("plate", CORNERS, CORNERS[0], CORNERS[1], T_component_marker=Pose(np.eye(3), np.zeros(3)))
MODEL = ObjectModel("sign", (Component("base", (PLATE,), required=True),))
MOVED = Change("arm", "rod", 1.0, np.array([0.25, 0.0, 0.0]), 0.0, np.array([0.5, 0.0, 0.0]))
KEPT = LimitChange("elbow", "revolute", 0.5, (-0.2, 0.3), (-0.2, 0.3), ("", ""))
WIDER = LimitChange("slide", "prismatic", 0.0, (0.0, 0.3), (-0.1, 0.3), ("one.png", ""))


def told(after_px=1.0, limits=(KEPT, WIDER), outside=(WIDER,), metric=False):
    kept = Kept("wrist", 0.4), Kept("thumb", None)
    measured = Measured(MODEL, 2.5, (MOVED,), limits, outside, 9, 2.0, after_px, (), (), kept)
    return list(lines(measured, metric))


def test_each_joint_whose_limits_change_is_named():
    said = told()
    assert "  elbow: its zero moves by 28.6 deg, limits -0.200..0.300 stay" in said
    assert "  slide: limits 0.000..0.300 become -0.100..0.300 (for one.png)" in said
    assert any(line.startswith("Limits of joints stay") for line in told(limits=()))


def test_joints_that_marks_do_not_determine_are_named_with_the_reason():
    wrist, thumb = (line for line in told() if line.startswith("Joint "))
    assert wrist.startswith("Joint wrist stays") and "40% of the object from where the other half does" in wrist
    assert thumb.startswith("Joint thumb stays") and "more than a whole turn" in thumb


def test_limits_are_warned_of_where_lengths_hold():
    said = told(after_px=1.9)
    assert [line for line in said if line.startswith("warning")] == [
        "warning: joint slide: limits 0.000..0.300 hold less than what is marked; -0.100..0.300 would hold it "
        "(for one.png)"
    ]


@pytest.mark.parametrize(("metric", "unit", "shift"), [(True, "mm", "250.0"), (False, "% of object", "10.0")])
def test_shifts_are_told_beside_the_object_where_lengths_are_no_metres(metric, unit, shift):
    head, row = (line for line in told(metric=metric) if line.startswith(("  marker", "  arm/rod")))
    assert head.count(f"moved, {unit}") == 2 and row.split()[3] == shift
