"""Like men on a rod that slides: with one at its end hidden the rod looks the same one place on."""

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
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.joint_steps import JointSteps
from artrec_ros.core.recognizer import Recognizer

TEAM, MEN, PITCH, REACH = 3, 4, 0.035, 0.045
BLOCK = np.array([(-0.145, -0.02), (-0.115, -0.02), (-0.115, 0.02), (-0.145, 0.02)])
PLACES = {"near": -PITCH, "middle": 0.0, "far": PITCH}
CAMERA = Camera(np.array([[400.0, 0, 159.5], [0, 400.0, 119.5], [0, 0, 1]]), np.zeros(0), (320, 240))


def man(x: float) -> Marker:
    at = Pose(np.eye(3), np.array([x, 0.0, 0.0]))
    marker = disc("man", 0.009)
    return Marker(marker.name, marker.outline, marker.tail, marker.head, marker.disc_radius, at)


def rod(places=None, slide=None):
    (first, x), *others = (places or PLACES).items()
    carried = slide or hinge("block", (0, 0, 0), (1, 0, 0), "prismatic", (-REACH, REACH))
    fixed = Joint(first, Pose.identity(), np.array([1.0, 0, 0]), 0.0, 0.0, "fixed")
    men = [Component(first, (man(x),), label=MEN, joint=carried)]
    men += [Component(name, (man(x),), label=MEN, joint=fixed) for name, x in others]
    return ObjectModel("rod", (Component("block", (patch("block", BLOCK),), required=True), *men))


class Rod(Placing):
    """`name`: who is seen; `arm`: how far the men have slid."""

    def patches(self):
        men = [self.at(man(0).outline + (PLACES[n] + self.arm, 0.0)) for n in self.name.split()]
        return [(self.at(BLOCK), TEAM), *((outline, MEN) for outline in men)]


def told(who, slid, camera=None):
    engine = Recognizer((Target("rod", rod(), TEAM),), settings(time_budget_ms=60000), Segmenter(ImageConfig()))
    labels = rendered(Rod(170.0, 120.0, 0.3, 800.0, who, slid), size=CAMERA.size, fine=4)
    (one,) = engine.recognize(labels, camera).detections
    return one, {part.component: part.score for part in one.components}


@pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "space"])
@pytest.mark.parametrize(("who", "slid"), [("middle far", -0.01), ("near middle", 0.01), ("middle far", -0.02)])
def test_who_is_seen_may_be_the_next_one(camera, who, slid):
    one, scores = told(who, slid, camera)
    assert scores["block"] > 0.9 and one.score > 0.9  # the rod is there, wherever its men are
    assert all(0.3 < score < 0.75 for name, score in scores.items() if name != "block")
    if camera is not None:
        assert 0.4 * PITCH < one.joint_deviations["near"] < 0.8 * PITCH


@pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "space"])
@pytest.mark.parametrize(
    ("who", "slid"),
    [
        ("near middle far", 0.01),  # all of them
        ("near far", 0.0),  # the gap tells
        ("middle far", 0.03),  # one place on would be beyond the limit
    ],
)
def test_who_can_be_no_other_is_told_as_sure_as_ever(camera, who, slid):
    one, scores = told(who, slid, camera)
    assert all(score > 0.85 for score in scores.values()) and len(scores) == 1 + len(who.split())
    if camera is not None:
        assert abs(one.joints["near"] - slid) < 0.004
        assert one.joint_deviations["near"] < 0.35 * PITCH


def test_a_whole_step_of_a_wheel_is_none():
    """Nobody can tell like spokes from each other; where one is missing, the others may be any of them."""
    turn = 2 * np.pi / 3
    at = {name: 0.05 * np.array([np.cos(n * turn), np.sin(n * turn)]) for n, name in enumerate("abc")}

    def steps(names):
        block = Component("block", (patch("block", BLOCK),), required=True)
        wheel = hinge("block", (0, 0, 0), (0, 0, 1), limits=(-np.pi, np.pi))
        first, *others = names
        fixed = Joint(first, Pose.identity(), np.array([0, 0, 1.0]), 0.0, 0.0, "fixed")
        spokes = [
            Component(n, (disc_at(at[n]),), label=MEN, joint=wheel if n == first else fixed) for n in (first, *others)
        ]
        finder = WholeObjectFinder(
            Target("wheel", ObjectModel("wheel", (block, *spokes)), TEAM), settings(), facing=True
        )
        return {round(float(by), 3) for one in JointSteps(finder.surface).of.values() for by in one.by}

    assert steps("abc") == set()
    assert sorted(steps("ab")) == pytest.approx([-turn, turn], abs=0.03)


def disc_at(place) -> Marker:
    marker = disc("spoke", 0.01)
    at = Pose(np.eye(3), np.array([*place, 0.0]))
    return Marker(marker.name, marker.outline, marker.tail, marker.head, marker.disc_radius, at)
