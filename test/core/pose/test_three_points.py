"""Discs that lie far apart beside their size: their middles tell the pose that no one of them does."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, marker, rectangle, render, turn_between

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.pose.three_points import ThreePoints
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.second_looks import SecondLooks
from artrec_ros.core.three_point_looks import ThreePointLooks
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.io.objects.solids import cylinder_solid

CAMERA = camera_of((640, 480), 500.0)
SEEN = ImageFrame(LabelField(np.zeros((480, 640), np.uint8)), CAMERA)  # whose blobs are given
ANGLES = 2 * np.pi * np.arange(48) / 48
DISC = 0.02 * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
LABELS = {"b": 3, "c": 4, "d": None}


def disc(x: float, y: float) -> Marker:
    return Marker("disc", DISC, DISC.min(axis=0), DISC.max(axis=0), 0.02, Pose(np.eye(3), np.array([x, y, 0.0])))


def discs(*, rigid: bool = True) -> ObjectModel:
    """Four in one plane, ten and more of their radii apart."""
    at = {"b": (0.25, 0.02), "c": (0.05, 0.3), "d": (-0.2, -0.15)}
    kind = "fixed" if rigid else "revolute"
    limit = 0.0 if rigid else 0.4
    joint = Joint("a", Pose.identity(), np.array([0, 0, 1.0]), -limit, limit, kind)
    parts = [Component(n, (disc(*xy),), label=LABELS[n], joint=joint) for n, xy in at.items()]
    return ObjectModel("discs", (Component("a", (disc(0, 0),), required=True), *parts))


def at(slant: float, heading: float) -> Poses:
    R = (
        rotation_from_rotvec([slant, 0.0, 0.0])
        @ rotation_from_rotvec([np.pi, 0, 0])
        @ rotation_from_rotvec([0, 0, heading])
    )
    return Poses(R[None], np.array([[0.05, -0.03, 1.4]]), np.zeros((1, 0)))


def three_points(model: ObjectModel) -> ThreePoints:
    return ThreePoints(SpatialModel(model, RED, DEFAULTS.votes), DEFAULTS)


@pytest.mark.parametrize("heading", [0.3, 2.0, -1.4])
@pytest.mark.parametrize("slant", [0.1, 0.6, 0.9])
def test_three_middles_tell_where_discs_are(slant, heading):
    model, pose = discs(), at(slant, heading)
    blobs = find_blobs(render(CAMERA, [(model, pose, RED)]), {RED, 3, 4}, DEFAULTS)
    found = Poses.concatenate(three_points(model).of(SEEN, blobs, np.ones(len(blobs), bool)))
    off = [turn_between(R, pose.R[0]) + np.linalg.norm(t - pose.t[0]) for R, t in zip(found.R, found.t, strict=True)]
    assert min(off) < 0.06
    assert len(found) <= DEFAULTS.middles.triples_kept


@pytest.mark.parametrize("heading", [0.3, 2.0, -1.4])
@pytest.mark.parametrize("slant", [0.6, 0.9])
def test_an_object_of_discs_is_found_by_them(slant, heading):
    model, pose = discs(), at(slant, heading)
    labels = render(CAMERA, [(model, pose, RED)])
    result = Recognizer([Target("discs", model, RED)], DEFAULTS, Segmenter(ImageConfig())).recognize(labels, CAMERA)
    (found,) = result.detections
    assert turn_between(found.pose.rotation, pose.R[0]) < 0.03
    assert np.linalg.norm(found.pose.position - pose.t[0]) < 0.01
    assert len(found.components) == 4


def test_blobs_of_other_sizes_are_no_markers():
    model, pose = discs(), at(0.3, 0.3)
    blobs = find_blobs(render(CAMERA, [(model, pose, RED)]), {RED, 3, 4}, DEFAULTS)
    parts = [replace(c, markers=tuple(replace(m, outline=m.outline / 3) for m in c.markers)) for c in model.components]
    small = ObjectModel("small", tuple(parts))
    assert not three_points(small).of(SEEN, blobs, np.ones(len(blobs), bool))


def test_only_what_is_rigid_is_found_so():
    assert three_points(discs()).labels == {RED, 3, 4}
    assert not three_points(discs(rigid=False)).labels
    one = ObjectModel(
        "one", (Component("a", (marker("m", rectangle(0.1, 0.05), np.eye(3), (0, 0, 0)),), required=True),)
    )
    assert not three_points(one).labels


def test_what_they_find_may_be_a_targets_only_candidate():
    """As where every other look waits, for the camera's images come faster."""
    pose = at(0.6, 0.3)
    finder = WholeObjectFinder(Target("discs", discs(), RED), DEFAULTS)
    frame = ImageFrame(LabelField(render(CAMERA, [(discs(), pose, RED)])), CAMERA)
    looks = SecondLooks(frame, Judge.of(DEFAULTS), DEFAULTS.search)
    assert not looks.shared([])[0]
    (told,) = looks.beside([(finder, pose)]).accepted
    assert told.claim.finder is finder


