"""Constraint files: round trip, and refusal of other objects' and broken ones."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from changes import changed

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.constraints.axis_offsets import AxisOffset
from artrec_ros.core.constraints.classes import ConfigurationClass, JointRange
from artrec_ros.core.constraints.constraint_set import ConstraintSet
from artrec_ros.core.constraints.intervals import Interval
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.learning.pair_learning import learn
from artrec_ros.core.model.found import Instance
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.io.learned.constraints import load_constraints, save_constraints

FLAG = Marker("flag", np.array([[0, 0], [0.4, 0], [0.3, 0.1], [0.4, 0.2], [0, 0.2]]), [0, 0.1], [0.3, 0.1])
MODEL = ObjectModel("toy", (Component("base", (FLAG,), required=True), Component("arm", (FLAG,))))


@pytest.fixture
def constraints() -> ConstraintSet:
    rng = np.random.default_rng(5)
    examples = [
        {
            ("base", "flag"): Instance("base", "flag", 1.0, 50, 40, 3.0 + a, 100.0),
            ("arm", "flag"): Instance("arm", "flag", 1.0, 50 - 60 * np.cos(a), 40 - 60 * np.sin(a), a, 104.0),
        }
        for a in rng.uniform(-0.4, 0.4, 12)
    ]
    return learn(MODEL, examples)


def test_round_trip(tmp_path: Path, constraints: ConstraintSet) -> None:
    path = tmp_path / "sub" / "c.yaml"
    save_constraints(path, constraints)
    again = load_constraints(path, MODEL)
    save_constraints(tmp_path / "again.yaml", again)
    assert (tmp_path / "again.yaml").read_text() == path.read_text()
    assert again.object == "toy" and again.pairs[0].examples == 12
    for name, interval in constraints.pairs[0].allowed.items():
        kept = again.pairs[0].allowed[name]
        assert (kept.low, kept.high, kept.period) == pytest.approx(
            (interval.low, interval.high, interval.period), abs=1e-6
        )


JOINED = ObjectModel(
    "toy",
    (
        Component("base", (FLAG,), required=True),
        Component("arm", (FLAG,), joint=Joint("base", Pose.identity(), np.array([1.0, 0, 0]), -3.2, 3.2)),
    ),
)


@pytest.fixture
def everything(constraints: ConstraintSet) -> ConstraintSet:
    """With two classes, joints among what they compare, and an axis."""
    still = ConfigurationClass("still", 12, constraints.pairs)
    wide = Interval(2.9, 3.6, 2 * np.pi)
    moving = ConfigurationClass("moving", 9, (), {"arm": JointRange(9, wide, Interval(3.0, 3.5, 2 * np.pi))})
    axis = AxisOffset(("arm", "flag"), (0.001, -0.002), 0.03, 12, 1.5, 0.1)
    return replace(constraints, classes=(still, moving), axes=(axis,))


def test_classes_and_axes_come_back(tmp_path: Path, everything: ConstraintSet) -> None:
    save_constraints(tmp_path / "c.yaml", everything)
    again = load_constraints(tmp_path / "c.yaml", JOINED)
    assert again.axes == everything.axes
    assert [c.name for c in again.classes] == ["still", "moving"]
    allowed = again.classes[1].joints["arm"].allowed
    assert (allowed.low, allowed.high, allowed.period) == pytest.approx((2.9, 3.6, 2 * np.pi), abs=1e-5)
    text = (tmp_path / "c.yaml").read_text()
    assert "# classes:" in text and "# axes:" in text


ALLOWED = ("pairs[0] (base/flag - arm/flag): allowed: ",)


def save_changed(folder: Path, constraints: ConstraintSet, place: str, value: Any) -> Path:
    """A file of constraints with one value changed."""
    path = folder / "c.yaml"
    save_constraints(path, constraints)
    path.write_text(yaml.safe_dump(changed(yaml.safe_load(path.read_text()), place, value)))
    return path


def assert_refused(path: Path, model: ObjectModel, parts: tuple[str, ...]) -> None:
    with pytest.raises(ConfigError) as caught:
        load_constraints(path, model)
    for part in (str(path), *parts):
        assert part in str(caught.value)


@pytest.mark.parametrize(
    ("change", "value", "parts"),
    [
        ("classes/0/name", None, ("classes[0]", "name")),
        ("classes/1/name", "still", ("name of its own",)),
        ("classes/1/joints", {"amr": {}}, ("'amr'", "'arm'")),
        ("classes/1/joints/arm/allowed", [1, 0], ("joints: arm: allowed: [1, 0]", "from low to high")),
        ("classes/1/joints/arm/seen", [90, 120, 6.283185], ("joints: arm: seen: [90, 120]", "radians")),
        ("classes/0/pairs/0/allowed/distance_m", [-5, -1], ("classes[0] (still): pairs[0] (", "0 or more")),
        ("classes/0/pairs/0/first", "bse/flag", ("bse/flag", "'base/flag'")),
        ("axes/0/marker", "arm/flg", ("arm/flg", "'arm/flag'")),
        ("axes/0/shift_m", [1], ("shift_m", "[x, y]")),
    ],
)
def test_mistakes_in_classes_and_axes_are_named(
    tmp_path: Path, everything: ConstraintSet, change: str, value: Any, parts: tuple[str, ...]
) -> None:
    assert_refused(save_changed(tmp_path, everything, change, value), JOINED, parts)


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path, constraints: ConstraintSet) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="file/c.yaml"):
        save_constraints(tmp_path / "file" / "c.yaml", constraints)


@pytest.mark.parametrize(
    ("change", "value", "parts"),
    [
        ("object", "other", ("object", "'other'", "'toy'")),
        ("format", "artrec_constraints/9", ("format", "artrec_constraints/1")),
        ("coverage", 2, ("coverage", "greatest value 1")),
        ("pairs", None, ("pairs", "missing")),
        ("pairs", [], ("pairs: is empty", "pose", "artrec train")),
        ("pairs/0/first", "bas/flag", ("pairs[0].first", "'base/flag'")),
        ("pairs/0/examples", -1, ("pairs[0].examples", "least value 0")),
        ("pairs/0/seen", None, ("pairs[0].seen", "missing")),
        ("pairs/0/alowed", {}, ("pairs[0].alowed", "'allowed'")),
        ("pairs/0/allowed/turn", [0, 1], ("pairs[0].allowed.turn", "turn_rad")),
        ("pairs/0/allowed/turn_rad", [1, 0], (*ALLOWED, "turn_rad: [1, 0]", "from low to high")),
        ("pairs/0/allowed/turn_rad", [0, 1, 7], (*ALLOWED, "turn_rad: its period 7")),
        ("pairs/0/allowed/turn_rad", [90, 91], (*ALLOWED, "turn_rad: [90, 91]", "radians: low lies between")),
        ("pairs/0/allowed/bearing_rad", [-3, 3.5], (*ALLOWED, "bearing_rad: [-3, 3.5]", "at most one turn")),
        ("pairs/0/allowed/distance_m", [-5, -1], (*ALLOWED, "distance_m: [-5, -1]", "distances are 0 or more")),
        ("pairs/0/seen/distance_px", [-5, -1], ("seen: distance_px: [-5, -1]", "distances are 0 or more")),
        ("pairs/0/allowed/scale_ratio", [0, 0], (*ALLOWED, "scale_ratio: [0, 0]", "ratios are above 0")),
        ("pairs/0/allowed/distance_m", [-1e308, 1e308], ("pairs[0].allowed.distance_m[0]", "least value -1e+06")),
        ("pairs/0/allowed/scale_ratio", [1, 1, 1], (*ALLOWED, "scale_ratio: [1, 1, 1]", "[low, high]")),
        ("pairs/0/allowed/scale_ratio", [1, "x"], ("pairs[0].allowed.scale_ratio[1]", "number")),
    ],
)
def test_mistakes_are_refused_by_their_key(
    tmp_path: Path, constraints: ConstraintSet, change: str, value: Any, parts: tuple[str, ...]
) -> None:
    assert_refused(save_changed(tmp_path, constraints, change, value), MODEL, parts)


def test_what_is_found_without_pairs_needs_none(tmp_path: Path) -> None:
    placed = replace(FLAG, T_component_marker=Pose.identity())
    alone = ObjectModel("toy", (Component("base", (FLAG,), required=True),))
    spatial = replace(JOINED, components=tuple(replace(c, markers=(placed,)) for c in JOINED.components))
    save_constraints(tmp_path / "c.yaml", ConstraintSet("toy", 0.95, ()))
    for model in (alone, spatial):
        assert load_constraints(tmp_path / "c.yaml", model).pairs == ()


def test_ends_that_pairs_can_meet_are_taken(tmp_path: Path, constraints: ConstraintSet) -> None:
    """Margins of learned boxes reach below 0, and angles that are told from 0 to a turn."""
    for dimension, ends in (("distance_m", [-0.1, 0]), ("scale_ratio", [-0.2, 1.9]), ("turn_rad", [0, 6.283186])):
        load_constraints(save_changed(tmp_path, constraints, f"pairs/0/allowed/{dimension}", ends), MODEL)


def test_a_pair_given_twice_is_refused(tmp_path: Path, constraints: ConstraintSet) -> None:
    path = tmp_path / "c.yaml"
    save_constraints(path, constraints)
    content = yaml.safe_load(path.read_text())
    content["pairs"] += copy.deepcopy(content["pairs"])
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(ConfigError, match="c.yaml: .*twice"):
        load_constraints(path, MODEL)
