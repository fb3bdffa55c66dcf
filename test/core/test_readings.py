"""Of two readings of the same blobs the one that leaves fewer to clutter is told."""

from __future__ import annotations

from dataclasses import replace

import cv2
import legs
import numpy as np
import pytest
from legs import PX_PER_M, RADIUS, SIZE, along, disc
from settings import settings

from artrec_ros.core.base import deadline
from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.facing_stage import FacingStage
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.readings import Readings

THIGH, SHANK, LABEL = 1.2, 1.05, 1
NAMES = "hip", "knee", "ankle"


def leg():
    """Three like discs: thigh and knee are one, the ankle swings about the knee."""
    knee = Joint("knee", along(THIGH), np.array([0.0, 0.0, 1.0]), -1.2, 0.0, name="bend")
    parts = (
        Component("hip", (disc(0.0),), required=True),
        Component("knee", (disc(THIGH),)),
        Component("ankle", (disc(SHANK),), joint=knee),
    )
    return Target("leg", ObjectModel("leg", parts, unique=True), LABEL)


def places(shank=1.0, turn=1.2, bend=-0.7, hip=(220.0, 40.0)):
    """(3, 2) pixels of hip, knee and ankle. :param shank: how long that is, as a share of what the file says."""
    turns = np.array([turn, turn - bend])
    steps = np.array([THIGH, shank * SHANK])[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
    return np.array(hip) + PX_PER_M * np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def picture(*discs):
    labels = np.zeros(SIZE[::-1], np.uint8)
    for at in discs:
        centre = np.rint(16 * np.asarray(at)).astype(int).tolist()
        cv2.circle(labels, centre, int(16 * RADIUS * PX_PER_M), LABEL, cv2.FILLED, shift=4)
    return labels


def recognizer(target, **changes):
    config = settings(time_budget_ms=60000.0, min_scale=85.0, max_scale=115.0, **changes)
    return Recognizer((target,), config, Segmenter(ImageConfig()))


def told(*discs, **changes):
    (found,) = recognizer(leg(), **changes).recognize(picture(*discs), None).detections
    return found


def lies_right(found, at):
    """Whether each component that is told lies on its own disc, if not in its middle."""
    own = dict(zip(NAMES, at, strict=True))
    return all(np.hypot(*(own[c.component] - (c.x, c.y))) < 1.5 * RADIUS * PX_PER_M for c in found.components)


@pytest.mark.parametrize("shank", [0.88, 0.9, 0.92, 1.08, 1.1])
@pytest.mark.parametrize("turn", [1.0, 1.2, 1.4])
def test_what_leaves_no_disc_is_told_though_lengths_are_off(shank, turn):
    at = places(shank, turn)
    assert lies_right(told(*at), at)


def test_what_is_left_beside_the_place_of_a_part_is_told():
    at = places(shank=0.85)
    found = told(*at)
    assert lies_right(found, at)
    elsewhere = {m.component: (m.x, m.y) for m in found.missing if m.state == "elsewhere"}
    assert len(found.components) + len(elsewhere) == 3
    assert found.as_told < 0.7 or not elsewhere


def test_as_many_are_wanted_as_are_told():
    """What labels do not confirm in a first search may be found in a second one."""
    at = places(shank=0.94)
    assert len(told(*at, min_components=3).components) == len(told(*at).components) == 3


@pytest.mark.parametrize("late", [False, True])
def test_readings_are_compared_object_by_object_until_the_time_is_over(monkeypatch, late):
    target, compared, original = leg(), list[int](), Readings._worse
    engine = recognizer(Target("leg", replace(target.model, unique=False), target.label))

    def noted(self, *args):
        compared.append(1)
        if late:
            monkeypatch.setattr(deadline.time, "perf_counter", lambda: np.inf)
        return original(self, *args)

    monkeypatch.setattr(Readings, "_worse", noted)
    image = picture(*places(0.9, hip=(80.0, 40.0)), *places(0.9, hip=(300.0, 40.0)))
    assert len(engine.recognize(image, None).detections) == 2
    assert (len(compared) == 1) == late


def test_what_has_too_few_components_takes_no_place_of_what_occurs_once():
    """Though those that it has speak for it more than all four of a ragged one."""
    target = legs.leg()
    ragged = legs.picture(legs.places(hip=(120.0, 60.0)))
    ragged[np.random.default_rng(1).random(ragged.shape) < 0.44] = 0
    cut = legs.picture(legs.places(hip=(360.0, 139.0)))  # its toe is out of the picture
    engine = recognizer(Target("leg", replace(target.model, unique=True), target.label), min_components=4)
    (found,) = engine.recognize(np.where(cut > 0, cut, ragged), None).detections
    assert len(found.components) == 4 and found.image.x < 200


def test_what_has_too_few_components_is_not_offered_again(monkeypatch):
    """That is known before all is described: of each thing that falls there all is shared out and described anew."""
    again, original = list[int](), FacingStage._again
    monkeypatch.setattr(FacingStage, "_again", lambda *args: again.append(1) or original(*args))
    cut = places(hip=(360.0, 121.0))[:2]  # another leg's; its ankle is out of the picture
    target = leg()
    engine = recognizer(Target("leg", replace(target.model, unique=False), target.label), min_components=3)
    (found,) = engine.recognize(picture(*places(hip=(120.0, 40.0)), *cut), None).detections
    assert len(found.components) == 3 and not again
