"""Rigid objects with sides that look the same."""

from __future__ import annotations

import numpy as np
import pytest
from like_plates import PLATES, car, plate
from settings import DEFAULTS, settings
from solids import FRONT, RED, camera_of, marker, rectangle, render, truck, turn_between

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.like_sides import LikeSides
from artrec_ros.core.pose.other_turns import likelier_turns
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.left_over import LeftOvers

CAMERA = camera_of((640, 480), 600.0)


def showing(name: str, turn: float = 0.0, z: float = 1.2) -> Poses:
    """A car that turns a plate to the camera, and from there about its own axis, seen a little from above."""
    R = np.diag([1.0, -1.0, -1.0]) @ PLATES[name][0].T @ rotation_from_rotvec([0, 0, turn])
    R = rotation_from_rotvec([-0.15, 0, 0]) @ R
    return Poses(R[None], np.array([[0.02, 0.03, z]]), np.zeros((1, 0)))


def sides_of(model: ObjectModel) -> LikeSides:
    return LikeSides(SpatialModel(model, RED, DEFAULTS.votes))


def finder_of(model: ObjectModel, config=DEFAULTS) -> WholeObjectFinder:
    return WholeObjectFinder(Target("car", model, RED), config)


def frame_of(model: ObjectModel, at: Poses) -> ImageFrame:
    return ImageFrame(LabelField(render(CAMERA, [(model, at, RED)])), CAMERA)


@pytest.mark.parametrize("required", ["left_sign", "front_bar1"])
def test_each_plate_takes_each_others_place_whatever_is_required(required):
    model = car(required)
    sides, at = sides_of(model), showing("left")
    others = sides.of(at)
    shown = {frozenset(sides.seen_as(k, plate(model, "left"))) for k in others.side.tolist()}
    assert shown == {plate(model, "rear"), plate(model, "front")}
    middle = {name: np.array(PLATES[name][1]) for name in PLATES}
    here = at.R[0] @ middle["left"] + at.t[0]
    moved = zip(others.poses.R, others.poses.t, strict=True)
    off = [min(np.linalg.norm(R @ middle[name] + t - here) for name in ("rear", "front")) for R, t in moved]
    assert max(off) < 1e-3


def test_what_another_side_shows_too_tells_no_sides_apart():
    model = car()
    sides = sides_of(model)
    left, front = plate(model, "left"), plate(model, "front")
    assert set() in sides.told_apart_by(left)
    assert all(some and some < left | front for some in sides.told_apart_by(left | front))


@pytest.mark.parametrize("seen, in_doubt", [(("left",), True), (("left", "front"), False)], ids=str)
def test_all_marks_of_one_plate_leave_in_doubt_which_plate_it_is(seen, in_doubt):
    model = car()
    components = sorted(frozenset().union(*(plate(model, name) for name in seen)))
    assert LeftOvers(finder_of(model)).is_in_doubt(components) is in_doubt


def test_what_has_one_such_plate_or_joints_or_looks_the_same_from_behind_has_none():
    bar, behind = rectangle(0.06, 0.03), FRONT @ np.diag([-1.0, 1.0, -1.0])
    markers = marker("m", bar, FRONT, (0.1, 0, 0)), marker("m", bar, behind, (-0.1, 0, 0))
    parts = tuple(Component(str(n), (m,), required=n == 0) for n, m in enumerate(markers))
    for model in (car(plates=("left",)), truck(), ObjectModel("sign", parts)):
        assert not len(sides_of(model))


def test_where_two_plates_are_seen_the_finder_comes_from_a_wrong_one_to_the_right_one():
    model = car()
    true = showing("left", -0.7)
    finder, frame = finder_of(model), frame_of(model, true)
    others = finder.like_sides.of(true)
    wrong = others.poses[:1]
    found = finder._with_lookalikes(frame, finder.fit_all(frame, wrong).best(1, DEFAULTS.search))
    assert turn_between(found.poses.R[0], true.R[0]) < 0.1


def test_of_a_lone_plate_another_side_is_as_likely():
    model = car()
    true = showing("left")
    told, (other,) = likelier_turns(finder_of(model), frame_of(model, true), true)
    assert turn_between(other.pose.rotation, told.R[0]) > 1.2
    assert other.probability == pytest.approx(0.5, abs=0.05) and other.sides == pytest.approx(2 / 3, abs=0.07)


@pytest.mark.parametrize("name", ["left", "rear", "front"])
def test_a_lone_plate_is_there_but_not_sure_to_be_the_one_that_is_told(name):
    model = car()
    engine = Recognizer((Target("car", model, RED),), settings(required="visible"), Segmenter(ImageConfig()))
    (found,) = engine.recognize(render(CAMERA, [(model, showing(name), RED)]), CAMERA).detections
    assert found.there > 0.9 and found.as_told < 0.55 and found.score < 0.55 and found.other_turn is not None
    assert max(c.score for c in found.components) < 0.55
