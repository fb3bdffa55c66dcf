"""Limits of joints whose axes were measured anew: what they allowed stays allowed, and all that is marked occurs."""

from dataclasses import replace

import numpy as np
import pytest
from fingers import ELSEWHERE, PX_PER_M, RED, finger, marks, picture, placed
from settings import settings

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.learning.joint_limits import Carried, JointValues, carried
from artrec_ros.core.learning.marked_views import Figure, Marks
from artrec_ros.core.learning.size_fit import measure
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer

SHOWN = np.column_stack([np.linspace(-0.2, 0.2, 9), np.linspace(0.1, 0.5, 9), np.linspace(0.0, 0.3, 9)])
PLACES = [f"annotation {n}" for n in range(9)]
CLEAR = 0.01  # deviation of a value that a mark tells


def told(q, deviation=CLEAR):
    return JointValues(q, np.full(q.shape, deviation))


def with_joint(model, name, **other):
    parts = (replace(c, joint=replace(c.joint, **other)) if c.name == name else c for c in model.components)
    return replace(model, components=tuple(parts))


def moved(q, by, model=None):
    """What becomes of joints whose marked values `SHOWN` are `q + by` by measured lengths."""
    kin = Kinematics(model or finger())
    return kin, carried(kin, told(q), told(q + by))


def test_joints_that_do_not_move_keep_zero_and_limits_exactly():
    kin, found = moved(SHOWN, np.random.default_rng(0).normal(0, CLEAR, SHOWN.shape))
    np.testing.assert_array_equal([found.lower, found.upper, found.zero], [kin.lower, kin.upper, np.zeros(3)])
    model = finger()
    assert found.model(model).components == model.components and not list(found.changes(model, PLACES))


def test_a_little_drift_within_wide_limits_changes_nothing():
    _, found = moved(SHOWN, [0.05, 0.0, 0.0])  # of .15 on either side
    assert not found.zero.any()


@pytest.mark.parametrize("turns", [0.0, 2 * np.pi, -2 * np.pi])
def test_where_values_drift_out_of_limits_the_zero_goes_with_them(turns):
    model = finger()
    kin, found = moved(SHOWN, np.array([0.6, -0.3, 0.0]) + turns)
    np.testing.assert_allclose(found.zero, [0.6, -0.3, 0.0], atol=1e-9)
    np.testing.assert_array_equal([found.lower, found.upper], [kin.lower, kin.upper])
    q = np.array([[0.1, 0.2, 0.3]])
    here, there = (ends_of(m, v) for m, v in ((found.model(model), q), (model, q + found.zero)))
    np.testing.assert_allclose(here, there, atol=1e-12)
    assert [(c.name, c.new == c.old) for c in found.changes(model, PLACES)] == [("a", True), ("b", True)]


def ends_of(model, q):
    return Figure.of(model).ends(Poses(np.eye(3)[None], np.zeros((1, 3)), q))


def test_a_wider_range_keeps_the_room_that_limits_left_on_each_side():
    wider = SHOWN * [2.0, 1.0, 1.0]  # as of a marker nearer to its axis
    kin = Kinematics(finger())
    found = carried(kin, told(SHOWN), told(wider))
    np.testing.assert_allclose([found.lower[0], found.upper[0]], [-0.4 - 0.15, 0.4 + 0.15])
    (change,) = found.changes(finger(), PLACES)
    assert (change.name, change.old, change.shown_by) == ("a", (-0.35, 0.35), ("annotation 0", "annotation 8"))
    np.testing.assert_array_equal([found.lower[1:], found.upper[1:]], [kin.lower[1:], kin.upper[1:]])


def test_limits_that_hold_less_than_what_is_marked_are_told_with_what_would_hold_it():
    kin = Kinematics(finger(limits=((-0.1, 0.35), (-0.1, 0.8), (-0.2, 0.6))))
    found = carried(kin, told(SHOWN), told(SHOWN))
    assert found.lower[0] == pytest.approx(-0.2) and found.upper[0] == 0.35 and not found.zero.any()


def test_values_that_no_mark_tells_change_nothing():
    q, deviation = SHOWN + [0.6, 0.0, 0.0], np.full(SHOWN.shape, CLEAR)
    deviation[:, 0] = np.inf
    kin = Kinematics(finger())
    found = carried(kin, told(SHOWN), JointValues(q, deviation))
    np.testing.assert_array_equal([found.lower, found.upper, found.zero], [kin.lower, kin.upper, np.zeros(3)])
    deviation[:5, 0] = CLEAR  # told in some images
    found = carried(kin, told(SHOWN), JointValues(q, deviation))
    assert found.zero[0] == pytest.approx(0.6)


