"""Candidates of one target that exclude each other: which one is told, and how sure that is."""

from dataclasses import replace

import numpy as np
import pytest
from settings import settings
from solids import camera_of
from squares import SIZE, TEAM, Placing, patch, rendered

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.identity import NOT_FIRST

OTHER = 5
DISC = 0.02 * np.column_stack([np.cos(np.pi * np.arange(24) / 12), np.sin(np.pi * np.arange(24) / 12)])
APART = 0.06
PAIR = ObjectModel(
    "pair",
    (
        Component("body", (patch("body", DISC),), required=True),
        Component("nose", (patch("nose", DISC + (APART, 0.0)),), label=OTHER),
    ),
)
ONCE = replace(PAIR, unique=True)
CAMERAS = pytest.mark.parametrize("camera", [None, camera_of(SIZE)], ids=["facing", "space"])
WAYS = pytest.mark.parametrize("turn", [0.3, 2.1, -1.2])
MIDDLE = 80.0, 60.0, 600.0


def around(turn, size=1.0, apart=APART):
    """A second nose, or what looks like it, in another direction."""
    return size * DISC + apart * np.array((np.cos(turn), np.sin(turn)))


class Pair(Placing):
    def patches(self):
        return [(self.at(DISC), TEAM), (self.at(DISC + (APART, 0.0)), OTHER)]


class Noses(Placing):
    """One body. `name`: outlines of all noses."""

    def patches(self):
        return [(self.at(DISC), TEAM), *((self.at(nose), OTHER) for nose in self.name)]


def noses(turn, outlines):
    x, y, scale = MIDDLE
    return Noses(x, y, turn, scale, outlines)


def recognizer(model):
    return Recognizer([Target("pair", model, TEAM)], settings(), Segmenter(ImageConfig()), calibrated=False)


def told(image, model=PAIR, camera=None):
    target = Target("pair", model, TEAM)
    found = Recognizer([target], settings(), Segmenter(ImageConfig()), calibrated=camera is not None)
    return found.recognize(image, camera)


def direction(detection):
    return -detection.image.theta


# in space one that explains all of a blob is found at once, and no other one looked for: of some turns both are
@pytest.mark.parametrize(
    ("camera", "turn"), [(None, 0.3), (None, 2.1), (None, -1.2), (camera_of(SIZE), 2.1), (camera_of(SIZE), -1.2)]
)
@pytest.mark.parametrize("model", [PAIR, ONCE], ids=["many", "once"])
def test_of_two_like_parts_either_may_be_the_objects(camera, turn, model):
    at = noses(turn, [around(0.0), around(1.7)])
    (one,) = told(rendered(at), model, camera).detections
    assert 0.35 < one.score < 0.72 and one.there > 0.9
    assert 0.25 < one.other_place.probability < 0.65
    body, nose = (one.instance_of(name) for name in ("body", "nose"))
    assert body.score > 0.9 and nose.score == pytest.approx(one.score, abs=0.1)
    assert one.other_place.image.x == pytest.approx(body.x, abs=2)
    off = abs(np.angle(np.exp(1j * (one.other_place.image.theta - one.image.theta))))
    assert off == pytest.approx(1.7, abs=0.1)


@WAYS
@pytest.mark.parametrize("second", [around(1.7, 0.5), around(1.7, 1.0, 1.6 * APART)], ids=["small", "far"])
def test_what_is_not_like_it_takes_nothing(turn, second):
    (one,) = told(rendered(noses(turn, [around(0.0), second]))).detections
    assert one.score > 0.9 and one.other_place is None
    assert direction(one) == pytest.approx(direction_of(turn), abs=0.1)


def direction_of(turn):
    (alone,) = told(rendered(noses(turn, [around(0.0)]))).detections
    return direction(alone)


@CAMERAS
def test_two_objects_side_by_side_take_nothing_from_each_other(camera):
    image = rendered(Pair(25.0, 60.0, 0.3, 600.0), Pair(120.0, 70.0, 1.9, 600.0))
    both = told(image, camera=camera).detections
    assert len(both) == 2 and all(d.score > 0.9 and d.other_place is None for d in both)


