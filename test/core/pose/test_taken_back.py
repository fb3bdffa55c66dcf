"""A mast may stand turned by any angle if the jib on it turns as far the other way: what is rigid to it tells."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import BACKGROUND, BLUE, BODY, RED, camera_of, render, truck, turn_between

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_turns import likelier_turns
from artrec_ros.core.pose.poses import Poses
from artrec_ros.io.objects.solids import box_solid, cylinder_solid

CAMERA = camera_of((640, 480), 590.0)
ABOVE = np.array([[0, -1, 0], [0.28, 0, -0.96], [0.96, 0, 0.28]])  # seen from a little above
TURNS, TOP = 12, 0.15


def solid(name, size, at=(0.0, 0.0, 0.0), **rest):
    markers, bodies = box_solid(Box(Pose.from_xyz_rpy(at), np.array(size)))
    return Component(name, markers, bodies=bodies, **rest)


def mast(cab=True, most=2.6, across=0.05, hinge=0.0, round_one=None):
    """:param across: of 6 cm. :param hinge: how far beside its middle the jib turns. :param round_one: in its place."""
    yaw = Joint("mast", Pose.from_xyz_rpy((hinge, 0, TOP)), np.array([0.0, 0.0, 1.0]), -most, most)
    parts = [round_one or solid("mast", (0.06, across, 2 * TOP), required=True)]
    parts += [solid("cab", (0.05, 0.07, 0.05), (0.056, 0, 0.06), label=BLUE)] if cab else []
    parts.append(solid("jib", (0.32, 0.04, 0.035), (0.09, 0, 0.02), label=BODY, joint=yaw))
    return ObjectModel("mast", tuple(parts))


def column():
    markers, bodies = cylinder_solid(0.03, 2 * TOP, Pose.identity())
    return Component("mast", markers, required=True, bodies=tuple(bodies))


def at(turn, yaw):
    return Poses((ABOVE @ rotation_from_rotvec([0, 0, turn]))[None], np.array([[0.05, 0.02, 1.2]]), np.array([[yaw]]))


def taken_back(model):
    return WholeObjectFinder(Target(model.name, model, RED), DEFAULTS).taken_back


def test_what_the_joint_carries_stays_where_it_is_within_its_limits():
    finder = WholeObjectFinder(Target("mast", mast(), RED), DEFAULTS)
    both = Poses.concatenate([at(0.3, 0.8), at(-1.0, -2.0)])
    turned, of = finder.taken_back.of(both)
    kin = finder.surface.kinematics
    here, there = kin.forward(both.R, both.t, both.q), kin.forward(turned.R, turned.t, turned.q)
    np.testing.assert_allclose(there.R[:, 2], here.R[of, 2], atol=1e-9)
    np.testing.assert_allclose(there.t[:, 2], here.t[of, 2], atol=1e-9)
    assert (np.abs(turned.q) <= 2.6).all() and turn_between(turned.R[0], both.R[0]) > 0.3
    assert len(finder.taken_back) == TURNS - 1 and 0 < np.bincount(of).min() < TURNS - 1


@pytest.mark.parametrize(
    ("model", "turns"),
    [
        (mast(across=0.3), 1),  # its outline tells all but half a turn
        (mast(cab=False), TURNS - 2),  # its own sides tell, but half a turn
        (mast(hinge=0.3), 0),
        (truck(), 0),
    ],
    ids=["broad", "without cab", "jib far off", "legs"],
)
def test_turns_are_those_that_the_outline_does_not_tell_and_something_else_does(model, turns):
    assert len(taken_back(model)) == turns


@pytest.mark.parametrize("cab", [True, False])
def test_a_column_is_turned_where_something_is_fixed_to_it(cab):
    assert len(taken_back(mast(cab, round_one=column()))) == (TURNS - 1 if cab else 0)


@pytest.mark.parametrize("off", [1.25, -1.4, 2.0])
def test_a_mast_is_turned_to_where_its_cab_is(off):
    finder, true = WholeObjectFinder(Target("mast", mast(), RED), DEFAULTS), at(1.9, 0.4)
    frame = ImageFrame(LabelField(render(CAMERA, [(mast(), true, RED)])), CAMERA)
    found = finder.rest.fitted(frame, at(1.9 + off, 0.4 - off))
    assert turn_between(found.R[0], true.R[0]) > 0.8
    told, _ = likelier_turns(finder, frame, found)
    assert turn_between(told.R[0], true.R[0]) < 0.05
    assert told.q[0, 0] == pytest.approx(0.4, abs=0.05)
    same, others = likelier_turns(finder, frame, told)
    assert turn_between(same.R[0], told.R[0]) < 0.05 and others == [None]


def test_where_nothing_tells_the_turn_another_one_is_told():
    """The cab of a round mast is hidden."""
    model, true = mast(round_one=column()), at(0.4, 0.4)
    labels = render(CAMERA, [(model, true, RED)])
    labels[labels == BLUE] = BACKGROUND
    finder = WholeObjectFinder(Target("mast", model, RED), DEFAULTS)
    told, (other,) = likelier_turns(finder, ImageFrame(LabelField(labels), CAMERA), true)
    assert other is not None and other.probability > 0.1
    assert turn_between(other.pose.rotation, told.R[0]) > 0.3