def test_what_turns_without_end_or_slides():
    endless = with_joint(finger(), "a", lower=-np.pi, upper=np.pi)
    _, found = moved(SHOWN, [2.0, 0.0, 0.0], endless)
    assert not list(found.changes(endless, PLACES)) and np.isinf(found.bounds(Kinematics(endless))[:, 0]).all()
    slides = with_joint(finger(), "a", kind="prismatic", axis=np.array([1.0, 0.0, 0.0]), lower=0.0, upper=0.02)
    q = np.column_stack([np.linspace(0.005, 0.015, 9), SHOWN[:, 1:]])
    kin = Kinematics(slides)
    deviation = np.tile([1e-4, CLEAR, CLEAR], (9, 1))
    found = carried(kin, JointValues(q, deviation), JointValues(q + [0.03, 0.0, 0.0], deviation))
    rest = found.model(slides).component("a").joint
    assert rest.T_parent_joint.position[0] == pytest.approx(0.045 + 0.03)
    assert (rest.lower, rest.upper) == (0.0, 0.02)


def test_bounds_are_limits_beside_the_old_zero():
    kin = Kinematics(finger())
    np.testing.assert_array_equal(Carried.as_is(kin).bounds(kin), [kin.lower, kin.upper])
    _, found = moved(SHOWN, [0.6, 0.0, 0.0])
    np.testing.assert_allclose(found.bounds(kin)[:, 0], [0.25, 0.95])


@pytest.fixture(scope="module")
def measured():
    """A finger with true limits whose pins are a quarter of its length off."""
    rng = np.random.default_rng(0)
    views = [marks(finger(), placed(finger(), rng), rng, f"annotation {n}") for n in range(12)]
    views[3] = Marks(views[3].marker[:3], views[3].ends[:3], views[3].place)  # its tip is not marked
    return measure(finger(ELSEWHERE), views, None)


def found_whole(model, count=8):
    """Of drawn fingers those of which each part is found at its place."""
    config = settings(time_budget_ms=60000, min_scale=0.9 * PX_PER_M, max_scale=1.1 * PX_PER_M)
    engine, rng, right = Recognizer((Target("finger", model, RED),), config, Segmenter(ImageConfig())), rng_of(5), 0
    for _ in range(count):
        at = placed(finger(), rng)
        want = marks(finger(), at).ends.mean(axis=1)
        parts = {
            c.component: (c.x, c.y) for d in engine.recognize(picture(finger(), at)).detections for c in d.components
        }
        off = [np.linalg.norm(np.subtract(parts.get(n, (0, 0)), w)) for n, w in zip(("bar", *"abc"), want, strict=True)]
        right += max(off) < 3.0
    return right


def rng_of(seed):
    return np.random.default_rng(seed)


def test_a_measured_object_is_recognised_better_than_before_and_not_worse(measured):
    assert measured.helps and {c.name for c in measured.limits} == {"a", "b", "c"}
    assert found_whole(measured.model) >= 7 > found_whole(finger(ELSEWHERE))


def test_limits_hold_all_that_was_marked(measured):
    rng = np.random.default_rng(0)
    views = [marks(finger(), placed(finger(), rng), rng, f"annotation {n}") for n in range(12)]
    again = measure(measured.model, views, None)
    assert not again.outside and not again.helps and again.before_px < 0.6


def test_distances_are_those_within_limits():
    """By lengths that hold, joints with too narrow limits are off, and are named."""
    narrow = finger(limits=((-0.35, 0.35), (-0.1, 0.2), (-0.2, 0.6)))
    rng = np.random.default_rng(2)
    views = [marks(finger(), placed(finger(), rng), rng, f"annotation {n}") for n in range(12)]
    wide, tight = (measure(m, views, None) for m in (finger(), narrow))
    assert tight.before_px > 1.5 * wide.before_px
    (outside,) = tight.outside
    assert outside.name == "b" and outside.new[0] == -0.1 and outside.new[1] == pytest.approx(0.75, abs=0.15)
    assert outside.shown_by[1].startswith("annotation")


def test_limits_do_not_grow_beyond_a_whole_turn():
    wide = SHOWN * [15.0, 1.0, 1.0]  # of a joint that shows .4 rad
    kin = Kinematics(finger())
    found = carried(kin, told(SHOWN), told(wide))
    assert found.too_wide(kin).tolist() == [True, False, False]
    as_it_was = found.without(found.too_wide(kin), kin)
    np.testing.assert_array_equal([as_it_was.lower, as_it_was.upper], [kin.lower, kin.upper])
    assert not list(as_it_was.changes(finger(), PLACES))
