from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.io.objects.solids import ball_solid, box_solid, cylinder_solid
from artrec_ros.io.truth.records import TrueComponent, TrueObject
from artrec_ros.tools.evaluation.metrics import judge_frame
from artrec_ros.tools.evaluation.outcomes import Outcome
from artrec_ros.tools.evaluation.same_looks import AS_IT_IS, SameLooks, siblings, turned_alike
from artrec_ros.tools.evaluation.slips import slips

BOX = Box(Pose.identity(), np.array([0.2, 0.1, 0.05]))
CRATE = ObjectModel("crate", (Component("crate", box_solid(BOX)[0], required=True, bodies=(BOX,)),))
LOOKS = SameLooks.of(CRATE)
TRUE = Pose.from_xyz_rpy((0.1, 0.0, 1.0), (0.4, -0.2, 1.0))


def outcome(turn):
    """Told as a turn (a rotation vector in the object's frame) of the truth."""
    told = Pose(TRUE.rotation @ rotation_from_rotvec(turn), TRUE.position)
    found = Detection("crate", 0, 0.9, ImagePose(0, 0, 0, 1), (), told)
    return "crate", Outcome(TrueObject(3, TRUE, {}, np.zeros(2)), True, found, looks=LOOKS)


def test_errors_are_those_from_the_nearest_turn_in_which_it_looks_the_same():
    turns = [(np.pi, 0, 0), (0, np.pi, 0), (0.02, 0, 0), (0, 0, np.pi - 0.02)]
    told = [outcome(turn) for turn in turns]
    assert [o.rotation_error_rad for _, o in told] == pytest.approx([0, 0, 0.02, 0.02], abs=1e-6)
    (line,) = turned_alike(told)
    assert line.startswith("'crate' looks the same after some turns")
    assert "3 of 4 rotations are off by such a one" in line and "179.43 deg in the median" in line


def test_places_are_those_of_the_same_turn():
    """A plate whose frame lies in its corner: half a turn puts that at the other one."""
    outline = np.array([(0, 0), (0.2, 0), (0.2, 0.1), (0, 0.1)])
    square = Marker("face", outline, np.array([0, 0.05]), np.array([0.2, 0.05]), T_component_marker=Pose.identity())
    plate = ObjectModel("plate", (Component("plate", (square,), required=True),))
    looks, true = SameLooks.of(plate), TrueObject(3, TRUE, {}, np.zeros(2))
    R, middle = rotation_from_rotvec(np.array([0, 0, np.pi])), np.array([0.1, 0.05, 0.0])
    for slip, turned in ((0.0, True), (0.003, True), (0.003, False)):
        shift = middle - R @ middle if turned else np.zeros(3)
        told = Pose(TRUE.rotation @ (R if turned else np.eye(3)), TRUE.apply(shift) + np.array([0, 0, slip]))
        found = Detection("plate", 0, 0.9, ImagePose(0, 0, 0, 1), (), told)
        one = Outcome(true, True, found, looks=looks)
        assert one.turned_alike == turned and one.position_error_m == pytest.approx(slip, abs=1e-9)


def test_what_is_round_is_off_by_what_its_axis_is():
    sides, bodies = cylinder_solid(0.05, 0.2, Pose.identity())
    tin = SameLooks.of(ObjectModel("tin", (Component("tin", sides, required=True, bodies=bodies),)))
    about, lean = (rotation_from_rotvec(np.array(turn)) for turn in ((0, 0, 0.26), (0.1, 0, 0)))
    assert tin.error_rad(TRUE.rotation, TRUE.rotation @ about @ lean) == pytest.approx(0.1)
    sides, bodies = ball_solid(0.05, Pose.identity())
    ball = SameLooks.of(ObjectModel("ball", (Component("ball", sides, required=True, bodies=bodies),)))
    assert ball.error_rad(TRUE.rotation, TRUE.rotation @ about @ lean) == pytest.approx(0, abs=0.05)


def test_other_errors_are_no_such_turns():
    others = [outcome((0, 0, 1.5)), outcome((0.3, 0, 0))]
    assert [o.rotation_error_rad for _, o in others] == pytest.approx([1.5, 0.3])
    assert not list(turned_alike(others))
    plain = [(name, replace(o, looks=AS_IT_IS)) for name, o in [outcome((np.pi, 0, 0))]]
    assert plain[0][1].rotation_error_rad == pytest.approx(np.pi)
    assert not list(turned_alike(plain))


