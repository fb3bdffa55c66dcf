"""Robots of five discs: the one in the middle tells no direction, and turned wrong some of the others lie on others."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scene import disc
from settings import settings
from squares import TEAM, Placing, hinge, rendered

from artrec_ros.core import facing_search
from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.directions import Directions
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.recognizer import Recognizer

MIDDLE, DOT, DOTS_LABEL = disc("middle", 0.025), disc("dot", 0.02), 7
DOTS = {"fl": (0.035, 0.055), "fr": (0.035, -0.055), "bl": (-0.055, 0.035), "br": (-0.055, -0.035)}


def dotted(dots, outline=None):
    middle = replace(MIDDLE, T_component_marker=Pose.identity(), **(outline or {}))
    markers = {n: replace(DOT, T_component_marker=Pose(np.eye(3), np.array([*at, 0.0]))) for n, at in dots.items()}
    others = [Component(name, (marker,), label=DOTS_LABEL) for name, marker in markers.items()]
    return ObjectModel("robot", (Component("middle", (middle,), required=True), *others))


class Dotted(Placing):
    def patches(self):
        others = [(self.at(DOT.outline + at), DOTS_LABEL) for at in DOTS.values()]
        return [(self.at(MIDDLE.outline), TEAM), *others]


@pytest.mark.parametrize("scale", [80.0, 100.0, 220.0])
def test_none_is_turned_to_where_other_discs_of_it_are(scale):
    """Discs of 3 px, and of 9."""
    turns = np.random.default_rng(int(scale)).uniform(-np.pi, np.pi, 35)
    at = [(35 + 55 * (n % 7) + turn / 7, 35 + 55 * (n // 7) - turn / 9) for n, turn in enumerate(turns)]
    placed = [Dotted(x, y, turn, scale) for (x, y), turn in zip(at, turns, strict=True)]
    engine = Recognizer(
        (Target("robot", dotted(DOTS), TEAM),), settings(time_budget_ms=60000), Segmenter(ImageConfig())
    )
    found = engine.recognize(rendered(*placed, size=(405, 290), fine=4)).detections
    assert len(found) == len(placed)
    for d in found:
        parts = {part.component: np.array([part.x, part.y]) for part in d.components}
        one = min(placed, key=lambda p: np.hypot(p.x - d.image.x, p.y - d.image.y))
        for name, where in DOTS.items():
            assert np.linalg.norm(parts[name] - one.at([where])[0]) < 0.5 * 0.065 * scale, (one, name)


CLAW_LABEL, CLAW = 5, replace(disc("claw", 0.018), T_component_marker=Pose(np.eye(3), np.array([0.05, 0.0, 0.0])))
EYES = {"left": (0.062, 0.03), "right": (0.062, -0.03)}


def bug():
    """A disc with two small ones before it, and a claw behind it on a hinge."""
    shell = dotted(EYES)
    behind = hinge("middle", (-0.06, 0.0, 0.0), (0, 0, 1), limits=(-0.9, 0.9))
    claw = Component(
        "claw",
        (replace(CLAW, T_component_marker=Pose(np.eye(3), np.array([-0.05, 0.0, 0.0]))),),
        label=CLAW_LABEL,
        joint=behind,
    )
    return ObjectModel("bug", (*shell.components, claw))


class Bug(Placing):
    def patches(self):
        c, s = np.cos(self.arm), np.sin(self.arm)
        claw = (-0.06 - 0.05 * c, -0.05 * s)
        eyes = [(self.at(DOT.outline + at), DOTS_LABEL) for at in EYES.values()]
        return [(self.at(MIDDLE.outline), TEAM), *eyes, (self.at(CLAW.outline + claw), CLAW_LABEL)]


@pytest.mark.parametrize("scale", [110.0, 160.0])
def test_those_with_joints_are_not_turned_wrong_either(scale):
    rng = np.random.default_rng(int(scale))
    placed = [
        Bug(
            45 + 75 * (n % 5) + rng.uniform(),
            45 + 75 * (n // 5),
            *rng.uniform((-np.pi, scale), (np.pi, scale)),
            arm=rng.uniform(-0.9, 0.9),
        )
        for n in range(20)
    ]
    engine = Recognizer((Target("bug", bug(), TEAM),), settings(time_budget_ms=60000), Segmenter(ImageConfig()))
    found = engine.recognize(rendered(*placed, size=(390, 320), fine=4)).detections
    assert len(found) == len(placed)
    for d in found:
        one = min(placed, key=lambda p: np.hypot(p.x - d.image.x, p.y - d.image.y))
        parts = {part.component: np.array([part.x, part.y]) for part in d.components}
        for name, where in EYES.items():
            assert np.linalg.norm(parts[name] - one.at([where])[0]) < 0.02 * scale, (one, name)


def test_a_disc_alone_is_nothing_for_it_tells_no_direction():
    """A real one stands beside; a model of nothing but a disc, which looks the same in all directions, is told."""
    robot = Dotted(60, 60, 0.4, 220.0)
    labels = rendered(robot, size=(160, 120), fine=4)
    alone = rendered(Dotted(125, 60, 0.0, 220.0), size=(160, 120), fine=4) == TEAM
    labels[alone] = TEAM
    engine = Recognizer((Target("robot", dotted(DOTS), TEAM),), settings(), Segmenter(ImageConfig()))
    result = engine.recognize(labels)
    (found,) = result.detections
    assert np.hypot(found.image.x - robot.x, found.image.y - robot.y) < 1 and found.score > 0.9
    reasons = [r.reason for r in result.rejected if np.hypot(r.x - 125, r.y - 60) < 2]
    assert any("a disc, which tells no direction" in reason for reason in reasons), reasons
    ball = Recognizer((Target("robot", dotted({}), TEAM),), settings(), Segmenter(ImageConfig()))
    assert len(ball.recognize(labels).detections) == 2


THREE = {"front": (0.0418, 0.0), "left": (-0.0418, 0.0215), "right": (-0.0418, -0.0215)}


class Three(Placing):
    """Discs that are all alike."""

    def patches(self):
        return [(self.at(DOT.outline + at), TEAM) for at in THREE.values()]


@pytest.mark.parametrize(("x", "y", "turn"), [(-8, 60, 2.6), (-8, 60, 2.2), (80, -8, -1.9)])
def test_nor_does_one_of_the_others_alone(x, y, turn):
    """The required one lies beyond the border: of the others but one is seen."""
    parts = [
        Component(n, (replace(DOT, T_component_marker=Pose(np.eye(3), np.array([*at, 0.0]))),), required=n == "front")
        for n, at in THREE.items()
    ]
    looks = settings(required="visible", time_budget_ms=60000, min_scale=200.0, max_scale=260.0)
    engine = Recognizer((Target("three", ObjectModel("three", tuple(parts)), TEAM),), looks, Segmenter(ImageConfig()))
    labels = rendered(Three(x, y, turn, 220.0), size=(160, 120), fine=4)
    assert labels.any() and not engine.recognize(labels).detections


def about(model):
    config = settings()
    return Directions.about_required(
        WholeObjectFinder(Target("robot", model, TEAM), config, facing=True), config
    ), config


def test_small_discs_far_out_want_smaller_steps_and_more_that_go_on():
    directions, config = about(dotted(DOTS))
    assert directions.laid == 1 and directions.kept == 4 * 3
    most = 0.02 / np.hypot(0.055, 0.035) * config.facing.disc_step
    assert 2 * np.pi / directions.turned <= most < 2 * np.pi / (directions.turned - 1)
    farther, _ = about(dotted({**DOTS, "far": (0.3, 0.0)}))
    assert farther.turned > 4 * directions.turned and farther.kept == 5 * 4


def test_what_a_joint_turns_to_where_it_is_wants_no_smaller_steps():
    directions, _ = about(bug())
    assert directions.turned == about(dotted(EYES))[0].turned


@pytest.mark.parametrize("model", [dotted({}), dotted(DOTS, {"disc_radius": None})])
def test_what_has_nothing_around_it_or_an_outline_is_tried_as_configured(model):
    directions, config = about(model)
    assert directions == Directions(config.facing.turns, 1, config.facing.per_patch)


def test_directions_in_which_no_pixel_speaks_for_another_marker_are_not_looked_into(monkeypatch):
    """Specks of the disc's class all over an image took seconds, each turned all around; the robot is found."""
    rows, ranked = list[int](), facing_search.with_joints
    monkeypatch.setattr(
        facing_search, "with_joints", lambda f, i, poses: rows.append(len(poses)) or ranked(f, i, poses)
    )
    labels = rendered(Dotted(60, 60, 0.4, 200.0), size=(300, 120), fine=4)
    for x in range(120, 290, 40):
        cv2.circle(labels, (x, 60), 5, TEAM, -1)
    looks = settings(time_budget_ms=60000, min_scale=180.0, max_scale=220.0)
    engine = Recognizer((Target("robot", dotted(DOTS), TEAM),), looks, Segmenter(ImageConfig()))
    (found,) = engine.recognize(labels).detections
    assert len(found.components) == 5 and np.hypot(found.image.x - 60, found.image.y - 60) < 1
    assert sum(rows) < 4 * 2 * about(dotted(DOTS))[0].turned  # of six discs, as laid and at rest on their contours
