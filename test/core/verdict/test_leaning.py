"""How sure objects are beside others that own pixels and may not be there."""

from types import SimpleNamespace

import numpy as np
import pytest
from settings import settings
from squares import COLOURS, TEAM, patch

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.identity import NOT_FIRST
from artrec_ros.core.verdict.leaning import Leaning

SCALE, LEAST = 1000.0, 0.4  # pixels per metre; least probability of what is told
BOX = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
DOOR, STEP = (40, 30), (40, 12)  # width and height, pixels


def sheet(name, size, **once):
    return ObjectModel(name, (Component("all", (patch("all", BOX * size / SCALE),), required=True),), **once)


def told_of(labels, classes=(TEAM, TEAM), **once):
    models = sheet("door", DOOR, **once), sheet("step", STEP, **once)
    targets = tuple(Target(m.name, m, label) for m, label in zip(models, classes, strict=True))
    known = {"min_scale": 990.0, "max_scale": 1010.0, "size_votes": 2.0}  # how large a block looks is no matter
    config = settings(time_budget_ms=60000, min_probability=LEAST, **known)
    result = Recognizer(targets, config, Segmenter(ImageConfig())).recognize(labels)
    return {d.object: d for d in result.detections}, result.rejected


def block(height, at=60, labels=None):
    """A block as wide as a door."""
    labels = np.zeros((160, 240), np.uint8) if labels is None else labels
    labels[40 : 40 + height, at : at + DOOR[0]] = TEAM
    return labels


def test_a_strip_that_a_doubtful_object_leaves_is_no_surer_than_that_one_allows():
    """Neither is there for itself: a block is too high for a door, and not a step for most of it."""
    told, _ = told_of(block(DOOR[1] + STEP[1]))
    door, step = told["door"], told["step"]
    assert 0.5 < door.score < 0.9
    assert step.score < door.score + (1 - door.score) * LEAST
    assert step.score == pytest.approx(step.components[0].score, abs=0.05) and step.beyond_others < 0.9


def test_what_one_of_too_many_made_possible_goes_with_it():
    labels = block(DOOR[1] + STEP[1])
    told, rejected = told_of(block(DOOR[1], 160, labels), unique=True)
    assert told.keys() == {"door"} and told["door"].image.x > 160 and told["door"].score > 0.95
    assert any(r.object == "door" and r.reason == NOT_FIRST for r in rejected)
    steps = [r for r in rejected if r.object == "step"]
    assert any(step.score < LEAST and "without what lies beside it" in step.reason for step in steps)


def test_who_is_half_hidden_by_a_sure_one_is_as_sure_as_before():
    other = COLOURS["g"]
    labels = block(DOOR[1])
    labels[40 : 40 + STEP[1], 80 : 80 + STEP[0]] = other
    told, _ = told_of(labels, (TEAM, other))
    assert told["step"].score > 0.8 and told["door"].beyond_others > told["step"].score
    assert told["door"].score > 0.5


class Judged:
    """An object that is probable with all that others own, and as `beside` says where these alone are there."""

    def __init__(self, probability, *owners, beside=None):
        self.probability, self.owners, self.wider_px, self.beside = probability, owners, 0.0, beside or {}
        self.alone = self.beside.get(of(), probability)
        self.finder, self.poses, self.claim = self, self, self
        self.solids = SimpleNamespace(corners=[self])
        self.frame = self.unowned = self

    def unhurried(self):
        return self

    def without(self, solids):
        return frozenset(solids)


class Judge:
    def verdicts(self, finder, poses, frame):
        return SimpleNamespace(probability=np.array([finder.beside[frame]]))


def share(one, **there):
    return Leaning(Judge(), there.get("there", {})).share(one)


def of(*owners):
    return frozenset(owners)


def test_who_leans_on_nobody_is_as_sure_as_it_was_judged():
    assert share(Judged(0.3)) == 1


def test_an_object_is_as_probable_as_with_an_owner_and_without_it():
    owner = Judged(0.4)
    one = Judged(0.9, owner, beside={of(): 0.1})
    assert share(one) * 0.9 == pytest.approx(0.4 * 0.9 + 0.6 * 0.1)
    assert share(one, there={owner: 0.0}) * 0.9 == pytest.approx(0.1)
    assert share(Judged(0.9, owner, beside={of(): 0.9})) == pytest.approx(1)


def test_what_an_owner_takes_away_makes_nothing_surer():
    assert share(Judged(0.5, Judged(0.4), beside={of(): 0.99})) == pytest.approx(1)


def test_the_surest_owners_are_there_as_long_as_any_is():
    """A doubtful one whose pixels say nothing costs nothing of what a sure one hides."""
    sure, doubtful = Judged(0.99), Judged(0.5)
    one = Judged(0.9, sure, doubtful, beside={of(sure): 0.9, of(): 0.0})
    assert share(one) == pytest.approx(0.99)
    one = Judged(0.9, sure, doubtful, beside={of(sure): 0.3, of(): 0.1})
    assert share(one) * 0.9 == pytest.approx(0.5 * 0.9 + 0.49 * 0.3 + 0.01 * 0.1)


def test_who_leans_on_a_leaning_one_is_no_surer_than_both_allow():
    first = Judged(0.5)
    second = Judged(0.8, first, beside={of(): 0.0})
    third = Judged(0.9, second, beside={of(): 0.0})
    assert share(third) * 0.9 == pytest.approx(0.5 * 0.8 * 0.9)


def test_a_row_of_any_length_is_told():
    one = Judged(0.9)
    for _ in range(2000):
        one = Judged(0.9, one, beside={of(): 0.8})
    assert 0.8 < share(one) * 0.9 < 0.9


def test_of_many_owners_one_look_tells_those_that_are_surer():
    sure, weak = [Judged(0.99), Judged(0.98)], [Judged(0.5), Judged(0.45)]
    one = Judged(0.9, *sure, *weak, beside={of(*sure): 0.6, of(): 0.0})
    assert share(one) * 0.9 == pytest.approx(0.45 * 0.9 + 0.53 * 0.6)
