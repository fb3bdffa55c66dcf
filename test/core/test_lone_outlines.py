"""Objects that are one flat marker which all but repeats itself: which way round it lies, and how sure that is."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import rectangle
from squares import SIZE, TEAM, Placing, patch, rendered

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.facing_lone import FacingLone
from artrec_ros.core.geometry.transforms import wrap_angle
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.differing import MarkerPixels, differing_odds, odds_among
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.seen_alike import SeenAlike
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer

SHALLOW, DEEP = 0.005, 0.02  # metres, of a notch as a file has it and as it is


def lever(deep):
    """(8, 2) a plate with a notch at one end."""
    ends = [(0.08, 0.02), (0.06, 0.02), (0.06, 0.02 - deep), (0.04, 0.02 - deep), (0.04, 0.02), (-0.08, 0.02)]
    return np.array([(-0.08, -0.02), (0.08, -0.02), *ends])


def model_of(outline):
    return ObjectModel("lever", (Component("lever", (patch("plate", outline),), required=True),))


class Lever(Placing):
    deep = DEEP

    def patches(self):
        notch = [(0.06, 0.021), (0.06, 0.02 - self.deep), (0.04, 0.02 - self.deep), (0.04, 0.021)]
        return [(self.at(rectangle(0.16, 0.04)), TEAM), (self.at(notch), 0)]


class Shallow(Lever):
    deep = SHALLOW


def found(image, drawn=SHALLOW):
    target = Target("lever", model_of(lever(drawn)), TEAM)
    recognizer = Recognizer([target], settings(), Segmenter(ImageConfig()), calibrated=False)
    (detection,) = recognizer.recognize(image).detections
    return detection


def is_right(detection, placing):
    """Directions are clockwise in the image."""
    return abs(wrap_angle(detection.image.theta + placing.turn)) < np.radians(15)


class Marked(Lever):
    deep = 0.009  # as much as `artrec model` promises a direction by


PLACINGS = [(80.0, 60.0, turn, scale) for turn, scale in ((0.3, 500.0), (1.9, 420.0), (-2.4, 610.0), (3.0, 700.0))]


@pytest.mark.parametrize("at", PLACINGS)
def test_what_the_file_has_too_small_tells_the_direction_for_all_that(at):
    placing = Lever(*at)
    detection = found(rendered(placing))
    assert is_right(detection, placing) and detection.score > 0.6
    assert detection.other_place is None


@pytest.mark.parametrize("at", PLACINGS)
def test_an_exact_file_costs_no_certainty(at):
    placing = Shallow(*at)
    detection = found(rendered(placing))
    assert is_right(detection, placing) and detection.score > 0.9 and detection.as_told > 0.97


def test_where_something_lies_on_what_tells_its_two_directions_either_may_be_the_true_one():
    placing = Marked(80.0, 60.0, 0.0, 500.0)
    image = rendered(placing)
    for x, y in placing.at([(0.05, 0.0175), (-0.05, -0.0175)]).round().astype(int):  # the notch, and where it would be
        image[y - 3 : y + 4, x - 7 : x + 8] = 0
    detection = found(image, drawn=Marked.deep)
    assert detection.score < 0.9 * detection.there
    assert detection.other_place is not None and detection.other_place.probability > 0.1
    assert abs(abs(wrap_angle(detection.other_place.image.theta - detection.image.theta)) - np.pi) < 0.1


def odds_at(placing, image):
    """That it is turned by half."""
    finder = WholeObjectFinder(Target("lever", model_of(lever(SHALLOW)), TEAM), DEFAULTS, facing=True)
    frame = ImageFrame(LabelField(image)).faced()
    pose = placing.pose(frame.camera)
    both = Poses.concatenate([pose, finder.seen_alike.of([0]).of(pose)])
    return float(differing_odds(finder, frame, both)[1, 0])


def test_only_pixels_in_which_two_turns_differ_tell_them():
    placing = Lever(80.0, 60.0, 0.4, 500.0)
    image = rendered(placing)
    odds, dented = odds_at(placing, image), image.copy()
    cv2.circle(dented, placing.at([(0.0, 0.0)])[0].round().astype(int).tolist(), 7, 0, -1)  # both lack it
    assert odds < -3 and odds_at(placing, dented) == odds
    turned = Lever(80.0, 60.0, 0.4 + np.pi, 500.0)
    assert odds_at(placing, rendered(turned)) > 3
    assert odds_at(placing, np.zeros_like(image)) == pytest.approx(0, abs=1e-6)


def test_of_what_lies_beyond_the_image_nothing_is_told():
    away = Lever(900.0, 60.0, 0.4, 500.0)
    assert odds_at(away, rendered(Lever(80.0, 60.0, 0.4, 500.0))) == 0


class Slight(Lever):
    deep = 0.0035


@pytest.mark.parametrize("turn", [0.3, 0.3 + np.pi])
def test_what_the_file_has_as_good_as_the_same_is_told_right_too_and_costs_no_certainty(turn):
    """`artrec model` promises no direction of it: where none is told it is as sure."""
    placing = Slight(80.0, 60.0, turn, 600.0)
    detection = found(rendered(placing), drawn=0.002)
    assert is_right(detection, placing) and detection.as_told == 1 and detection.other_place is None


@pytest.mark.parametrize(("deep", "turns"), [(SHALLOW, 1), (1e-5, 0), (0.038, 0)])
def test_turns_are_others_that_its_outline_tells_by_little(deep, turns):
    """Of what is the same after a turn nothing tells that, and nobody asks; what is quite another shape is no rival."""
    assert len(SeenAlike(SpatialModel(model_of(lever(deep)), TEAM, DEFAULTS.votes)).of([0])) == turns


def test_all_pixels_of_an_outline_are_counted():
    """Be it large or small, whole or half beyond the image; what it lacks speaks against it."""
    for scale, x in ((90.0, 40.0), (500.0, 80.0), (500.0, 0.0)):
        placing = Lever(x, 60.0, 0.4, scale)
        image = rendered(placing)
        finder = WholeObjectFinder(Target("lever", model_of(lever(DEEP)), TEAM), DEFAULTS, facing=True)
        frame = ImageFrame(LabelField(image)).faced()
        pose, pixels = placing.pose(frame.camera), MarkerPixels(finder.surface)
        (own,) = pixels.own(frame, pose)
        assert own == pytest.approx((image == TEAM).sum(), rel=0.03, abs=6)
    assert pixels.own(ImageFrame(LabelField(np.zeros_like(image))).faced(), pose)[0] < 0


def of_like_blades(odd):
    """(n, 2) three blades, one of which is shorter."""
    length = np.repeat([0.08 * odd, 0.08, 0.08], 4) * np.tile([0.25, 1, 1, 0.25], 3)
    way = np.repeat(2 * np.pi * np.arange(3) / 3, 4) + np.tile([-0.5, -0.15, 0.15, 0.5], 3)
    return np.column_stack([length * np.cos(way), length * np.sin(way)])


ODD = 0.92  # length of the short one


def image_of(outline, placing):
    image = np.zeros(SIZE[::-1], np.uint8)
    return cv2.fillPoly(image, [(16 * placing.at(outline)).round().astype(np.int32)], TEAM, shift=4)


def shares_of(image, placing, first):
    """Of three turns, by that which is compared with the others."""
    finder = WholeObjectFinder(Target("rotor", model_of(of_like_blades(ODD)), TEAM), DEFAULTS, facing=True)
    frame = ImageFrame(LabelField(image)).faced()
    pose = placing.pose(frame.camera)
    turns = finder.seen_alike.of([0]).of(pose)
    every = Poses.concatenate([pose, turns])
    order = [first, *(n for n in range(3) if n != first)]
    worth = np.zeros(3)
    worth[order[1:]] = odds_among(finder, frame, every[order])
    return np.exp(worth) / np.exp(worth).sum()


def test_turns_are_as_probable_whichever_is_compared_with_the_others():
    """Two by two each may be the likelier one."""
    placing = Placing(75.0, 60.0, 0.4, 500.0)
    image = image_of(of_like_blades(ODD), placing)
    way = 2 * np.pi * np.arange(3) / 3
    tips = placing.at(0.075 * np.column_stack([np.cos(way), np.sin(way)]))
    for (x, y), radius in zip(tips.round().astype(int).tolist(), (3, 4, 2), strict=True):  # dirt
        cv2.circle(image, (x, y), radius, 0, -1)
    each = [shares_of(image, placing, first) for first in range(3)]
    assert each[1] == pytest.approx(each[0], abs=0.1) and each[2] == pytest.approx(each[0], abs=0.1)
    clear = shares_of(image_of(of_like_blades(ODD), placing), placing, 1)
    assert clear[0] > 0.95 and max(each[0]) < clear[0]


ARROW = [(-0.07, -0.02), (0.03, -0.02), (0.03, -0.05), (0.09, 0), (0.03, 0.05), (0.03, 0.02), (-0.07, 0.02)]
OUTLINES = {"plate": rectangle(0.1, 0.1), "arrow": np.array(ARROW) - (0.0147, 0.0)}


def astray(image, placing, rng):
    """One pixel in twelve is of its class beside it, and of none on it."""
    return np.where(rng.random(image.shape) < 0.08, TEAM - image, image).astype(np.uint8)


def touched(image, placing, rng):
    """By a disc of its class."""
    way = rng.uniform(0, 2 * np.pi)
    at = round(placing.x + 45 * np.cos(way)), round(placing.y + 45 * np.sin(way))
    return cv2.circle(image, at, 20, TEAM, -1)


@pytest.mark.parametrize(
    ("spoilt", "name", "least"), [(astray, "plate", 20), (astray, "arrow", 23), (touched, "arrow", 18)]
)
def test_pixels_beside_it_make_it_no_larger(spoilt, name, least):
    """One that holds these, too, has more pixels, and fewer votes and no contours."""
    target = Target("lone", model_of(OUTLINES[name]), TEAM)
    recognizer = Recognizer([target], settings(), Segmenter(ImageConfig()), calibrated=False)
    right = 0
    for n in range(24):
        rng = np.random.default_rng(n)
        placing = Placing(75.0, 60.0, rng.uniform(-3, 3), 500.0)
        detections = recognizer.recognize(spoilt(image_of(OUTLINES[name], placing), placing, rng)).detections
        there = [d.image for d in detections if np.hypot(d.image.x - placing.x, d.image.y - placing.y) < 4]
        right += any(abs(image.scale / placing.scale - 1) < 0.05 for image in there)
    assert right >= least


def test_where_there_is_no_time_left_nothing_more_is_told_apart():
    """Those with many votes go on as they are."""
    image = image_of(OUTLINES["plate"], Placing(75.0, 60.0, 0.3, 500.0))
    target = Target("lone", model_of(OUTLINES["plate"]), TEAM)
    finder = WholeObjectFinder(target, DEFAULTS, facing=True)
    frame = replace(ImageFrame(LabelField(image)).faced(), deadline=Deadline(0.0))
    poses = Poses.concatenate([Placing(75.0, 60.0, 0.3, scale).pose(frame.camera) for scale in (500.0, 560.0)])
    few, best = np.array([0, 1]), np.array([0])
    assert sorted(FacingLone(finder).told_apart(frame, poses, few, best).tolist()) == [0, 1]
    assert FacingLone(finder).told_apart(ImageFrame(LabelField(image)).faced(), poses, few, best).tolist() == [0]
