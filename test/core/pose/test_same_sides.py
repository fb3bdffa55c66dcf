"""Markers of a rigid object of which one is as good as another to begin with."""

from __future__ import annotations

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.pose.like_sides import LikeSides
from artrec_ros.core.pose.same_sides import unlike_markers
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.io.objects.solids import box_solid, cylinder_solid

HERE = Pose.identity()


def surface_of(solid, *others: Component) -> SpatialModel:
    markers, bodies = solid
    part = Component("part", markers, required=True, bodies=bodies)
    return SpatialModel(ObjectModel("solid", (part, *others)), RED, DEFAULTS.votes)


def box(x: float, y: float, z: float):
    return box_solid(Box(HERE, np.array([x, y, z])))


@pytest.mark.parametrize(
    ("solid", "kinds", "standing"),
    [
        (cylinder_solid(0.06, 0.02, HERE), 2, 3),
        (box(0.1, 0.1, 0.1), 1, 3),
        (box(0.1, 0.1, 0.2), 2, 3),
        (box(0.1, 0.15, 0.2), 3, 4),
        (box(0.1, 0.104, 0.108), 3, 4),
    ],
    ids=["cylinder", "cube", "pillar", "brick", "almost a cube"],
)
def test_sides_of_which_one_is_as_good_as_another(solid, kinds, standing):
    """What stands on a floor does not stand there upside down, or on its side, though it looks the same."""
    assert len(unlike_markers(surface_of(solid), 0, stands=False)) == kinds
    assert len(unlike_markers(surface_of(solid), 0, stands=True)) == standing


def test_what_is_beside_them_tells_sides_apart():
    cube, at = box(0.1, 0.1, 0.1), Pose(np.eye(3), np.array([0.0, 0.0, 0.1]))
    markers, bodies = box_solid(Box(at, np.array([0.04, 0.02, 0.1])))
    fixed = Component(
        "post", markers, joint=Joint("part", HERE, np.array([0.0, 0.0, 1.0]), 0, 0, "fixed"), bodies=bodies
    )
    hung = Component("post", markers, joint=Joint("part", HERE, np.array([0.0, 0.0, 1.0]), -1, 1), bodies=bodies)
    assert len(unlike_markers(surface_of(cube, fixed), 0, stands=False)) == 4  # half a turn exchanges two pairs
    assert unlike_markers(surface_of(cube, hung), 0, stands=False) == list(range(6))


def test_a_body_beside_them_does_too():
    markers, bodies = box(0.1, 0.1, 0.1)
    beside = Box(Pose(np.eye(3), np.array([0.1, 0.02, 0.0])), np.array([0.1, 0.02, 0.05]))
    assert len(unlike_markers(surface_of((markers, (*bodies, beside))), 0, stands=False)) == 6


def test_a_cylinder_looks_the_same_turned_by_less_than_one_of_its_flat_sides():
    assert not len(LikeSides(surface_of(cylinder_solid(0.06, 0.02, HERE))))
