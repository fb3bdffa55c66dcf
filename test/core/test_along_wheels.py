"""A wheel of four like blades of which one is marked: all blades lie on their colours after a quarter turn, too."""

import numpy as np
import pytest
from scene import disc
from settings import settings
from squares import Placing, hinge, patch, rendered

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

TEAM, HUB, BLADE, DOT, SEEN = 3, 6, 2, 7, 0.055
QUARTER = np.pi / 2
CAMERA = Camera(np.array([[400.0, 0, 159.5], [0, 400.0, 119.5], [0, 0, 1]]), np.zeros(0), (320, 240))
STAND = np.array([(-0.06, -0.17), (0.06, -0.17), (0.045, -0.115), (0.0, -0.105), (-0.045, -0.115)])
OUTLINE = np.array([(0.022, -0.009), (0.085, -0.016), (0.09, 0.0), (0.085, 0.012), (0.022, 0.009)])
PLACES = {f"blade_{n}": n * QUARTER for n in range(4)}


def turned(points, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(points) @ np.array([[c, s], [-s, c]])


def round_at(name, x, radius):
    marker = disc(name, radius)
    at = Pose(np.eye(3), np.array([x, 0.0, 0.0]))
    return Marker(marker.name, marker.outline, marker.tail, marker.head, marker.disc_radius, at)


def wheel(limit=np.pi):
    fixed = Joint("hub", Pose.identity(), np.array([0, 0, 1.0]), 0.0, 0.0, "fixed")
    axis = hinge("stand", (0, 0, 0), (0, 0, 1), limits=(-limit, limit))
    blades = [Component(n, (patch(n, turned(OUTLINE, a)),), label=BLADE, joint=fixed) for n, a in PLACES.items()]
    stand = Component("stand", (patch("stand", STAND),), required=True)
    hub = Component("hub", (round_at("hub", 0.0, 0.015),), label=HUB, joint=axis)
    dot = Component("dot", (round_at("dot", SEEN, 0.007),), label=DOT, joint=fixed)
    return ObjectModel("wheel", (stand, hub, *blades, dot))


class Wheel(Placing):
    """`name`: what is to be seen of the mark; `arm`: how far the wheel is turned."""

    def patches(self):
        blades = [(self.at(turned(OUTLINE, self.arm + a)), BLADE) for a in PLACES.values()]
        outline = round_at("dot", 0.0, 0.007).outline
        mark = [(self.at(turned(outline + (SEEN, 0.0), self.arm)), DOT)] * (self.name == "dot")
        over = np.array([(-0.012, -0.012), (0.012, -0.012), (0.012, 0.012), (-0.012, 0.012)])
        hidden = [(self.at(turned(over + (SEEN, 0.0), self.arm)), 0)] * (self.name == "covered")
        hub = round_at("hub", 0.0, 0.015).outline
        return [(self.at(STAND), TEAM), (self.at(hub), HUB), *blades, *mark, *hidden]


def told(shows, angle, camera, limit=np.pi):
    engine = Recognizer(
        (Target("wheel", wheel(limit), TEAM),), settings(time_budget_ms=60000), Segmenter(ImageConfig())
    )
    labels = rendered(Wheel(160.0, 105.0, 0.3, 650.0, shows, angle), size=CAMERA.size, fine=4)
    (one,) = engine.recognize(labels, camera).detections
    off = (one.joints["hub"] - angle + np.pi) % (2 * np.pi) - np.pi
    return one, off, {part.component: part.score for part in one.components}


CAMERAS = pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "space"])
ANGLES = pytest.mark.parametrize("angle", [-2.3, -0.9, 0.5, 2.0])


@CAMERAS
@ANGLES
def test_a_mark_that_is_seen_tells_the_turn(camera, angle):
    one, off, scores = told("dot", angle, camera)
    assert abs(off) < 0.02
    assert one.score > 0.9 and min(scores.values()) > 0.85 and "dot" in scores
    if camera is not None:
        assert one.joint_deviations["hub"] < 0.02


@CAMERAS
@ANGLES
def test_a_mark_that_is_covered_is_where_something_covers_a_blade(camera, angle):
    one, off, scores = told("covered", angle, camera)
    assert abs(off) < 0.02
    assert all(0.4 < scores[name] < 0.9 for name in PLACES)
    if camera is not None:
        assert one.joint_deviations["hub"] > 0.5


@CAMERAS
def test_without_a_mark_all_turns_are_as_likely(camera):
    one, off, scores = told("nothing", 0.5, camera)
    assert one.score > 0.9 and scores["stand"] > 0.9 and scores["hub"] > 0.9  # which turn they all have
    assert all(0.2 < scores[name] < 0.3 for name in PLACES)
    assert abs(np.sin(2 * off)) < 0.05
    if camera is not None:
        assert one.joint_deviations["hub"] > 1.5


@CAMERAS
def test_limits_leave_no_other_turn(camera):
    one, off, scores = told("nothing", 0.3, camera, limit=0.7)
    assert abs(off) < 0.02
    assert all(scores[name] > 0.85 for name in PLACES)
    if camera is not None:
        assert one.joint_deviations["hub"] < 0.02


@CAMERAS
def test_a_mark_beyond_the_limits_is_told_elsewhere(camera):
    one, _, scores = told("dot", 0.3 + QUARTER, camera, limit=0.7)
    (dot,) = one.missing
    assert "dot" not in scores and (dot.component, dot.state) == ("dot", "elsewhere")
    assert one.as_told < 1
