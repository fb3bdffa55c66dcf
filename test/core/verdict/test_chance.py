"""Objects amid patches that look like their components: chance makes some of these lie as an object's do."""

from dataclasses import dataclass

import numpy as np
import pytest
from settings import settings
from squares import TEAM, Placing, hinge, patch, rendered

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.chance import Chances, beyond_chance

SIZE, SCALE = (480, 360), 100.0
SQUARE = np.array([(-0.06, -0.06), (0.06, -0.06), (0.06, 0.06), (-0.06, 0.06)])
AT = {"body": (0.0, 0.0), "left": (0.26, 0.07), "right": (-0.10, 0.23)}
CLASSES = {"body": TEAM, "left": 4, "right": 5}
NONE = 0.0  # share of what chance makes


def card(names=AT, joint=None):
    """Like squares, each of its own class. :param joint: of the last one."""
    parts = [
        Component(
            name,
            (patch(name, SQUARE, Pose(np.eye(3), np.array([*AT[name], 0.0]))),),
            required=name == "body",
            label=None if name == "body" else CLASSES[name],
            joint=joint if name == [*names][-1] else None,
        )
        for name in names
    ]
    return ObjectModel("card", tuple(parts))


@dataclass(frozen=True)
class Card(Placing):
    lacks: str = ""

    def patches(self):
        return [(self.at(SQUARE + at), CLASSES[n]) for n, at in AT.items() if n != self.lacks]


class Lone(Placing):
    """A patch that is nobody's."""

    def patches(self):
        return [(self.at(SQUARE), CLASSES[self.name])]


def amid(cards, count, rng):
    """Cards, and so many patches of their sizes and classes that none touches another."""
    out, taken = list(cards), [p.at([at])[0] for p in cards for at in AT.values()]
    while len(out) < count + len(cards):
        at = rng.uniform((12, 12), np.subtract(SIZE, 12))
        if min((np.hypot(*(at - other)) for other in taken), default=99) > 20:
            name = ("body", "left", "right")[rng.integers(3)]
            out.append(Lone(*at, rng.uniform(-np.pi, np.pi), SCALE * rng.uniform(0.9, 1.1), name))
            taken.append(at)
    return out


def found(placed, model=None, **values):
    config = settings(time_budget_ms=60000, **values)
    engine = Recognizer((Target("card", model or card(), TEAM),), config, Segmenter(ImageConfig()))
    return engine.recognize(rendered(*placed, size=SIZE, fine=4))


def at(detection, placed):
    return np.hypot(detection.image.x - placed.x, detection.image.y - placed.y) < 3


@pytest.mark.parametrize("seed", range(3))
def test_amid_like_patches_an_object_is_told_and_few_that_chance_makes_of_them(seed):
    rng = np.random.default_rng(seed)
    there = Card(*rng.uniform((60, 60), np.subtract(SIZE, 60)), rng.uniform(-np.pi, np.pi), SCALE)
    picture = amid([there], 130, rng)
    result, without = found(picture), found(picture, chance_share=NONE)
    best, *others = result.detections
    assert at(best, there) and best.score > 0.9 and len(best.components) == 3
    assert all(part.score > 0.8 for part in best.components)
    wrong = [d for d in without.detections if d.score > 0.5 and not at(d, there)]
    assert len(wrong) > 4 and sum(d.score > 0.5 for d in others) <= len(wrong) / 2
    assert any("chance" in r.reason for r in result.rejected)


def test_objects_side_by_side_do_not_make_each_other_doubtful():
    """Though there are many patches like those of each."""
    rows = [Card(50 + 60 * x, 50 + 60 * y, 0.7 * x + y, SCALE) for x in range(6) for y in range(5)]
    told, without = found(rows).detections, found(rows, chance_share=NONE).detections
    assert len(told) == len(rows)
    assert np.allclose([d.score for d in told], [d.score for d in without], atol=0.01)


def test_one_that_lacks_a_component_is_told_where_few_are_like_its_others():
    rng = np.random.default_rng(0)
    there = Card(200, 180, 0.4, SCALE, lacks="right")
    clean, few, many = (found(amid([there], count, rng)).detections for count in (0, 20, 130))
    (clean,), (few,) = clean, [d for d in few if at(d, there)]
    assert clean.score > 0.9 and 0.6 < few.score < clean.score
    assert all(d.score < few.score for d in many)


def chances(model):
    return Chances(WholeObjectFinder(Target("card", model, TEAM), settings(), facing=True))


def test_what_turns_farther_out_has_more_ways():
    """A marker's size, .12 m, on either side: the circumference, in steps of two of these."""
    turned = chances(card())
    near, far = np.hypot(*AT["right"]), np.hypot(*AT["left"])
    assert turned.ways((0,)) == 1
    assert turned.ways((0, 2)) == pytest.approx(1 + 2 * np.pi * near / 0.24)
    assert turned.ways((0, 1, 2)) == pytest.approx(1 + 2 * np.pi * far / 0.24)


def test_what_a_joint_moves_has_as_many_more_as_its_way_is_long():
    swung = chances(card(joint=hinge("body", (0.0, 0.0, 0.0), (0, 0, 1), limits=(-0.5, 1.0))))
    arm = np.hypot(*AT["right"])
    assert swung.ways((0, 1, 2)) == pytest.approx(chances(card()).ways((0, 1)) * (1 + 1.5 * arm / 0.24))
    slid = chances(card(joint=hinge("body", (0.0, 0.0, 0.0), (1, 0, 0), "prismatic", (0.0, 0.48))))
    assert slid.ways((0, 1, 2)) == pytest.approx(3 * chances(card()).ways((0, 1)))


def test_an_object_of_one_component_is_told_by_its_looks():
    """There is nothing that chance could put together."""
    placed = [Lone(40 + 70 * n, 60 + 70 * m, 0.3 * n, SCALE, "body") for n in range(6) for m in range(4)]
    told, without = (found(placed, card(["body"]), **values).detections for values in ({}, {"chance_share": NONE}))
    assert len(told) == len(placed)
    assert [d.score for d in told] == [d.score for d in without]


def test_odds_are_divided():
    score = 0.9 * beyond_chance(0.9, 3.0)
    assert score / (1 - score) == pytest.approx(9 / 3)


@pytest.mark.parametrize("score", np.random.default_rng(4).uniform(0, 1, 50))
def test_where_chance_makes_nothing_nothing_is_less_sure(score):
    assert beyond_chance(float(score), 1.0) == 1.0


def test_components_are_as_much_less_sure_as_their_object():
    rng = np.random.default_rng(1)
    there = Card(*rng.uniform((60, 60), np.subtract(SIZE, 60)), rng.uniform(-np.pi, np.pi), SCALE)
    picture = amid([there], 130, rng)
    one, other = (found(picture, **values).detections[0] for values in ({}, {"chance_share": NONE}))
    assert one.beyond_chance < 1 and one.score == pytest.approx(other.score * one.beyond_chance)
    scores = [part.score * one.beyond_chance for part in other.components]
    assert [part.score for part in one.components] == pytest.approx(scores)
