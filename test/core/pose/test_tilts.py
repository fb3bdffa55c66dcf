"""Boxes that look almost the same tilted where they are."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from settings import DEFAULTS, settings
from solids import RED, camera_of, render, sign

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.objects.solids import ball_solid, box_solid

CAMERA = camera_of((320, 240), 300.0)
SAME = Rotation.create_group("O").as_matrix()  # after which a cube looks as it did


def cube():
    box = Box(Pose.identity(), np.full(3, 0.04))
    return ObjectModel("cube", (Component("cube", box_solid(box)[0], required=True, bodies=(box,)),))


def somewhere(n):
    """A cube of some 30 pixels, in any turn."""
    rng = np.random.default_rng(n)
    t = np.array([rng.uniform(-0.1, 0.1), rng.uniform(-0.07, 0.07), rng.uniform(0.35, 0.5)])
    return Poses(Rotation.random(random_state=n).as_matrix()[None], t[None], np.zeros((1, 0)))


def apart_rad(R, other):
    return float(min(Rotation.from_matrix(R.T @ other @ same).magnitude() for same in SAME))


def finder_of(model):
    return WholeObjectFinder(Target(model.name, model, RED), DEFAULTS)


def test_a_tilt_leaves_it_where_it_is_and_shows_another_side_more():
    finder, one = finder_of(cube()), somewhere(3)
    tilted, of = finder.tilts.of(one)
    assert len(tilted) == len(finder.tilts) > 8 and not of.any()
    np.testing.assert_allclose(finder.required.anchors(tilted), finder.required.anchors(one)[of], atol=1e-9)
    middle = finder.required.anchors(one)[0]
    sight = middle / np.linalg.norm(middle)
    for R in tilted.R:
        axis = Rotation.from_matrix(R @ one.R[0].T).as_rotvec()
        assert abs(axis @ sight) < 1e-6 < np.linalg.norm(axis)


def test_what_looks_the_same_is_no_other_tilt():
    finder, one = finder_of(cube()), somewhere(3)
    turns = np.array([[0.0, 0, np.pi / 2], [np.pi, 0, 0], [0.05, 0, 0], [0.4, 0, 0], [0, 0, np.pi / 4]])
    others = Poses(one.R @ rotation_from_rotvec(turns), np.tile(one.t, (5, 1)), np.zeros((5, 0)))
    rows = np.zeros(5, int)
    assert finder.tilts.look_otherwise(one[rows], others, 0.25).tolist() == [False, False, False, True, True]


def test_what_is_no_solid_or_a_ball_has_none():
    ball = ObjectModel("ball", (Component("ball", ball_solid(0.05, Pose.identity())[0], required=True),))
    assert not len(finder_of(sign()).tilts) and not len(finder_of(ball).tilts)


@pytest.mark.parametrize("n", [10, 15, 56, 59])
def test_a_small_cube_is_told_as_its_outline_says_or_with_its_other_turn(n):
    """Of each of these votes were as many for a pose that is tilted by 20 to 40 degrees."""
    model, true = cube(), somewhere(n)
    engine = Recognizer(
        (Target("cube", model, RED),), settings(time_budget_ms=60000.0), Segmenter(ImageConfig()), calibrated=True
    )
    (found,) = engine.recognize(render(CAMERA, [(model, true, RED)]), CAMERA).detections
    turns = [found.pose.rotation] + [found.other_turn.pose.rotation] * (found.other_turn is not None)
    assert min(apart_rad(R, true.R[0]) for R in turns) < 0.1
