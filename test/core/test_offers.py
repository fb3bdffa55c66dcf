"""What an object that is not told leaves is offered to others again."""

from __future__ import annotations

from itertools import product

import cv2
import numpy as np
from settings import settings
from squares import TEAM, patch

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.identity import NOT_FIRST
from artrec_ros.core.verdict.offers import Told

SCALE, OFF = 1000.0, 0.0058  # pixels per metre; of a bar of an equals sign from its middle
BAR = np.array([(-0.01, -0.0024), (0.01, -0.0024), (0.01, 0.0024), (-0.01, 0.0024)])
MINUS = ObjectModel("minus", (Component("bar", (patch("bar", BAR),), required=True),), unique=True)
EQUALS = ObjectModel(
    "equals",
    (
        Component("upper", (patch("upper", BAR + (0, OFF)),), required=True),
        Component("lower", (patch("lower", BAR - (0, OFF)),)),
    ),
    unique=True,
)
SIZE = (400, 200)


def signs():
    """Two equals signs of one class at 1000 pixels a metre."""
    labels = np.zeros(SIZE[::-1], np.uint8)
    for x, y in product((90, 300), (97 - SCALE * OFF, 97 + SCALE * OFF)):
        cv2.fillPoly(labels, [np.rint(BAR * SCALE + (x, y)).astype(np.int32)], TEAM)
    return labels


def test_what_one_of_too_many_has_taken_is_anothers():
    """Of two equals signs one goes, as it occurs once: there may be a minus sign."""
    targets = tuple(Target(m.name, m, TEAM) for m in (MINUS, EQUALS))
    config = settings(time_budget_ms=60000, min_scale=800.0, max_scale=1250.0)
    result = Recognizer(targets, config, Segmenter(ImageConfig())).recognize(signs())
    told = {d.object: round(d.image.x, -1) for d in result.detections}
    assert sorted(told) == ["equals", "minus"] and len(result.detections) == 2
    assert sorted(told.values()) == [90, 300]
    assert any(r.object == "equals" and r.reason == NOT_FIRST for r in result.rejected)


def at(*places):
    """Poses, each at a place of its own along x."""
    n = len(places)
    t = np.column_stack([places, np.zeros((n, 2))]).astype(float)
    return Poses(np.tile(np.eye(3), (n, 1, 1)), t, np.zeros((n, 0)))


class Place:
    """An object is in the place of another one where both are at the same."""

    def is_in_place_of(self, poses, others, turn):
        return poses.t[:, None, 0] == others.t[None, :, 0]


class Finder:
    required = Place()
    config = settings()


class Claim:
    def __init__(self, finder, place):
        self.claim, self.finder, self.poses = self, finder, at(place)


def test_of_what_falls_other_candidates_stay_and_of_what_is_enough_those_that_are_told():
    once, other = Finder(), Finder()
    kept, surplus, fallen, stands = Claim(once, 1), Claim(once, 2), Claim(other, 7), Claim(other, 8)
    told = Told([], [], [], [[kept], [fallen, stands]], ([], []), [surplus], [fallen])
    left = told.left([(once, at(1, 2, 3)), (other, at(5, 7, 8))])
    assert [(finder, poses.t[:, 0].tolist()) for finder, poses in left] == [(once, [1]), (other, [5, 8])]


def test_what_one_round_tells_the_next_may_not_give_up():
    one = Finder()
    first = Told([], [], [], [[Claim(one, 1), gone := Claim(one, 2)]], ([], []), [], [gone])
    for places, keeps in (((1, 3), True), ((3, 4), False)):
        assert Told([], [], [], [[Claim(one, place) for place in places]], ([], []), [], []).keeps(first) == keeps
