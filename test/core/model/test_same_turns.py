from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.same_turns import Looks, same_turns
from artrec_ros.io.objects.solids import ball_solid, box_solid

BAR = np.array([[-0.05, -0.01], [0.05, -0.01], [0.05, 0.01], [-0.05, 0.01]])
DISC = 0.05 * np.array([[np.cos(a), np.sin(a)] for a in np.linspace(0, 2 * np.pi, 24, endpoint=False)])


def flat(outline, x=0.0, y=0.0, z=0.0, radius=None):
    ends = np.array([outline[:, 0].min(), 0.0]), np.array([outline[:, 0].max(), 0.0])
    return (Marker("m", outline, *ends, radius, Pose(np.eye(3), np.array([x, y, z]))),)


def solid(name, size, xyz=(0, 0, 0), label=None, joint=None, required=False):
    box = Box(Pose(np.eye(3), np.array(xyz, float)), np.array(size, float))
    return Component(name, box_solid(box)[0], required, label=label, joint=joint, bodies=(box,))


def joint(parent, xyz, axis, lower, upper, kind="revolute"):
    return Joint(parent, Pose(np.eye(3), np.array(xyz, float)), np.array(axis, float), lower, upper, kind)


def model(*components):
    return ObjectModel("thing", components)


def turns(*components):
    """(axis, degrees) of each."""
    return {(tuple(np.round(t.axis, 2)), round(np.degrees(t.angle_rad))) for t in same_turns(model(*components))}


def test_a_brick_looks_the_same_after_half_a_turn_about_each_axis():
    expected = {((1, 0, 0), 180), ((0, 1, 0), 180), ((0, 0, 1), 180)}
    assert turns(solid("brick", (0.2, 0.1, 0.05), required=True)) == expected
    assert ((0, 0, 1), 90) in turns(solid("brick", (0.1, 0.1, 0.05), required=True))


def test_a_ball_looks_the_same_after_any_turn():
    markers, bodies = ball_solid(0.05, Pose.identity())
    found = same_turns(model(Component("ball", markers, True, bodies=bodies)))
    assert len(found) == 3 and all(t.is_round for t in found)


@pytest.mark.parametrize("label", [None, 4])
def test_something_rigid_beside_the_middle_tells(label):
    brick = solid("brick", (0.2, 0.1, 0.05), required=True)
    assert not turns(brick, solid("cab", (0.05, 0.06, 0.05), (0.06, 0.01, 0.05), label))
    assert turns(brick, solid("cab", (0.05, 0.06, 0.05), (0.0, 0.0, 0.05), label)) == {((0, 0, 1), 180)}


def test_joints_take_a_turn_up_within_their_limits():
    base = solid("base", (0.1, 0.1, 0.05), required=True)
    arm = (0.14, 0.03, 0.03), (0.05, 0, 0.02), 3
    (turn,) = same_turns(model(base, solid("arm", *arm, joint("base", (0, 0, 0.03), (0, 0, 1), -np.pi, np.pi))))
    assert (round(np.degrees(turn.angle_rad)), turn.places, list(turn.bent)) == (90, {}, ["arm"])
    assert not turns(base, solid("arm", *arm, joint("base", (0, 0, 0.03), (0, 0, 1), -0.5, 0.5)))


def test_a_small_ball_at_the_end_of_a_long_link_is_found_where_a_turn_brings_it():
    small = ball_solid(0.05, Pose.from_xyz_rpy((0, 0, 1.0)))
    arm = Component("arm", small[0], label=3, joint=joint("base", (0, 0, 0), (1, 0, 0), -1.6, 1.6), bodies=small[1])
    assert ((0, 0, 1), 180) in turns(solid("base", (0.1, 0.1, 0.05), required=True), arm)


def test_components_change_places():
    frame = solid("frame", (0.3, 0.25, 0.36), required=True)
    slides = [joint("frame", (0, 0, z), (1, 0, 0), 0, 0.2, "prismatic") for z in (-0.1, 0.1)]
    drawers = [solid(f"drawer_{n}", (0.26, 0.2, 0.09), (0.035, 0, 0), 3, slide) for n, slide in enumerate(slides)]
    (turn,) = same_turns(model(frame, *drawers))
    assert np.allclose(np.abs(turn.axis), (1, 0, 0))
    assert turn.places == {"drawer_0": "drawer_1", "drawer_1": "drawer_0"}
    assert not same_turns(model(frame, drawers[0], solid("other", (0.26, 0.2, 0.09), (0.035, 0, 0), 4, slides[1])))


def test_a_disc_from_which_all_hangs_by_one_joint_tells_no_turn():
    seat = Component("seat", flat(DISC, radius=0.05), True)
    arm = Component("arm", flat(BAR, 0.1), label=3, joint=joint("seat", (0, 0, 0.01), (0, 0, 1), -np.pi, np.pi))
    (turn,) = same_turns(model(seat, arm))
    assert turn.angle_rad < 0.6 and list(turn.bent) == ["arm"]
    beside = Component("beside", flat(BAR, 0.0, 0.1), label=4)
    assert not same_turns(model(seat, arm, beside))


def test_which_of_several_classes_a_component_has_tells():
    seat = Component("seat", flat(BAR), True, label=2)
    plain = [Component(n, flat(DISC, x, radius=0.05), label=3) for n, x in (("left", -0.1), ("right", 0.1))]
    named = [
        Component(n, flat(DISC, x, radius=0.05), classes={"a": 3, "b": 4}) for n, x in (("left", -0.1), ("right", 0.1))
    ]
    assert turns(seat, *plain) == {((0, 0, 1), 180)}
    assert not turns(seat, *named)
    below = Box(Pose.from_xyz_rpy((0, 0, -0.02)), np.array([0.1, 0.1, 0.02]))
    on_bodies = [replace(part, bodies=(below,), body_label=5) for part in named]  # a class by number beside names
    assert not turns(seat, *on_bodies)


def test_many_like_parts_on_one_axle_end():
    """In whatever order they are laid on each other none comes out; what would take too long is not called the same."""
    seat = Component("seat", flat(BAR), True)
    hinge = joint("seat", (0, 0, 0.01), (0, 0, 1), -np.pi, np.pi)
    blades = [Component(f"blade_{n}", flat(BAR, 0.06), label=3, joint=hinge) for n in range(8)]
    odd = Component("odd", flat(BAR, 0.1, 0.05), label=5)
    assert not same_turns(model(seat, *blades, odd))
    last = Component("last", flat(BAR, 0.1, 0.05), label=5, joint=joint("blade_7", (0.1, 0, 0), (0, 0, 1), -1, 1))
    looks = Looks(model(seat, *blades, last))
    looks.after(np.array([0.0, 0.0, 1.0]), np.pi)
    assert looks._tried < 9000


def test_a_required_component_that_a_joint_carries_is_turned_in_its_own_frame():
    base = solid("base", (0.1, 0.1, 0.04), label=3)
    lid = solid(
        "lid", (0.08, 0.06, 0.02), (0, 0, 0.03), joint=joint("base", (0, 0, 0.03), (0, 1, 0), -0.8, 0.8), required=True
    )
    turn = Pose.from_xyz_rpy((0, 0, 0), (0, 0, np.pi))
    assert not Looks(model(base, lid)).same_after(turn)  # about the lid's own axis, which leans
