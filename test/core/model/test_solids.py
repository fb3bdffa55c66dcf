from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.solids import balls_of, closed_components, closed_in, convex_solids
from artrec_ros.core.model.surface import patches_of
from artrec_ros.io.objects.solids import ball_solid, box_solid, cylinder_solid

CUBE = Box(Pose.identity(), np.full(3, 0.1))


def patches(*markers):
    return patches_of(ObjectModel("thing", (Component("part", tuple(markers), True, bodies=(CUBE,)),)), 1)


def test_the_sides_of_a_box_are_one_solid():
    assert convex_solids(patches(*box_solid(CUBE)[0])) == {0}


def test_a_box_that_is_open_is_none():
    assert not closed_in(patches(*box_solid(CUBE)[0][1:]))
    assert not convex_solids(patches(*box_solid(CUBE)[0][1:]))


def test_two_boxes_apart_are_no_convex_solid():
    aside = Pose.from_xyz_rpy((0.3, 0, 0))
    other = [
        replace(m, name=f"{m.name}_2", T_component_marker=aside @ m.T_component_marker) for m in box_solid(CUBE)[0]
    ]
    both = patches(*box_solid(CUBE)[0], *other)
    assert closed_in(both)
    assert not convex_solids(both)


def test_a_ball_is_one_and_a_box_or_a_tin_is_none():
    at = Pose.from_xyz_rpy((0.3, -0.2, 0.1), (0.2, 0.5, -1.0))
    markers, bodies = ball_solid(0.05, at)
    model = ObjectModel("ball", (Component("all", markers, True, bodies=bodies),))
    (ball,) = balls_of(patches_of(model, 1)).values()
    np.testing.assert_allclose(ball.centre, at.position, atol=1e-12)
    assert ball.radius == pytest.approx(0.05)
    assert closed_components(model) == {"all"} and not model.is_flat
    assert len(patches_of(model, 1)) == 1  # its box shows nowhere
    for sides, _ in (box_solid(CUBE), cylinder_solid(0.05, 0.1, at)):
        assert not balls_of(patches(*sides))
