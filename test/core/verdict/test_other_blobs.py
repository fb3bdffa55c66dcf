"""How sure a part on a joint is where another blob that may be it lies in the joint's reach."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from settings import settings

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Missing
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

SIZE, AT, PX_PER_M = (400, 300), np.array([190.0, 150.0]), 100.0
CAMERA = Camera.pinhole(SIZE, 400.0)
LIMITS = {"time_budget_ms": 60000.0, "min_scale": 85.0, "max_scale": 118.0}
TRUNK = np.array([(-0.6, -0.2), (0.3, -0.2), (0.6, 0.0), (0.3, 0.2), (-0.6, 0.2)])
Z = np.array([0.0, 0.0, 1.0])
KINDS = pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "space"])


def disc(radius, at=None):
    angles = 2 * np.pi * np.arange(32) / 32
    outline = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return Marker("m", outline, np.array([-radius, 0]), np.array([radius, 0]), radius, at or Pose.identity())


def arm():
    """A trunk, and a hand on a joint."""
    trunk = Component("trunk", (Marker("m", TRUNK, TRUNK[0] * [1, 0], TRUNK[2], None, Pose.identity()),), True)
    hand = disc(0.14, Pose(np.eye(3), np.array([1.0, 0, 0])))
    joint = Joint("trunk", Pose(np.eye(3), np.array([0.6, 0, 0])), Z, -1.2, 1.2, name="swing")
    return Target("arm", ObjectModel("arm", (trunk, Component("hand", (hand,), False, 2, joint))), 1)


def slider():
    """A disc, which tells no direction, and another one that slides away from it."""
    joint = Joint("trunk", Pose(np.eye(3), np.array([1.0, 0, 0])), np.array([1.0, 0, 0]), -0.3, 0.3, "prismatic")
    parts = Component("trunk", (disc(0.15),), True), Component("hand", (disc(0.13),), False, 2, joint)
    return Target("slider", ObjectModel("slider", parts), 1)


def hand_at(angle, far=1.0):
    """Pixels of a hand in the trunk's frame."""
    return np.array([0.6 + far * np.cos(angle), far * np.sin(angle)])


def picture(hands, turn=0.0, root=TRUNK, rng=None):
    """:param hands: places in the object's frame, and radii."""
    c, s = np.cos(turn), np.sin(turn)
    R, labels = np.array([[c, -s], [s, c]]), np.zeros(SIZE[::-1], np.uint8)

    def fill(outline, label):
        pixels = AT + PX_PER_M * (outline @ R.T) * [1, -1]
        cv2.fillPoly(labels, [np.rint(pixels * 16).astype(np.int32)], label, shift=4)

    fill(root, 1)
    for at, radius in hands:
        fill(at + disc(radius).outline, 2)
    if rng is not None:
        labels[rng.random(labels.shape) < 0.02] = 0
    return labels


def engine_of(target, camera):
    return Recognizer((target,), settings(**LIMITS), Segmenter(ImageConfig()), calibrated=camera is not None)


def found_in(labels, camera, target=None):
    (detection,) = engine_of(target or arm(), camera).recognize(labels, camera).detections
    return detection


@KINDS
@pytest.mark.parametrize("angles", [(0.5, -0.5), (0.9, -0.3), (0.2, -0.9)])
def test_one_of_two_like_hands_is_told_as_a_half(angles, camera):
    found = found_in(picture([(hand_at(a), 0.14) for a in angles]), camera)
    alone = found_in(picture([(hand_at(angles[0]), 0.14)]), camera)
    assert alone.instance_of("hand").score > 0.9 and not alone.missing
    assert 0.2 < found.instance_of("hand").score < 0.9
    assert found.as_told == 1 and found.score > 0.95  # it is there, and its direction is sure
    if camera is not None:
        assert found.joint_deviations["swing"] > 0.2 > alone.joint_deviations["swing"]


@KINDS
def test_where_the_other_one_is_is_told(camera):
    found = found_in(picture([(hand_at(a), 0.14) for a in (0.5, -0.5)]), camera)
    (other,) = found.missing
    told = min((0.5, -0.5), key=lambda a: abs(a - found.joints["swing"]))
    assert isinstance(other, Missing) and (other.component, other.state) == ("hand", "elsewhere")
    assert np.hypot(*(AT + PX_PER_M * hand_at(-told) * [1, -1] - (other.x, other.y))) < 2
    assert other.score == pytest.approx(1 - found.instance_of("hand").score, abs=0.02)


@KINDS
@pytest.mark.parametrize("other", [(-0.5, 1.0, 0.20), (-0.5, 1.0, 0.095), (1.75, 1.0, 0.14), (-0.5, 1.5, 0.14)])
def test_what_is_of_another_size_or_beyond_its_limits_costs_little(other, camera):
    angle, far, radius = other
    found = found_in(picture([(hand_at(0.5), 0.14), (hand_at(angle, far), radius)]), camera)
    assert found.instance_of("hand").score > 0.9 and found.joints["swing"] == pytest.approx(0.5, abs=0.05)


@KINDS
def test_of_three_like_hands_each_is_a_third(camera):
    found = found_in(picture([(hand_at(a), 0.14) for a in (0.8, 0.0, -0.8)]), camera)
    assert 0.15 < found.instance_of("hand").score < 0.65


@KINDS
def test_about_a_disc_its_direction_is_in_doubt_too(camera):
    """The object turns with what slides."""
    hands = [(1.05 * np.array([np.cos(a), np.sin(a)]), 0.13) for a in (0.3, 1.9)]
    found = found_in(picture(hands, root=disc(0.15).outline), camera, slider())
    alone = found_in(picture(hands[:1], root=disc(0.15).outline), camera, slider())
    assert alone.instance_of("hand").score > 0.8 and alone.as_told == 1
    assert found.instance_of("hand").score < 0.8 and found.as_told < 0.85
    assert found.score == pytest.approx(found.there * found.as_told)


@KINDS
def test_in_a_film_the_one_told_before_is_told_on(camera):
    engine, rng, memory, told = engine_of(arm(), camera), np.random.default_rng(3), None, []
    for n in range(12):
        turn = 0.02 * n
        labels = picture([(hand_at(a + 0.02 * n), 0.14) for a in (0.45, -0.55)], turn, rng=rng)
        result, memory = engine.follow(labels, camera, n * 50_000_000, memory)
        (found,) = result.detections
        told.append(found.joints["swing"] - 0.02 * n)
        assert found.instance_of("hand").score < 0.9
    assert np.ptp(told) < 0.1
