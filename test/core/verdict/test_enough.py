"""Which objects are told, by what is told of them."""

from dataclasses import dataclass, replace

import pytest
from settings import DEFAULTS
from squares import ROBOT, TEAM
from wedges import DOTS, dotted

from artrec_ros.core.model.found import Detection, ImagePose, Instance, Missing, OtherPlace
from artrec_ros.core.model.objects import ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.verdict.enough import enough_of, without_surplus
from artrec_ros.core.verdict.judge import Judge

PLACE = ImagePose(3.0, 4.0, 0.1, 500.0)
REQUIRED, *OTHERS = DOTS


def finder_of(model: ObjectModel) -> WholeObjectFinder:
    return WholeObjectFinder(Target("toy", model, TEAM), DEFAULTS, facing=True)


def toy(*seen, score=0.9, missing=()):
    parts = tuple(Instance(name, name, 0.8, 3.0, 4.0, 0.1, 500.0) for name in seen)
    return Detection("toy", 0, score, PLACE, parts, missing=tuple(missing))


def told(detections, model, **settings):
    judge = replace(Judge.of(DEFAULTS), min_probability=0.4, **settings)
    kept, _, reasons = enough_of(detections, finder_of(model), judge)
    return kept, reasons


def test_who_is_turned_down_leaves_no_number():
    model = ROBOT["plain"]
    names = [c.name for c in model.components]
    one, two, three = (
        replace(toy(*names, score=score), id=n, other_place=OtherPlace(PLACE, 0.3))
        for n, score in enumerate((0.3, 0.6, 0.9))
    )
    many = replace(one, other_place=None, id=3)  # so many that none of them is worth being told
    kept, others = told([one, two, three, many], model)
    assert [(d.id, d.score) for d in kept] == [(0, 0.9), (1, 0.6)]
    assert [(r.score, r.x, r.y) for r in others] == [(0.3, 3.0, 4.0)] * 2


def test_one_that_is_there_and_may_be_turned_about_what_is_seen_is_told():
    """Which way, earlier frames may tell; one that may lie elsewhere is told nowhere."""
    there = replace(toy("front", score=0.3), other_place=OtherPlace(PLACE, 0.65))
    kept, others = told([replace(there, as_told=0.35), there], ROBOT["plain"])
    assert [d.as_told for d in kept] == [0.35] and len(others) == 1


def test_of_which_no_component_is_told_is_not_told():
    kept, (lack,) = told([toy(score=0.5)], ROBOT["plain"])
    assert not kept and lack.reason == "none of its components is sure enough to be told"


@pytest.mark.parametrize(("wanted", "seen", "kept"), [(2, 1, False), (2, 2, True), (0, 1, True), (9, 3, True)])
def test_as_many_components_are_told_as_are_wanted(wanted, seen, kept):
    """What the labels confirm may yet be too unsure to be told: who wants two does not get one. None has nine."""
    names = list(DOTS)
    few = [Missing(name, "too small", 0.0, 0.0) for name in names[seen:]]
    found, others = told([toy(*names[:seen], missing=few)], dotted(), min_components=wanted)
    assert (len(found) == 1) == kept
    if not kept:
        assert others[0].reason == "1 of its components are sure enough to be told, 2 are wanted"


@pytest.mark.parametrize(("state", "kept"), [("in doubt", False), ("not seen", False), ("too small", True)])
def test_a_disc_of_which_nothing_else_is_told_has_no_direction(state, kept):
    lacks = [Missing(name, state, 0.0, 0.0) for name in OTHERS]
    found, others = told([toy(REQUIRED, missing=lacks)], dotted())
    assert (len(found) == 1) == kept
    assert kept or "a disc, which tells no direction" in others[0].reason
    assert len(told([toy(*DOTS, missing=lacks[2:])], dotted())[0]) == 1


@dataclass(frozen=True)
class Sharing:
    """A describer of which some objects are too many."""

    mine: tuple[str, ...]
    too_many: tuple[str, ...] = ()

    def without_surplus(self, accepted, frame, judge):
        mine = [v for v in accepted if v in self.mine]
        rivals = {v: [f"instead of {v}"] for v in mine if v not in self.too_many}
        return list(rivals), [v for v in mine if v in self.too_many], rivals


def test_who_is_not_told_explains_nothing_that_others_leave():
    """Else a second leg, that occurs once and so is none, is why the first one's foot is not missed."""
    legs, arms = Sharing(("leg", "second leg"), ("second leg",)), Sharing(("arm",))
    accepted = ["leg", "second leg", "arm"]
    told, surplus, objects, rivals = without_surplus([legs, arms], accepted, None, Judge.of(DEFAULTS))
    assert (told, surplus, objects) == ([["leg"], ["arm"]], ["second leg"], ["leg", "arm"])
    assert rivals == {"leg": ["instead of leg"], "arm": ["instead of arm"]}
    assert without_surplus([arms], accepted, None, Judge.of(DEFAULTS))[2] is accepted