def test_joints_that_such_a_turn_bends_the_other_way_are_no_slip_of_the_truth():
    told = []
    for q in (0.3, 0.5, -0.4, 0.7):
        name, one = outcome((0, 0, np.pi))
        assert one.turned_alike and one.detection is not None
        true, found = replace(one.truth, joints={"arm": q}), replace(one.detection, joints={"arm": -q})
        told.append((name, replace(one, truth=true, detection=found)))
    assert not list(slips(told, {}))
    assert list(slips([(name, replace(o, looks=AS_IT_IS)) for name, o in told], {}))


def test_a_turn_that_bends_a_joint_is_one_only_where_it_is_bent_so():
    """A square base with an arm on an upright joint: turned by a quarter it looks as it did if the arm stays."""
    base, arm = (
        Box(Pose.identity(), np.array([0.2, 0.2, 0.05])),
        Box(Pose.from_xyz_rpy((0.15, 0, 0.04)), np.full(3, 0.03)),
    )
    joint = Joint("base", Pose.identity(), np.array([0.0, 0, 1.0]), -np.pi, np.pi, name="q")
    parts = (
        Component("base", box_solid(base)[0], required=True, bodies=(base,)),
        Component("arm", box_solid(arm)[0], label=5, joint=joint, bodies=(arm,)),
    )
    looks = SameLooks.of(ObjectModel("crate", parts))
    quarter = TRUE.rotation @ rotation_from_rotvec([0.0, 0.0, np.pi / 2])
    assert looks.error_rad(TRUE.rotation, quarter, ()) == pytest.approx(0, abs=1e-6)
    assert looks.error_rad(TRUE.rotation, quarter, ("q",)) == pytest.approx(np.pi / 2)
    _, one = outcome((0.0, 0.0, np.pi / 2))
    one = replace(one, looks=looks, truth=replace(one.truth, joints={"q": 0.4}))
    for told, off in ((0.4, np.pi / 2), (0.4 - np.pi / 2, 0.0)):
        assert replace(one, detection=replace(one.detection, joints={"q": told})).rotation_error_rad == pytest.approx(
            off, abs=1e-6
        )


def test_balls_are_balls_whichever_sides_stand_for_them():
    """Two on a stick are round about it."""
    parts = tuple(
        Component(name, ball_solid(0.05, Pose.from_xyz_rpy((0, 0, z)))[0], required=z == 0, label=label)
        for name, z, label in (("one", 0.0, 3), ("other", 0.3, 4))
    )
    looks = SameLooks.of(ObjectModel("dumbbell", parts))
    turned = TRUE.rotation @ rotation_from_rotvec([0.0, 0.0, 0.7])
    assert looks.error_rad(TRUE.rotation, turned) == pytest.approx(0, abs=1e-6)
    leaning = TRUE.rotation @ rotation_from_rotvec([0.7, 0.0, 0.0])
    assert looks.error_rad(TRUE.rotation, leaning) == pytest.approx(0.7)


def bar(name, y):
    outline = np.array([(-0.1, -0.02), (0.1, -0.02), (0.1, 0.02), (-0.1, 0.02)])
    at = Pose(np.eye(3), np.array([0.0, y, 0.0]))
    marker = Marker(f"{name}_bar", outline, outline[0], outline[1], T_component_marker=at)
    return Component(name, (marker,), required=name == "upper")


EQUALS = ObjectModel("equals", (bar("upper", 0.05), bar("lower", -0.05)))


def test_components_that_a_turn_exchanges_are_found_as_each_other():
    """Of an equals sign either bar is the upper one."""
    names = siblings(EQUALS)
    assert names == [{"upper/upper_bar": "lower/lower_bar", "lower/lower_bar": "upper/upper_bar"}]
    places = {"upper@upper_bar": (50.0, 40.0), "lower@lower_bar": (50.0, 60.0)}
    parts = {name: TrueComponent(320.0, 320.0, np.array(at)) for name, at in places.items()}
    o = TrueObject(None, None, parts, None, "equals")

    def told(first, second):
        seen = [Instance(c, f"{c}_bar", 0.9, *at, 0.0, 200.0) for c, at in (("upper", first), ("lower", second))]
        return Detection("equals", 0, 0.9, ImagePose(*first, 0.0, 200.0), tuple(seen))

    here, there = (50.0, 40.0), (50.0, 60.0)
    for detection, known, right in (
        (told(here, there), (), True),
        (told(there, here), (), False),
        (told(there, here), names, True),
        (told(here, there), names, True),
        (told(there, (90.0, 90.0)), names, False),
    ):
        frame = judge_frame([o], [detection], "upper", known)
        assert frame.outcomes[0].truth is o and frame.all_well == right
    assert siblings(CRATE) == []
