"""Classes of configurations, learned and told apart: in the image plane and in space."""

import dataclasses
import itertools

import numpy as np
import pytest
from scene import Placed, crane, crane_placed, flag, polygon, rectangle
from settings import settings

from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.constraints.classes import ConfigurationClass, JointRange
from artrec_ros.core.constraints.constraint_set import ConstraintSet
from artrec_ros.core.constraints.intervals import Interval
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.learning.class_learning import learn_class
from artrec_ros.core.learning.pair_learning import learn
from artrec_ros.core.model.found import ClassFit, Detection, ImagePose, Instance
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.verdict.classify import Classifier

SWINGS = {"shut": (0.5, -0.5), "open": (-0.5, 0.5), "left": (0.5, 0.5)}
UNTAUGHT = (-0.5, -0.5)


def posed(swings, rng, scatter=0.05):
    at = tuple(np.array(swings) + rng.normal(0, scatter, 2))
    return crane_placed(*rng.uniform(100, 500, 2), rng.uniform(-3, 3), rng.uniform(60, 120), at)


def learned(count=40):
    rng = np.random.default_rng(1)
    examples = {name: [posed(s, rng) for _ in range(count)] for name, s in SWINGS.items()}
    classes = tuple(learn_class(name, crane(), rows) for name, rows in examples.items())
    general = learn(crane(), [e for rows in examples.values() for e in rows])
    return dataclasses.replace(general, classes=classes)


def detection(placed, without=(), turned=()):
    """As the recogniser reports it; the ribbons of `turned` the other way round, which looks the same."""
    parts = tuple(
        Instance(c, m, 0.9, p.x, p.y, p.theta + np.pi * (c in turned), p.scale)
        for (c, m), p in placed.items()
        if c not in without
    )
    base = parts[0]
    return Detection("it", 0, 0.9, ImagePose(base.x, base.y, base.theta, base.scale), parts)


CONSTRAINTS = learned()
CLASSIFIER = Classifier([Target("it", crane(), 1, CONSTRAINTS)], RecognizerConfig())


def fit(placed, **changes) -> ClassFit:
    (found,) = CLASSIFIER.classified([detection(placed, **changes)])
    return found.class_fit


def test_each_class_is_told_and_what_was_never_taught_is_of_none():
    rng = np.random.default_rng(2)
    for name, swings in SWINGS.items():
        told = [fit(posed(swings, rng)) for _ in range(40)]
        assert sum(t.name == name for t in told) >= 38
        assert all(t.runner_up in SWINGS and t.runner_up != name for t in told)
        assert np.median([t.confidence for t in told]) > 0.95
    refused = [fit(posed(UNTAUGHT, rng)) for _ in range(40)]
    assert all(r.name is None for r in refused)
    assert all("outside" in r.reason for r in refused)


def test_the_region_covers_what_it_promises_of_new_examples():
    rng, inside = np.random.default_rng(3), []
    bare = settings(class_noise=0.0, contour_noise_px=0.0, model_noise=0.0, min_class_confidence=0.0)
    for _ in range(15):
        rows = [posed(SWINGS["shut"], rng) for _ in range(30)]
        constraints = dataclasses.replace(learn(crane(), rows), classes=(learn_class("shut", crane(), rows, (), 0.9),))
        classifier = Classifier([Target("it", crane(), 1, constraints)], bare)
        new = [detection(posed(SWINGS["shut"], rng)) for _ in range(30)]
        inside += [d.class_fit.name == "shut" for d in classifier.classified(new)]
    assert 0.87 < np.mean(inside) < 0.97


def test_a_ribbon_that_lies_the_other_way_round_is_the_same():
    rng = np.random.default_rng(4)
    told = [fit(posed(SWINGS["open"], rng), turned=("fore", "aft")).name for _ in range(20)]
    assert told.count("open") >= 18


def pointer(turn, rng):
    """A bar, and a triangle beside it that is turned."""
    bar = Placed(*rng.uniform(100, 300, 2), rng.uniform(-3, 3), 80)
    x, y, turn = (1.2, 0.3, turn) + rng.normal(0, (0.15, 0.15, 0.02))
    return {("bar", "bar"): bar, ("tri", "triangle"): bar.moved(x, y, turn)}


