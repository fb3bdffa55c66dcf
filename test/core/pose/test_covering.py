"""Parts of one class that lie over each other: each pixel speaks for one of them, and no outline is broken by its own
object."""

import numpy as np
import pytest
from settings import DEFAULTS

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, Scene
from artrec_ros.simulation.sensor import majority_labels

pytestmark = pytest.mark.uncompiled
RED, BLUE = 3, 2
CAMERA = Camera.facing((200, 160))
FACED = np.diag([1.0, -1.0, -1.0])


def bar(z, label=None, joint=None, required=False, name="blade", body=None):
    outline = np.array([(-0.1, -0.012), (0.1, -0.012), (0.1, 0.012), (-0.1, 0.012)])
    marker = Marker(
        "m", outline, np.array([-0.1, 0.0]), np.array([0.1, 0.0]), None, Pose(np.eye(3), np.array([0, 0, z]))
    )
    return Component(name, (marker,), required, label, joint, (body,) if body else (), RED if body else None)


def scissors(z=0.003, label=None):
    pin = Joint("low", Pose.identity(), np.array([0.0, 0.0, 1.0]), -1.6, 1.6)
    return ObjectModel("scissors", (bar(0.0, required=True, name="low"), bar(z, label, pin, name="high")))


def judged(model, opening, shown=None):
    """A verdict on the model where it is, in the labels of `shown`, or of itself."""
    at = Poses(FACED[None], np.array([[0.0, 0.0, CAMERA.focal_px / 700]]), np.array([[opening]]))
    placed = PlacedObject(
        Target("x", shown or model, RED), Pose(FACED, at.t[0]), {"high": opening} if not shown else {}
    )
    labels = majority_labels(Renderer(CAMERA).render(Scene((placed,), (), None)).sample_labels).astype(np.uint8)
    finder = WholeObjectFinder(Target("scissors", model, RED), DEFAULTS, facing=True)
    frame = ImageFrame(LabelField(labels), CAMERA)
    return Judge.of(DEFAULTS).verdicts(finder, at, frame)[0]


@pytest.mark.parametrize("opening", [0.7, -1.2])
def test_a_part_across_another_breaks_no_outline(opening):
    one_colour, two_colours = judged(scissors(), opening), judged(scissors(label=BLUE), opening)
    assert one_colour.confirmed == (True, True)
    assert min(one_colour.parted) > 0.97
    assert one_colour.outline[1] == pytest.approx(two_colours.outline[1], abs=0.12)
    assert one_colour.probability > 0.5


@pytest.mark.parametrize("z", [0.003, 0.0, -0.003])
def test_a_rod_is_one_blade_and_not_two(z):
    rod = ObjectModel("rod", (bar(0.0, required=True, name="low"),))
    both = judged(scissors(z), 0.0, shown=rod)
    behind = 0 if z > 0 else 1  # of one plane what comes first lies on top
    area = both.claim.scores.area_px[0]
    assert area[behind] < 0.1 * area[1 - behind]
    assert sum(both.confirmed) == 1


def test_a_body_of_its_class_breaks_no_outline_either():
    pin = Joint("low", Pose.identity(), np.array([0.0, 0.0, 1.0]), -1.6, 1.6)
    arm = Box(Pose.from_xyz_rpy((0.0, 0.0, -0.004)), np.array([0.2, 0.03, 0.006]))
    model = ObjectModel("toy", (bar(0.0, required=True, name="low"), bar(-0.0005, BLUE, pin, name="high", body=arm)))
    verdict = judged(model, 1.2)
    assert verdict.parted[0] > 0.95 and verdict.confirmed[0]