def test_where_one_was_taken_across_two_both_are_told():
    """The one's body and the other's nose are as far apart: who was taken for an object excludes each, but they do not
    exclude each other, and explain more together."""
    image = rendered(Pair(40.0, 60.0, 0.3, 600.0), Pair(110.0, 60.0, 1.9, 600.0))
    both = told(image).detections
    assert sorted(round(d.image.x, -1) for d in both) == [40, 110]
    assert all(len(d.components) == 2 and d.score > 0.9 for d in both)


def test_what_it_lacks_for_another_has_it_is_no_second_object():
    """Two noses that have directions of their own, of one body: one object, not two of which one lies on the other."""
    nose = np.array([(-0.02, -0.012), (0.02, 0.0), (-0.02, 0.012)])
    body = Component("body", (patch("body", DISC),), required=True)
    model = ObjectModel("pair", (body, Component("nose", (patch("nose", nose + (APART, 0.0)),), label=OTHER)))
    way = np.array([(np.cos(1.7), np.sin(1.7)), (-np.sin(1.7), np.cos(1.7))])
    image = rendered(noses(0.3, [nose + (APART, 0.0), (nose + (APART, 0.0)) @ way]))
    (one,) = told(image, model).detections
    assert one.score < 0.75 and one.other_place.probability > 0.25


def test_of_what_occurs_once_two_that_are_alike_are_told_at_a_half_each():
    image = rendered(Pair(40.0, 40.0, 0.3, 600.0), Pair(110.0, 85.0, 1.9, 600.0))
    result = told(image, ONCE)
    (one,), (gone,) = result.detections, [r for r in result.rejected if r.reason == NOT_FIRST]
    assert 0.4 < one.score < 0.72 and one.there > 0.9
    assert gone.score == pytest.approx(one.other_place.probability) and one.score + gone.score == pytest.approx(
        1.0, abs=0.05
    )
    assert np.hypot(one.other_place.image.x - one.image.x, one.other_place.image.y - one.image.y) > 50


def test_in_a_film_the_other_one_is_looked_for_in_each_image():
    """Else the one that was told is followed, and as sure as if it were the only one."""
    recognizing, memory, scores = recognizer(PAIR), None, []
    for k in range(6):
        x, y, scale = MIDDLE
        image = rendered(Noses(x + 0.7 * k, y, 0.3, scale, [around(0.0), around(1.7)]))
        result, memory = recognizing.follow(image, None, k * 33_000_000, memory)
        scores += [d.score for d in result.detections]
    assert len(scores) == 6 and max(scores) < 0.7


def test_another_one_of_its_target_and_another_targets_are_counted_together():
    like = Target("pear", replace(PAIR, name="pear"), TEAM)
    both = Recognizer([Target("pair", PAIR, TEAM), like], settings(), Segmenter(ImageConfig()), calibrated=False)
    result, memory = both.follow(rendered(noses(0.3, [around(0.0), around(1.7)])), None, 0, None)
    (one,) = result.detections
    assert one.other_object.probability > 0.2 < one.other_place.probability
    assert one.score + one.other_object.probability + one.other_place.probability == pytest.approx(1.0, abs=0.05)
    ((known,),) = (mine for mine in memory.known.values() if mine)
    assert known.unsure and len(known.instead) == 1


def test_of_what_occurs_once_and_may_be_another_targets_each_is_counted_once():
    """Though pixels are shared out twice: first with the one that is told elsewhere, and without."""
    like = Target("pear", replace(PAIR, name="pear"), TEAM)
    both = Recognizer([Target("pair", ONCE, TEAM), like], settings(), Segmenter(ImageConfig()), calibrated=False)
    result = both.recognize(rendered(Pair(40.0, 40.0, 0.3, 600.0), Pair(110.0, 85.0, 1.9, 600.0)))
    one = next(d for d in result.detections if d.object == "pair")
    assert one.score + one.other_object.probability + one.other_place.probability == pytest.approx(1.0, abs=0.05)
