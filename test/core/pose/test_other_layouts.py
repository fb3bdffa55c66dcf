"""Flat objects that look almost the same turned otherwise: which way round they lie, and which one each is."""

from __future__ import annotations

import numpy as np
import pytest
from settings import DEFAULTS
from squares import COLOURS, TEAM, Placing, patch, plate, rendered, robot

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, Identity, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_layouts import likelier_layouts
from artrec_ros.core.verdict.identity import Identifier

ROUND = np.column_stack([np.cos(np.pi * np.arange(32) / 16), np.sin(np.pi * np.arange(32) / 16)])
LARGE, SMALL = 0.017 * ROUND, 0.013 * ROUND + (0.06, 0.0)
NAMES = [a + b for a in "gr" for b in "gr"]


def dots(rear, front):
    """Two on a line, each of one of two classes."""
    classes = {c: COLOURS[c] for c in "gr"}
    parts = (
        Component("rear", (patch("rear", rear),), required=True, classes=classes),
        Component("front", (patch("front", front),), classes=classes),
    )
    return ObjectModel("ant", parts, tuple(Identity(n, {"rear": n[0], "front": n[1]}) for n in NAMES))


DOTS, EVEN = dots(LARGE, SMALL), dots(LARGE, LARGE + (0.06, 0.0))


class Ant(Placing):
    dots = LARGE, SMALL

    def patches(self):
        return [(self.at(dot), COLOURS[label]) for dot, label in zip(self.dots, self.name, strict=True)]


class Even(Ant):
    dots = LARGE, LARGE + (0.06, 0.0)


def finder_of(model):
    return WholeObjectFinder(Target(model.name, model, TEAM), DEFAULTS, facing=True)


def seen(ant):
    """A finder, the frame, the true pose, and what looks most like it: turned by half, dot on dot."""
    finder, frame = finder_of(DOTS), ImageFrame(LabelField(rendered(ant))).faced()
    poses = ant.pose(frame.camera)
    (turned, _) = finder.exchanges.of(poses)
    return finder, frame, poses, turned


@pytest.mark.parametrize(
    "model, turns_deg", [(robot(), []), (DOTS, [180]), (plate(), [-90, 90, 180])], ids=["robot", "dots", "plate"]
)
def test_turns_lay_markers_on_like_ones(model, turns_deg):
    found = np.degrees(finder_of(model).exchanges.angle_rad)
    assert sorted(np.rint((found + 179) % 360 - 179).tolist()) == pytest.approx(turns_deg, abs=8)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("turn", [0.0, 0.8, 2.5])
def test_who_lies_the_other_way_round_is_turned(name, turn):
    finder, frame, truth, turned = seen(Ant(70.0, 60.0, turn, 600.0, name))
    used = np.ones((1, 2), bool)
    for begun in (truth, turned):
        told, _ = likelier_layouts(finder, frame, begun, used)
        assert np.trace(told.R[0].T @ truth.R[0]) > 2.99
        assert np.linalg.norm(told.t - truth.t) < 0.01 * truth.t[0, 2]


@pytest.mark.parametrize("name", NAMES)
def test_the_name_is_the_same_whichever_way_round_it_is_laid(name):
    finder, frame, *both = seen(Ant(70.0, 60.0, 0.8, 600.0, name))
    fits = [Identifier(finder).identify(frame, poses, [{0, 1}])[0] for poses in both]
    assert [fit.name for fit in fits] == [name, name]


def test_a_name_that_is_known_tells_the_turn():
    """Of dots as large as each other nothing else does: one that is called gr lies the other way round than an rg."""
    ant = Even(70.0, 60.0, 0.8, 600.0, "gr")
    finder, frame = finder_of(EVEN), ImageFrame(LabelField(rendered(ant))).faced()
    truth, used = ant.pose(frame.camera), np.ones((1, 2), bool)
    for name, cosine in (("gr", 1.0), ("rg", -1.0)):
        told, _ = likelier_layouts(finder, frame, truth, used, [NAMES.index(name)])
        assert (told.R[0].T @ truth.R[0])[0, 0] == pytest.approx(cosine, abs=0.01)
