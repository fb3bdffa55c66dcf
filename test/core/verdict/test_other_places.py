"""How sure the place of an object is whose seen parts may be other ones of it."""

from __future__ import annotations

import numpy as np
import pytest
from settings import settings
from solids import rectangle
from squares import TEAM, Placing, hinge, patch, rendered
from tools_of_two import TAIL, TAPE, Tool, tool
from wedges import DOTS, Wedge, dotted

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import ImagePose
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

SCALE = 500.0
LIMITS = {"time_budget_ms": 60000.0, "min_scale": 400.0, "max_scale": 600.0}
TOLD, PLACE = 0.05, ImagePose(3.0, 4.0, 0.1, 500.0)


def recognized(wedge, **told):
    engine = Recognizer((Target("wedge", dotted(), TEAM),), settings(**LIMITS, **told), Segmenter(ImageConfig()))
    return engine.recognize(rendered(wedge))


def is_there(image, wedge):
    """Whether its required disc and its turn are its own."""
    off = np.hypot(*(wedge.at([DOTS["front"]])[0] - (image.x, image.y)))
    return off < 3 and np.cos(image.theta + wedge.turn) > 0.97


def placed(hidden, n):
    rng = np.random.default_rng(n)
    return Wedge(rng.uniform(60, 90), rng.uniform(50, 70), rng.uniform(-np.pi, np.pi), SCALE, hidden)


@pytest.mark.parametrize("n", range(4))
def test_one_that_is_seen_whole_is_sure(n):
    wedge = placed("", n)
    (found,) = recognized(wedge).detections
    assert is_there(found.image, wedge) and found.score > 0.95 and found.other_place is None


@pytest.mark.parametrize("hidden", ["left", "right"])
def test_of_one_in_four_places_no_more_is_said_than_how_often_it_is_right(hidden):
    """Nothing but two discs: each of four places is as good."""
    scores, right = list[float](), 0
    for n in range(12):
        wedge = placed(hidden, n)
        (found,) = recognized(wedge, min_probability=TOLD).detections
        other = found.other_place
        assert other is not None and other.probability <= found.score / found.beyond_chance + 0.03
        assert np.hypot(other.image.x - found.image.x, other.image.y - found.image.y) > 20 or (
            abs(np.cos(other.image.theta - found.image.theta)) < 0.97
        )
        assert not (is_there(found.image, wedge) and is_there(other.image, wedge))
        scores.append(found.score)
        right += is_there(found.image, wedge)
    assert max(scores) < 0.5 and np.mean(scores) == pytest.approx(right / len(scores), abs=0.25)


def test_a_part_is_surer_than_the_object_where_another_place_leaves_it_there():
    (found,) = recognized(placed("left", 0), min_probability=TOLD).detections
    front = found.instance_of("front")
    assert front is not None and front.score > 1.3 * found.score
    assert all(part.score < 0.7 for part in found.components)


def test_what_is_less_probable_than_an_object_must_be_is_turned_down_with_the_reason():
    result = recognized(placed("left", 0), min_probability=0.5)
    assert not result.detections
    assert any("looks like other parts of it, laid otherwise" in r.reason for r in result.rejected)


def told(*placed, **said):
    target, limits = Target("tool", tool(slides=True), TEAM), {"time_budget_ms": 60000.0, "min_scale": 250.0}
    return Recognizer((target,), settings(**limits, max_scale=380.0, **said), Segmenter(ImageConfig())).recognize(
        rendered(*placed, size=(320, 240))
    )


@pytest.mark.parametrize("x", [25.0, 160.0, 295.0], ids=["at a border", "amid the image", "at the other one"])
def test_a_tool_of_which_a_lone_tape_is_seen_is_not_surely_turned_so(x):
    """Least of all where it would have its other part out of the image: something unknown may as well hide that."""
    (found,) = told(Tool(x, 120.0, 0.2, 310.0, "tail"), min_probability=TOLD).detections
    assert [part.component for part in found.components] == ["tape"]
    assert found.score <= 0.81 and found.as_told <= 0.81 and found.there > 0.5
    other = found.other_place
    assert other is not None and 0.15 < other.probability <= 0.55
    assert np.cos(other.image.theta - found.image.theta) < -0.99
    assert np.hypot(other.image.x - found.image.x, other.image.y - found.image.y) < 2


@pytest.mark.parametrize("n", range(4))
def test_a_lone_part_whose_own_outline_tells_is_turned_as_that_says(n):
    """What is limited is what the hidden part says, not what is seen."""
    rng, taper = np.random.default_rng(n), np.array([[1, 1], [1, 0.7], [1, 0.7], [1, 1]])
    target = Target("tool", tool(TAPE * taper), TEAM)

    class Tapered(Tool):
        def patches(self):
            return [(self.at(TAPE * taper), TEAM)]

    limits = settings(time_budget_ms=60000.0, min_scale=250.0, max_scale=380.0, min_probability=TOLD)
    at = Tapered(rng.uniform(120, 200), rng.uniform(80, 160), rng.uniform(-3, 3), 310.0, "tail")
    (found,) = (
        Recognizer((target,), limits, Segmenter(ImageConfig())).recognize(rendered(at, size=(320, 240))).detections
    )
    assert found.as_told > 0.9 and np.cos(found.image.theta + at.turn) > 0.9  # its axis is a diagonal


def test_one_whose_other_part_is_seen_is_turned_as_that_says():
    (found,) = told(Tool(160.0, 120.0, 0.2, 310.0)).detections
    assert found.score > 0.9 and found.as_told == 1 and found.other_place is None


UPPER, LOWER = rectangle(0.155, 0.012) + (0.09, 0.0), rectangle(0.11, 0.011) - (0.075, 0.0)


class Bar(Placing):
    """Of a bar and one that hangs on its end that which is required."""

    def patches(self):
        return [(self.at(UPPER), TEAM)]


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])
@pytest.mark.parametrize("turn", [0.0, np.pi])
def test_a_part_of_which_much_should_be_in_view_either_way_tells_no_turn(share, turn):
    """Be most of it beyond the image's border: none of it is seen where it might be."""
    limits = settings(time_budget_ms=60000.0, min_scale=350.0, max_scale=460.0, min_probability=TOLD)
    lower = Component("lower", (patch("lower", LOWER),), label=TAIL, joint=hinge("upper", (0, 0, 0), (0, 0, 1)))
    model = ObjectModel("pair", (Component("upper", (patch("upper", UPPER),), required=True), lower))
    engine = Recognizer((Target("pair", model, TEAM),), limits, Segmenter(ImageConfig()), calibrated=False)
    x = (0.02 + 0.11 * share) * 400.0  # of the end that is near the border
    bar = Bar(x if turn == 0 else x + 0.18 * 400.0, 120.0, turn, 400.0)
    (found,) = engine.recognize(rendered(bar, size=(320, 240))).detections
    assert found.as_told < 0.55 and found.other_place is not None
    assert [(m.component, m.state) for m in found.missing] == [("lower", "not seen")]