def test_of_two_symmetric_markers_every_way_they_look_the_same_is_one_class():
    """A bar after half a turn, a triangle after a third: together after a sixth."""
    rng, corners = np.random.default_rng(6), 0.4 * np.exp(2j * np.pi * np.arange(3) / 3)
    triangle = polygon("triangle", *zip(corners.real, corners.imag, strict=True))
    parts = Component("bar", (rectangle("bar", 1.0, 0.2),), required=True), Component("tri", (triangle,))
    model, turns = ObjectModel("pointer", parts), {"low": 0.0, "high": np.pi / 6}
    rows = {name: [pointer(turn, rng) for _ in range(30)] for name, turn in turns.items()}
    classes = tuple(learn_class(name, model, examples) for name, examples in rows.items())
    constraints = dataclasses.replace(learn(model, [e for r in rows.values() for e in r]), classes=classes)
    classifier = Classifier([Target("it", model, 1, constraints)], settings(class_noise=0.01))
    for name, turn in turns.items():
        for half, third in itertools.product(range(2), range(3)):
            seen = pointer(turn + 2 * np.pi / 3 * third, rng)
            seen["bar", "bar"] = seen["bar", "bar"].moved(0, 0, np.pi * half)
            told = classifier.fit(detection(seen))
            assert told.name == name, (half, third, told)


def test_what_is_not_seen_cannot_be_told():
    rng = np.random.default_rng(5)
    placed = posed(SWINGS["shut"], rng)
    assert fit(placed, without=("fore",)).name is None
    assert "seen" in fit(placed, without=("fore",)).reason
    config = settings(min_class_seen=0.5)
    lenient = Classifier([Target("it", crane(), 1, CONSTRAINTS)], config)
    (found,) = lenient.classified([detection(placed, without=("fore",))])
    # `aft` hangs alike in no other class
    assert found.class_fit.name == "shut"
    (found,) = lenient.classified([detection(placed, without=("aft",))])  # `fore` hangs alike in `left`
    assert found.class_fit.confidence < 0.7


def test_objects_without_classes_have_none():
    plain = Classifier([Target("it", crane(), 1, learn(crane(), []))], RecognizerConfig())
    assert plain.classified([detection(posed(UNTAUGHT, np.random.default_rng(0)))])[0].class_fit is None


def hinged() -> ObjectModel:
    joint = Joint("base", Pose.from_xyz_rpy((0, 0, 0), (0, 0, 0)), np.array([1.0, 0, 0]), -2.0, 2.0)
    place = Pose.from_xyz_rpy((0, 0, 0), (0, 0, 0))
    base = dataclasses.replace(flag(), T_component_marker=place)
    arm = Marker("arm", base.outline, base.tail, base.head, T_component_marker=place)
    return ObjectModel(
        "hinged", (Component("base", (base,), required=True), *(Component(n, (arm,), joint=joint) for n in "ab"))
    )


def test_in_space_joints_are_compared():
    model, rng = hinged(), np.random.default_rng(6)
    centres = {"up": (1.0, 1.0), "down": (-1.0, -1.0)}
    rows = {n: [dict(zip("ab", c + rng.normal(0, 0.1, 2), strict=True)) for _ in range(30)] for n, c in centres.items()}
    classes = tuple(learn_class(n, model, [], joints) for n, joints in rows.items())
    target = Target("it", model, 1, ConstraintSet("hinged", 0.95, (), classes))
    classifier = Classifier([target], RecognizerConfig())
    pose = Pose.from_xyz_rpy((0, 0, 1), (0, 0, 0))

    def told(**joints):
        return classifier.fit(Detection("it", 0, 1.0, ImagePose(0, 0, 0, 1), (), pose, joints))

    assert told(a=1.05, b=0.95).name == "up"
    assert told(a=-1.05, b=-0.95).name == "down"
    assert told(a=1.0, b=-1.0).name is None and "lies" in told(a=1.0, b=-1.0).reason
    assert told(a=1.0).name is None  # half of it is not seen
    assert told().name is None