def test_of_hundreds_of_blobs_a_bounded_number_of_threes_is_tried(monkeypatch):
    like = ObjectModel("like", tuple(replace(c, label=None) for c in discs().components))
    labels, tried = np.zeros((480, 640), np.uint8), list[int]()
    for n in range(300):
        cv2.circle(labels, (12 + 32 * (n % 20), 12 + 30 * (n // 20)), 6, RED, -1)
    three, blobs = three_points(like), find_blobs(labels, {RED}, DEFAULTS)
    solve = cv2.solveP3P
    monkeypatch.setattr(cv2, "solveP3P", lambda *given, **flags: tried.append(1) or solve(*given, **flags))
    three.of(SEEN, blobs, np.ones(len(blobs), bool))
    assert len(blobs) == 300 and len(tried) <= DEFAULTS.middles.triples * DEFAULTS.middles.triples_tried


def test_blobs_that_wait_are_asked_beside_one_that_does_not():
    model, pose = discs(), at(0.3, 0.3)
    blobs = find_blobs(render(CAMERA, [(model, pose, RED)]), {RED, 3, 4}, DEFAULTS)
    three = three_points(model)
    assert not len(three.of(SEEN, blobs, np.zeros(len(blobs), bool)))
    assert len(three.of(SEEN, blobs, np.arange(len(blobs)) == 1))


def test_the_markers_of_one_component_are_as_rigid():
    parts = discs().components
    one = ObjectModel("one", (replace(parts[0], markers=tuple(m for c in parts for m in c.markers)),))
    assert three_points(one).labels == {RED}


def test_where_none_stands_on_the_floor_there_is_none(monkeypatch):
    pose = at(0.6, 0.3)
    finder = WholeObjectFinder(Target("discs", discs(), RED), DEFAULTS)
    frame = ImageFrame(LabelField(render(CAMERA, [(discs(), pose, RED)])), CAMERA)
    looks = ThreePointLooks([finder], Judge.of(DEFAULTS))
    blobs = find_blobs(frame.field.labels, {RED, 3, 4}, DEFAULTS)
    assert looks.candidates(frame, [], blobs)
    monkeypatch.setattr(WholeObjectFinder, "standing", lambda self, frame, poses: poses[:0])
    assert not looks.candidates(frame, [], blobs)


def bars(*, long: bool = True) -> ObjectModel:
    """Two of one class, upright and lying, ten times as far apart as they are wide; or two squares."""
    upright = rectangle(0.02, 0.14) if long else rectangle(0.05, 0.05)
    lying = rectangle(0.10, 0.02) if long else rectangle(0.05, 0.05)
    facing = np.eye(3)
    foot = Component("foot", (marker("foot", lying, facing, (0.35, -0.1, 0.05)),))
    return ObjectModel("bars", (Component("post", (marker("post", upright, facing, (0, 0, 0)),), required=True), foot))


@pytest.mark.parametrize("heading", [0.3, 2.0, -1.4])
@pytest.mark.parametrize("slant", [0.1, 0.6, 0.9])
def test_both_ends_of_a_long_marker_and_the_middle_of_another_tell_as_much(slant, heading):
    model, pose = bars(), at(slant, heading)
    blobs = find_blobs(render(CAMERA, [(model, pose, RED)]), {RED}, DEFAULTS)
    three = three_points(model)
    found = Poses.concatenate(three.of(SEEN, blobs, np.ones(len(blobs), bool)))
    off = [turn_between(R, pose.R[0]) + np.linalg.norm(t - pose.t[0]) for R, t in zip(found.R, found.t, strict=True)]
    assert three.least == 2
    assert min(off) < 0.15


def test_squares_have_no_ends():
    assert not three_points(bars(long=False)).labels


@pytest.mark.parametrize(
    ("turns", "places"),
    [
        (((0.482, -0.29), (-0.955, 0.205)), ((-1.304, -0.39, 3.435), (0.436, 0.642, 3.658))),
        (((0.909, 0.194), (-0.163, -0.062)), ((-1.331, -0.45, 3.418), (0.39, 0.571, 3.627))),
    ],
)
def test_what_is_found_does_not_stand_in_the_way_of_what_is_not(turns, places):
    """It explains its blobs as well as ever when these are asked again."""
    post = rectangle(0.03, 0.3)
    other = Component("other", (marker("other", post, np.eye(3), (0.8, 0, 0)),), label=4)
    gate = ObjectModel("gate", (Component("post", (marker("post", post, np.eye(3), (0, 0, 0)),), required=True), other))
    facing = rotation_from_rotvec([np.pi, 0, 0])
    poses = [
        Poses(
            (rotation_from_rotvec([0, a, 0]) @ rotation_from_rotvec([b, 0, 0]) @ facing)[None],
            np.array([t]),
            np.zeros((1, 0)),
        )
        for (a, b), t in zip(turns, places, strict=True)
    ]
    labels = render(CAMERA, [(gate, pose, RED) for pose in poses])
    found = Recognizer([Target("gate", gate, RED)], DEFAULTS, Segmenter(ImageConfig())).recognize(labels, CAMERA)
    assert len(found.detections) == 2
    assert max(min(np.linalg.norm(d.pose.position - p.t[0]) for d in found.detections) for p in poses) < 0.06


def poles() -> ObjectModel:
    """Two upright cylinders, forty of their widths apart."""
    parts = [cylinder_solid(0.015, 0.4, Pose(np.eye(3), np.array([x, 0.0, 0.0]))) for x in (-0.6, 0.6)]
    names = ("left", "right")
    return ObjectModel(
        "poles",
        tuple(
            Component(name, markers, required=name == "left", bodies=bodies)
            for name, (markers, bodies) in zip(names, parts, strict=True)
        ),
    )


@pytest.mark.parametrize(
    ("turn", "lean"), [(0.0, 0.1), (0.5, 0.0), (-0.7, 0.2), (0.9, -0.1), (-0.3, -0.2), (0.25, 0.3)]
)
def test_both_poles_are_seen_where_they_stand_and_not_one_behind_the_other(turn, lean):
    """A cylinder tells nothing of how it is turned about its axis, and on it the other one may lie, mostly hidden."""
    upright = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    R = rotation_from_rotvec([0, 0, lean]) @ rotation_from_rotvec([0, turn, 0]) @ upright
    pose = Poses(R[None], np.array([[0.05, 0.02, 1.8]]), np.zeros((1, 0)))
    labels = render(CAMERA, [(poles(), pose, RED)])
    config = replace(DEFAULTS, time_budget_ms=60000.0)
    (told,) = (
        Recognizer([Target("poles", poles(), RED)], config, Segmenter(ImageConfig()))
        .recognize(labels, CAMERA)
        .detections
    )
    assert len(told.components) == 2
    across = told.pose.rotation[:, 0]
    assert abs(across @ R[:, 0]) > np.cos(0.12)  # either may be the left one
    assert np.linalg.norm(told.pose.position - pose.t[0]) < 0.06


def test_poses_on_the_same_blobs_come_together():
    model, pose = bars(), at(0.3, 0.3)
    blobs = find_blobs(render(CAMERA, [(model, pose, RED)]), {RED}, DEFAULTS)
    together = three_points(model).of(SEEN, blobs, np.ones(len(blobs), bool))
    assert 1 <= len(together) <= 2  # either blob is one marker, or the other one
    assert sum(map(len, together)) > len(together)


@pytest.mark.parametrize(("turn", "off"), [(0.2, 0.0), (0.0, 0.004), (0.3, 0.004)])
def test_middles_on_a_line_tell_nothing_about_it_and_do_not_stand_before_ends(turn, off):
    """A fence of five posts: rounding, or posts that are not set quite straight, make triangles of nothing."""
    about = rotation_from_rotvec([0, 0, turn])
    posts = [
        Component(
            f"p{n}",
            (marker("post", rectangle(0.012, 0.09), about, about @ np.array([x, off * (n == 1), 0.0])),),
            required=n == 0,
            label=RED + n if n else None,
        )
        for n, x in enumerate((-0.6, -0.3, 0.0, 0.3, 0.6))
    ]
    assert all(len(three.markers) == 2 for three in three_points(ObjectModel("fence", tuple(posts)))._threes)
