"""Which of two mirrored turns an object has adds up over time."""

from dataclasses import replace

import numpy as np
import pytest
from test_tracking import COVARIANCE, PERIOD, START, frame, posed

from artrec_ros.core.base.config import RecognizerConfig, TrackingConfig
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.found import OtherTurn
from artrec_ros.core.tracking.tracker import Tracker
from artrec_ros.core.tracking.turns import combined, handed_on

RIGHT, WRONG = 0.7, -0.7
ALONE = 0.05  # deviation of the joint, were it surely this turn


def seen(turn, probability, at=0.0):
    """A detection turned one way about y, and its mirrored turn, a little farther away."""
    d = posed(0.1, z=1.0, turn=turn + at)
    other = Pose(rotation_from_rotvec([0.0, at - turn, 0.0]), np.array([0.1, 0.0, 1.02]))
    off = np.array([0, 0, 0.02, 0, -2 * turn, 0])
    d = replace(d, score=0.99, joints={"arm": turn}, joint_deviations={"arm": ALONE}, pose_covariance=COVARIANCE)
    seen = d.beside(OtherTurn(other, probability, {"arm": -turn}), probability)
    np.testing.assert_allclose(seen.pose_covariance, COVARIANCE + probability * np.outer(off, off), atol=1e-12)
    return seen


def told(frames, config=None, period=PERIOD, **how):
    tracker = Tracker(config or TrackingConfig(), **how)
    return [tracker.update(START + k * period, frame(d)).detections[0] for k, d in enumerate(frames)]


def turn_of(d):
    return float(np.arctan2(d.pose.rotation[0, 2], d.pose.rotation[0, 0]))


def test_frames_that_differ_are_outvoted():
    frames = [seen(WRONG if k % 3 == 2 else RIGHT, 0.3) for k in range(30)]
    out = told(frames)
    assert all(turn_of(d) == pytest.approx(RIGHT) for d in out)
    assert all(d.joints == {"arm": RIGHT} and d.other_turn.joints == {"arm": WRONG} for d in out)
    assert out[-1].other_turn.probability < 0.35 and turn_of_other(out[-1]) == pytest.approx(WRONG)


def turn_of_other(d):
    return turn_of(replace(d, pose=d.other_turn.pose))


def test_a_wrong_beginning_is_mended_once_and_for_all():
    out = [turn_of(d) > 0 for d in told([seen(WRONG, 0.4)] + [seen(RIGHT, 0.2)] * 20)]
    assert not out[0] and all(out[2:])


def test_it_follows_an_object_that_turns():
    out = told([seen(WRONG if k % 4 == 3 else RIGHT, 0.3, at=0.02 * k) for k in range(40)])
    np.testing.assert_allclose([turn_of(d) for d in out], RIGHT + 0.02 * np.arange(40), atol=1e-6)


def test_what_has_one_turn_alone_is_told_as_it_is():
    plain = [replace(seen(turn, 0.3), other_turn=None) for turn in (RIGHT, RIGHT, WRONG, RIGHT)]
    assert [turn_of(d) > 0 for d in told(plain)] == [True, True, False, True]


def test_the_covariance_goes_with_the_probability():
    one, many = told([seen(RIGHT, 0.3)])[0], told([seen(RIGHT, 0.3)] * 30)[-1]
    assert many.other_turn.probability < one.other_turn.probability
    for d in (one, many):
        off = np.array([0, 0, 0.02, 0, -2 * RIGHT, 0])
        expected = COVARIANCE + d.other_turn.probability * np.outer(off, off)
        np.testing.assert_allclose(d.pose_covariance, expected, atol=1e-9)


def test_deviations_of_joints_count_the_other_turn_s_whichever_is_told():
    for d in (*told([seen(RIGHT, 0.3)]), *told([seen(WRONG, 0.4)] + [seen(RIGHT, 0.2)] * 2 + [seen(WRONG, 0.4)])):
        p = d.other_turn.probability
        assert d.joint_deviations["arm"] == pytest.approx(np.sqrt(ALONE**2 + p * (2 * RIGHT) ** 2))


def test_alike_frames_tell_little_more_than_one():
    assert combined(2.0, 1, 0.5) == 2.0
    assert combined(200.0, 100, 0.1) == pytest.approx(200 / 10.9)
    assert combined(200.0, 100, 1.0) == pytest.approx(2.0)


def test_what_is_told_half_way_between_both_turns_hands_nothing_on():
    sure = [seen(RIGHT, 0.2)] * 20
    between = replace(posed(0.1, z=1.0), score=0.99, pose_covariance=COVARIANCE, pose_from="fit")
    alone, after = told([seen(WRONG, 0.4)])[-1], told([*sure, between, seen(WRONG, 0.4)])[-1]
    assert turn_of(alone) == pytest.approx(WRONG) and turn_of(after) == pytest.approx(WRONG)
    assert after.other_turn.probability > 0.39  # twenty frames say nothing of it
    assert turn_of(told([*sure, seen(WRONG, 0.4)])[-1]) == pytest.approx(RIGHT)


def test_odds_are_handed_on_as_far_as_it_is_the_same_turn():
    assert handed_on(3.0, 50.0) == pytest.approx(3.0) and handed_on(3.0, -50.0) == pytest.approx(-3.0)
    assert handed_on(3.0, 0.0) == pytest.approx(0.0) and 0 < handed_on(3.0, 1.0) < 1.0


def test_what_was_long_ago_counts_no_more():
    frames = [seen(RIGHT, 0.3)] * 10 + [seen(WRONG, 0.3)]
    assert turn_of(told(frames, TrackingConfig(max_gap_s=100.0), period=60 * 10**9)[-1]) == pytest.approx(WRONG)
    assert turn_of(told(frames)[-1]) == pytest.approx(RIGHT)


@pytest.mark.parametrize(
    "by_itself", [{"config": TrackingConfig(enabled=False)}, {"recognizer": RecognizerConfig(memory=False)}]
)
def test_no_memory_where_tracking_is_off_or_each_frame_is_judged_by_itself(by_itself):
    out = told([seen(RIGHT, 0.3), seen(WRONG, 0.3)], **by_itself)
    assert [turn_of(d) > 0 for d in out] == [True, False]