def test_what_was_found_flat_is_compared_by_pairs_whatever_gave_it_a_pose():
    """Learned in space, too, classes have joints; a pose by size or on a plane brings none."""
    ranges = {"swing": JointRange(30, Interval(-1, 1), Interval(-1, 1))}
    classes = tuple(dataclasses.replace(c, joints=ranges) for c in CONSTRAINTS.classes)
    both = dataclasses.replace(CONSTRAINTS, classes=classes)
    classifier = Classifier([Target("it", crane(), 1, both)], RecognizerConfig())
    found = detection(crane_placed(200, 100, 0.5, 100, SWINGS["shut"]))
    for source in ("size", "plane"):
        placed = dataclasses.replace(found, pose=Pose.from_xyz_rpy((0, 0, 1), (0, 0, 0)), pose_from=source)
        assert classifier.fit(placed).name == "shut"


@pytest.mark.parametrize("angle, name", [(1.0, "up"), (-1.0, "down"), (0.0, None)])
def test_regions_without_width_are_told_apart_without_any_noise(angle, name):
    """Examples that are all the same make such; no image tells angles to the last bit."""
    rows = {"up": [{"a": 1.0, "b": 1.0}] * 30, "down": [{"a": -1.0, "b": -1.0}] * 30}
    classes = tuple(learn_class(n, hinged(), [], joints) for n, joints in rows.items())
    assert classes[0].joints["a"].allowed.width == 0
    target = Target("it", hinged(), 1, ConstraintSet("hinged", 0.95, (), classes))
    classifier, pose = Classifier([target], settings(class_noise=0.0)), Pose.from_xyz_rpy((0, 0, 1))
    joints = {"a": angle + 1e-9, "b": angle}
    told = classifier.fit(Detection("it", 0, 1.0, ImagePose(0, 0, 0, 1), (), pose, joints))
    assert told.name == name
    assert told.confidence > 0.99 and 0 <= told.runner_up_confidence < 0.01


def test_pairs_without_width_are_told_apart_without_any_noise():
    classes = tuple(learn_class(n, crane(), [crane_placed(300, 200, 0, 80, at)] * 30) for n, at in SWINGS.items())
    constraints = dataclasses.replace(CONSTRAINTS, classes=classes)
    bare = settings(class_noise=0.0, contour_noise_px=0.0, model_noise=0.0)
    classifier = Classifier([Target("it", crane(), 1, constraints)], bare)
    for name, at in {**SWINGS, None: UNTAUGHT}.items():
        told = classifier.fit(detection(crane_placed(200, 100, 0.5, 100, at)))
        assert told.name == name and told.confidence > 0.99


def test_plain_values_come_back_and_mistakes_are_named():
    again = ConstraintSet.from_dict(CONSTRAINTS.to_dict())
    assert again.to_dict() == CONSTRAINTS.to_dict()
    assert [c.name for c in again.classes] == list(SWINGS)
    values = learn_class("up", hinged(), [], [{"a": 0.1, "b": 0.2}, {"a": 0.3, "b": 0.1}]).to_dict()
    back = ConfigurationClass.from_dict(values, "classes[0]")
    assert back.joints["a"].seen.high == pytest.approx(0.3)
    values["joints"]["a"]["allowed"] = [1.0, 0.0]
    with pytest.raises(ConfigError, match=r"classes\[0\] \(up\): joints: a"):
        ConfigurationClass.from_dict(values, "classes[0]")
    twice = CONSTRAINTS.to_dict()
    twice["classes"].append(twice["classes"][0])
    with pytest.raises(ConfigError, match="name of its own"):
        ConstraintSet.from_dict(twice)


def test_joints_of_another_model_are_refused():
    wrong = ConstraintSet("crane", 0.95, (), (learn_class("up", hinged(), [], [{"a": 0.0}, {"a": 0.1}]),))
    with pytest.raises(ConfigError, match="'a' is no joint"):
        wrong.check_model(crane())
