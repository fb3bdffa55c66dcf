"""Flat objects that look almost the same turned otherwise: which way round they lie, and which one each is."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import DEFAULTS, settings
from squares import COLOURS, TEAM, Placing, patch, plate, rendered, robot

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.transforms import wrap_angle
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Identity, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_layouts import Layouts
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict import descriptions
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.claims import claims_of
from artrec_ros.core.verdict.descriptions import Describer
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
SAME = ObjectModel("same", tuple(replace(c, classes={}, label=COLOURS["g"]) for c in EVEN.components))


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
    return finder, frame, poses, finder.exchanges.of(poses)


@pytest.mark.parametrize(
    "model, turns_deg",
    [(robot(), []), (DOTS, [180]), (EVEN, [180]), (plate(), [-90, 90, 180]), (SAME, [])],
    ids=["robot", "dots", "even dots", "plate", "same dots"],
)
def test_turns_lay_markers_on_like_ones(model, turns_deg):
    found = np.degrees(finder_of(model).exchanges.angle_rad)
    assert sorted(np.rint((found + 179) % 360 - 179).tolist()) == pytest.approx(turns_deg, abs=8)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("turn", [0.0, 0.8, 2.5])
def test_who_lies_the_other_way_round_is_turned(name, turn):
    finder, frame, truth, turned = seen(Ant(70.0, 60.0, turn, 600.0, name))
    for begun in (truth, turned):
        told, _ = Layouts.around(finder, frame, begun).likelier()
        assert np.trace(told.R[0].T @ truth.R[0]) > 2.99
        assert np.linalg.norm(told.t - truth.t) < 0.01 * truth.t[0, 2]


@pytest.mark.parametrize("name", NAMES)
def test_the_name_is_the_same_whichever_way_round_it_is_laid(name):
    finder, frame, *both = seen(Ant(70.0, 60.0, 0.8, 600.0, name))
    fits = [Identifier(finder).identify(frame, poses, [{0, 1}])[0] for poses in both]
    assert [fit.name for fit in fits] == [name, name]


def test_what_another_owns_tells_nothing_of_a_name():
    ant = Ant(70.0, 60.0, 0.8, 600.0, "gr")
    finder, frame, truth, _ = seen(ant)
    front = cv2.boundingRect(np.rint(ant.at(SMALL)).astype(np.int32))
    x, y, width, height = front
    corners = np.array([(x - 1, y - 1), (x + width, y - 1), (x + width, y + height), (x - 1, y + height)], np.float32)
    rest = frame.without([corners])
    gg, gr, rg, rr = Layouts.around(finder, frame, truth, [rest]).read.evidence[0]
    assert gg == pytest.approx(gr) and rg == pytest.approx(rr) and gg > rg + 1
    gg, gr, *_ = Layouts.around(finder, frame, truth).read.evidence[0]
    assert gr > gg + 1


def test_who_is_no_object_turned_otherwise_is_told_as_it_was_found(monkeypatch):
    finder, frame, truth, turned = seen(Ant(70.0, 60.0, 0.8, 600.0, "gr"))
    (verdict,) = verdicts_of(claims_of(finder, turned, frame))
    doubted = replace(verdict.among, probability=verdict.among.probability * 0.01)[0]
    describer = Describer(finder)
    (told,) = describer.describe([verdict], frame, [verdict])
    monkeypatch.setattr(descriptions, "judged_at", lambda pose, of: doubted)
    (kept,) = describer.describe([verdict], frame, [verdict])
    assert abs(wrap_angle(told.image.theta - kept.image.theta)) > 3.0
    assert kept.there == pytest.approx(verdict.probability)
    assert max(kept.score, *(part.score for part in kept.components)) < 0.1  # for it is hardly turned as it is told
    assert told.score > 0.5


def test_what_is_the_right_way_round_is_laid_otherwise_once(monkeypatch):
    """Of an object with joints each of these takes a search of them, and a climb."""
    finder, frame, truth, _ = seen(Ant(70.0, 60.0, 0.8, 600.0, "gr"))
    (verdict,), asked, around = verdicts_of(claims_of(finder, truth, frame)), [], Layouts.around
    monkeypatch.setattr(Layouts, "around", lambda *of: asked.append(of) or around(*of))
    assert len(Describer(finder).describe([verdict], frame, [verdict])) == len(asked) == 1


def test_a_name_that_is_known_tells_the_turn():
    """Of dots as large as each other nothing else does: one that is called gr lies the other way round than an rg."""
    ant = Even(70.0, 60.0, 0.8, 600.0, "gr")
    finder, frame = finder_of(EVEN), ImageFrame(LabelField(rendered(ant))).faced()
    truth = ant.pose(frame.camera)
    for name, cosine in (("gr", 1.0), ("rg", -1.0)):
        told, _ = Layouts.around(finder, frame, truth).likelier([NAMES.index(name)])
        assert (told.R[0].T @ truth.R[0])[0, 0] == pytest.approx(cosine, abs=0.01)


@pytest.mark.parametrize("hidden", [0, 1])
@pytest.mark.parametrize("turn", [0.3, 1.7, 4.0])
def test_what_is_told_lies_on_what_is_seen_whichever_way_round(turn, hidden):
    """Of two dots one is hidden: that one is not told where nothing is."""
    ant = Ant(70.0, 60.0, turn, 600.0, "gr")
    labels = rendered(ant)
    labels[labels == COLOURS["gr"[hidden]]] = 0
    target = Target("ant", DOTS, TEAM)
    config = settings(time_budget_ms=60000.0, required="visible", min_scale=500.0, max_scale=700.0)
    for d in Recognizer((target,), config, Segmenter(ImageConfig())).recognize(labels).detections:
        for part in d.components:
            assert labels[round(part.y), round(part.x)], part


def test_the_end_of_the_time_leaves_what_was_found():
    finder, frame, _, turned = seen(Ant(70.0, 60.0, 0.8, 600.0, "gr"))
    late = replace(frame, deadline=Deadline(0.0))
    told, changed = Layouts.around(finder, late, turned).likelier()
    assert not len(changed) and np.array_equal(told.R, turned.R)


@pytest.mark.parametrize("n", [3, 8, 12])
def test_each_turn_of_a_ring_is_tried_once(n):
    angles = 2 * np.pi * np.arange(n) / n
    classes = {c: COLOURS[c] for c in "gr"}
    parts = tuple(
        Component(
            f"dot{i}",
            (patch(f"dot{i}", 0.012 * ROUND + 0.06 * np.array([np.cos(a), np.sin(a)])),),
            not i,
            classes=classes,
        )
        for i, a in enumerate(angles)
    )
    found = finder_of(ObjectModel("ring", parts)).exchanges.angle_rad
    np.testing.assert_allclose(np.sort(found % (2 * np.pi)), angles[1:], atol=1e-6)
