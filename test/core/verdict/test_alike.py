"""What less is said of an object because its components look alike."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hands import SIZE, hand, picture, places
from legs import along, disc
from settings import DEFAULTS, settings

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.alike import alike_of
from artrec_ros.core.verdict.alike_kernels import freedom, times_mixed_up
from artrec_ros.simulation.simulator import pinhole_camera

CAMERA = pinhole_camera(SIZE, 56.14)
PALM = ("p0", "p1", "p2")


def of(target, *names, facing=False):
    """`freedom` where some components are confirmed, and how many times as easily chance bears that out."""
    surface = WholeObjectFinder(target, DEFAULTS).surface
    by = alike_of(surface, DEFAULTS.verdict, facing=facing)
    confirmed = np.array([c.name in names for c in target.model.components])
    spare, distinct = freedom(surface.kinematics.chain, by, confirmed)
    return spare, math.exp(-distinct), times_mixed_up(by, spare, distinct)


def painted(target, classes):
    """The same with some components in classes of their own."""
    parts = tuple(replace(c, label=classes.get(c.name, c.label)) for c in target.model.components)
    return replace(target, model=ObjectModel(target.model.name, parts))


def test_dots_tell_two_numbers_each_less_the_pose_and_the_joints_between_them():
    spare, ways, _ = of(hand(), *PALM)
    assert spare == 3 * 2 - 6 and ways == pytest.approx(9 * 8 * 7)
    spare, ways, _ = of(hand(), "p0", "m0", "t2")  # knuckle, knuckle and bend are between them
    assert spare == 3 * 2 - 6 - 3 and ways == pytest.approx(9 * 8 * 7)
    assert of(hand(), "m0", "t0")[0] == 2 * 2 - 6 - 1, "a joint that carries both says nothing of either"
    spare, ways, _ = of(hand(), *PALM, "m0", "m1")
    assert spare == 5 * 2 - 6 - 2 and ways == pytest.approx((9 * 8 * 7 * 6 * 5) ** (6 / 10)), "three of five fix a pose"


def test_chance_makes_much_of_a_few_dots_and_nothing_of_all_of_them():
    few, palm, all_of_them = (of(hand(), *names)[2] for names in (("p0", "m0", "t2"), PALM, _names()))
    assert few > 2 * palm > 10 and all_of_them < 10  # of odds that are thousands to one


def test_more_of_a_chain_of_dots_is_never_believed_less():
    z, parts = np.array([0.0, 0.0, 1.0]), [Component("c0", (disc(0.0),), required=True)]
    for n in range(1, 60):
        parts.append(Component(f"c{n}", (disc(0.5),), joint=Joint(f"c{n - 1}", along(0.5), z, -0.5, 0.5, name=f"j{n}")))
    chain = Target("chain", ObjectModel("chain", tuple(parts)), 1)
    each = [of(chain, *(c.name for c in parts[:k]))[2] for k in (3, 5, 10, 20, 40, 60)]
    assert each == sorted(each, reverse=True) and each[-1] < 1.01


def test_all_of_a_large_board_lose_nothing():
    at = np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0)), axis=-1).reshape(-1, 2)
    dots = [replace(disc(0.0), T_component_marker=Pose(np.eye(3), np.array([x, y, 0.0]))) for x, y in at]
    parts = tuple(Component(f"c{n}", (dot,), required=n == 0) for n, dot in enumerate(dots))
    board = Target("board", ObjectModel("board", parts), 1)
    assert of(board, *(c.name for c in parts))[2] == pytest.approx(1)
    assert of(board, "c0", "c1", "c2")[2] > 10


def test_what_is_unlike_all_else_loses_nothing():
    unlike = painted(hand(), {"p1": 6, "p2": 7})
    assert of(hand(), "p0", "p1", "p2")[2] > of(unlike, "p0", "p1", "p2")[2] > 1
    own = painted(hand(), {name: 10 + n for n, name in enumerate(_names())})
    assert of(own, *PALM)[1:] == (1.0, 1.0)


def test_one_alone_and_what_faces_the_camera_are_judged_as_before():
    assert of(hand(), "p0")[1:] == (1.0, 1.0)
    assert of(hand(), *PALM, facing=True)[2] == 1.0


@pytest.fixture(scope="module")
def engine():
    config = settings(time_budget_ms=60000.0, min_range_m=4.8, max_range_m=7.5)
    return Recognizer((hand(),), config, Segmenter(ImageConfig()), calibrated=True)


def test_three_dots_that_belong_to_nothing_are_hardly_a_hand_and_nine_are_one(engine):
    rng = np.random.default_rng(1)
    for _ in range(3):
        strays = rng.uniform((60, 60), (580, 420), (3, 2))
        assert all(d.score < 0.5 for d in engine.recognize(picture(strays), CAMERA).detections)
    own = places((250, 300), (0.2, 0.6, 0.9))
    (told,) = engine.recognize(picture(own), CAMERA).detections
    assert told.score > 0.9 and len(told.components) == 9


def _names():
    return [c.name for c in hand().model.components]
