"""Which way round a flat object lies of which a lone part that looks the same after half a turn is seen, over time."""

from dataclasses import replace

import numpy as np
import pytest
from test_tracking import PERIOD, START, frame

from artrec_ros.core.base.config import TrackingConfig
from artrec_ros.core.geometry.transforms import wrap_angle
from artrec_ros.core.model.found import Detection, ImagePose, Instance, Missing, OtherPlace
from artrec_ros.core.tracking.tracker import Tracker

TURN, OTHERS = 0.6, 0.2  # direction; probability of the other one where nothing but the tape is seen


def part(name, x, theta):
    return Instance(name, name, 0.95, x, 100.0, theta, 300.0)


def whole(theta=TURN, x=200.0):
    return Detection(
        "tool", 0, 0.97, ImagePose(x, 100.0, theta, 300.0), (part("tape", x, theta), part("tail", x, theta))
    )


def lone(theta, x=200.0, others=OTHERS):
    """Told in a direction, with the other one beside it."""

    def one(way):
        tail = Missing("tail", "not seen", x + 50 * np.cos(way), 100 + 50 * np.sin(way))
        return Detection("tool", 0, 0.95, ImagePose(x, 100.0, way, 300.0), (part("tape", x, way),), missing=(tail,))

    there = one(float(wrap_angle(theta + np.pi)))
    place = OtherPlace(there.image, others, there)
    return replace(one(theta), score=0.95 * (1 - others), as_told=1 - others, other_place=place)


def told(frames, period=PERIOD):
    tracker = Tracker(TrackingConfig())
    return [tracker.update(START + k * period, frame(d)).detections[0] for k, d in enumerate(frames)]


def is_at(d, theta):
    return np.cos(d.image.theta - theta) > 0.99


@pytest.mark.parametrize("flipped", [True, False])
def test_what_was_seen_before_tells_which_way_a_lone_part_lies(flipped):
    out = told([whole()] * 10 + [lone(TURN + np.pi * flipped)] * 10)
    assert all(is_at(d, TURN) for d in out)
    last = out[-1]
    assert [c.component for c in last.components] == ["tape"] and np.cos(last.components[0].theta - TURN) > 0.99
    (tail,) = last.missing
    assert tail.x == pytest.approx(200 + 50 * np.cos(TURN)) and tail.y == pytest.approx(100 + 50 * np.sin(TURN))
    assert last.as_told > 0.95 and last.score > 0.9 and last.id == out[0].id
    assert last.other_place.probability < 0.05 and np.cos(last.other_place.image.theta - TURN) < -0.99


def test_a_lone_part_says_no_more_in_many_frames_than_in_one():
    """What hides the other one hides it from all alike."""
    out = told([lone(TURN)] * 60)
    assert all(d.as_told == pytest.approx(1 - OTHERS, abs=0.02) for d in out)
    assert out[-1].score < 0.81


def test_frames_that_tell_a_lone_part_now_so_now_otherwise_do_not_turn_it():
    out = told([lone(TURN + np.pi * (k % 3 == 1)) for k in range(30)])
    assert all(is_at(d, TURN) for d in out)


def test_what_is_seen_at_last_counts():
    out = told([lone(TURN + np.pi)] * 10 + [whole()] * 5 + [lone(TURN + np.pi)] * 5)
    assert is_at(out[0], TURN + np.pi) and all(is_at(d, TURN) for d in out[10:])


def test_it_follows_a_tool_that_turns():
    ways = TURN + 0.03 * np.arange(40)
    out = told([whole(ways[0])] + [lone(way + np.pi * (k % 2)) for k, way in enumerate(ways[1:].tolist())])
    assert all(is_at(d, way) for d, way in zip(out, ways, strict=True))


def test_after_a_long_time_a_lone_part_speaks_for_itself():
    tracker = Tracker(TrackingConfig(max_gap_s=100.0))
    tracker.update(START, frame(whole()))
    (now,) = tracker.update(START + 30 * 10**9, frame(lone(TURN + np.pi))).detections
    assert is_at(now, TURN + np.pi) and now.as_told == pytest.approx(1 - OTHERS)


def test_one_that_may_lie_in_many_ways_says_nothing_of_two():
    square = replace(lone(TURN + np.pi), other_place=OtherPlace(lone(TURN).image, 0.3))
    out = told([whole()] * 3 + [square] * 20)
    assert all(d.as_told == 1 - OTHERS and is_at(d, TURN + np.pi) for d in out[3:])  # as each image tells it
    out = told([square] * 30 + [lone(TURN)])
    assert is_at(out[-1], TURN) and out[-1].as_told == pytest.approx(1 - OTHERS)
