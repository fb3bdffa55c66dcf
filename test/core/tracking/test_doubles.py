"""One object has one track: there is no room for two of a name in one place."""

from dataclasses import replace

import numpy as np
import pytest
from solids import truck
from test_tracking import PERIOD, START, flat, frame, posed

from artrec_ros.core.base.config import TrackingConfig
from artrec_ros.core.model.target import Target
from artrec_ros.core.tracking.tracker import Tracker

PREDICTS = TrackingConfig(predict=1.0)


def told(frames, config=PREDICTS):
    """The detections of each frame; the object is 20 cm long."""
    tracker = Tracker(config, [Target("red", truck(), 3)])
    return [tracker.update(START + k * PERIOD, frame(*found)).detections for k, found in enumerate(frames)]


def sure(detection):
    return replace(detection, score=0.99, pose_covariance=None if detection.pose is None else np.eye(6) * 1e-6)


@pytest.mark.parametrize("leap", [0.05, 0.09])
def test_what_leaps_within_its_own_size_is_itself(leap):
    there, leapt = sure(posed(0.0, z=2.0)), sure(posed(leap, z=2.0))
    detections = told([[there]] * 10 + [[leapt]] + [[there]] * 10)
    assert {tuple((d.id, d.predicted) for d in found) for found in detections} == {((0, False),)}


def test_beside_what_is_seen_nothing_is_predicted_that_has_no_room_there():
    one, double = sure(posed(0.0, z=2.0)), sure(posed(0.06, z=2.0, turn=1.0))
    detections = told([[one]] * 10 + [[one, double]] * 2 + [[one]] * 5)
    assert [len(found) for found in detections[12:]] == [1] * 5 and not any(d.predicted for d in detections[12])


@pytest.mark.parametrize("apart", [0.07, 0.13])
def test_neighbours_stay_two(apart):
    left, right = sure(posed(0.0, z=2.0)), sure(posed(apart, z=2.0))
    detections = told([[left, right]] * 10 + [[left]] + [[left, right]] * 3)
    assert [sorted(d.id for d in found) for found in detections] == [[0, 1]] * 14
    assert [sum(d.predicted for d in found) for found in detections[9:12]] == [0, 1, 0]


@pytest.mark.parametrize("shake", [0.05, 0.08])
def test_what_leaps_to_and_fro_by_up_to_its_size_is_itself(shake):
    """As where a near one is shaken with the camera more than a far one."""
    steady, shakes = sure(posed(0.4, z=2.0)), np.random.default_rng(4).uniform(-shake, shake, (60, 2))
    near = [sure(posed(-0.4 + 0.003 * k + x, y, z=2.0)) for k, (x, y) in enumerate(shakes.tolist())]
    detections = told([[one, steady] for one in near])
    assert {tuple(sorted((d.id, d.predicted) for d in found)) for found in detections} == {((0, False), (1, False))}


@pytest.mark.parametrize("apart", [0.13, 0.19])
def test_neighbours_that_come_and_go_keep_their_names(apart):
    """They are hidden by turns, and together: nobody takes another's place."""
    left, right, other = (sure(posed(x, z=2.0)) for x in (0.0, apart, -0.6))
    rng = np.random.default_rng(2)
    shown = [[d for d in (left, right) if rng.uniform() < 0.85] for _ in range(200)]
    for found, frame_ in zip(told([[left, right, other]] * 10 + [[*s, other] for s in shown])[10:], shown, strict=True):
        names = {round(d.pose.position[0], 2): d.id for d in found if not d.predicted}
        assert all(names[round(d.pose.position[0], 2)] == (0 if d is left else 1) for d in frame_)


def test_in_the_image_it_is_the_same():
    there, leapt = flat(200.0), flat(225.0)  # of 60 pixels
    ids = [[d.id for d in found] for found in told([[there]] * 10 + [[leapt], [there]])]
    assert ids == [[0]] * 12
