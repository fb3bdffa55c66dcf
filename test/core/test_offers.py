"""What an object that is not told leaves is offered to others again."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import settings
from squares import TEAM, patch

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.identity import NONE_LEFT
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
    """A minus sign and an equals sign, of one class, at 1000 pixels a metre."""
    labels, bar = np.zeros(SIZE[::-1], np.uint8), BAR * SCALE
    for x, y, turn in ((90, 100, 0.3), (300, 97 - SCALE * OFF, 0.0), (300, 97 + SCALE * OFF, 0.0)):
        c, s = np.cos(turn), np.sin(turn)
        cv2.fillPoly(labels, [np.rint(bar @ [[c, s], [-s, c]] + (x, y)).astype(np.int32)], TEAM)
    return labels


@pytest.mark.parametrize("camera", [None, Camera.facing(SIZE)])
def test_what_one_of_too_many_has_taken_is_anothers(camera):
    """A second equals sign lies on the minus sign, and goes: there is but one."""
    targets = tuple(Target(m.name, replace(m, name=m.name), TEAM) for m in (MINUS, EQUALS))
    config = settings(time_budget_ms=60000, min_scale=800.0, max_scale=1250.0)
    result = Recognizer(targets, config, Segmenter(ImageConfig())).recognize(signs(), camera)
    told = {d.object: d.image.x for d in result.detections}
    assert sorted(told) == ["equals", "minus"] and len(result.detections) == 2
    assert abs(told["minus"] - 90) < 3 and abs(told["equals"] - 300) < 3
    assert any(r.object == "equals" and r.reason == NONE_LEFT for r in result.rejected)


class Place:
    """Poses that are numbers: those in a place are those that are the same."""

    def is_in_place_of(self, poses, one, turn):
        return poses == one[0]


class Finder:
    required = Place()
    config = settings()


class Claim:
    def __init__(self, finder, at):
        self.claim, self.finder, self.poses = self, finder, np.array([at])


def test_of_what_falls_other_candidates_stay_and_of_what_is_enough_those_that_are_told():
    once, other = Finder(), Finder()
    kept, surplus, fallen = Claim(once, 1), Claim(once, 2), Claim(other, 7)
    told = Told([], [], [[kept], [fallen]], ([], []), [surplus], [fallen])
    left = told.left([(once, np.array([1, 2, 3])), (other, np.array([5, 7, 8]))])
    assert [(finder, poses.tolist()) for finder, poses in left] == [(once, [1]), (other, [5, 8])]
