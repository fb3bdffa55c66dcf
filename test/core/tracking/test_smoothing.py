"""Filtered poses and joints, and speeds, as the tracker tells them."""

from dataclasses import replace

import numpy as np
import pytest
from test_tracking import COVARIANCE, PERIOD, START, flat, frame, posed

from artrec_ros.core.base.config import RecognizerConfig, TrackingConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.tracking.tracker import Tracker

SMOOTH = TrackingConfig(smooth=True)


def walked(config, frames=90, speed=0.2, rate=1.0, seed=0):
    """Noisy detections of one that walks along x and swings a joint, and the truth: (x, joint)."""
    rng, tracker = np.random.default_rng(seed), Tracker(config)
    for k in range(frames):
        x, q = speed * k / 30, rate * k / 30
        e = rng.normal(size=6) * np.sqrt(np.diag(COVARIANCE))
        d = posed(x + e[0], e[1], 1.0 + e[2], turn=e[4])
        d = replace(d, score=0.99, joints={"arm": q + rng.normal(0, 0.02)}, joint_deviations={"arm": 0.02})
        yield tracker.update(START + k * PERIOD, frame(d)).detections[0], (x, q)


def test_raw_poses_stay_and_filtered_ones_stand_beside():
    plain = [d for d, _ in walked(TrackingConfig())]
    smooth = [d for d, _ in walked(SMOOTH)]
    assert all(d.filtered is None and d.told_pose is d.pose for d in plain)
    for one, other in zip(plain, smooth, strict=True):
        np.testing.assert_array_equal(one.pose.position, other.pose.position)
        assert other.told_pose is other.filtered.pose and one.joints == other.joints


def test_filtered_poses_are_nearer_the_truth_and_steadier():
    told = list(walked(SMOOTH))[30:]
    truth = np.array([[x, 0, 1.0] for _, (x, _) in told])
    raw = np.array([d.pose.position for d, _ in told]) - truth
    filtered = np.array([d.filtered.pose.position for d, _ in told]) - truth
    assert np.sqrt((filtered**2).sum(axis=1).mean()) < 0.8 * np.sqrt((raw**2).sum(axis=1).mean())
    steps = [np.linalg.norm(np.diff(e, axis=0), axis=1) for e in (raw, filtered)]
    assert np.median(steps[1]) < 0.45 * np.median(steps[0])


def test_the_told_covariance_holds():
    far = []
    for seed in range(20):
        for d, (x, _) in list(walked(SMOOTH, 60, seed=seed))[30:]:
            error = d.filtered.pose.position - (x, 0, 1.0)
            far.append(error @ np.linalg.solve(d.filtered.covariance[:3, :3], error))
    assert 2.0 < np.mean(far) < 4.0  # 3


@pytest.mark.parametrize("config", [TrackingConfig(), SMOOTH])
def test_speeds_are_told_from_the_second_sighting_on(config):
    told = list(walked(config))
    assert told[0][0].motion is None and told[1][0].motion is not None
    rates = np.mean([[*d.motion.twist[:3], d.motion.joints["arm"]] for d, _ in told[45:]], axis=0)
    np.testing.assert_allclose(rates, [0.2, 0, 0, 1.0], atol=0.1)


def test_filtered_and_predicted_joints_stay_within_their_limits():
    """One comes to its limit and stays, the other turns round and round."""
    square = np.array([[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]])
    marker = Marker("m", square, np.zeros(2), np.array([0.1, 0]), None, Pose.identity())
    joints = {"lid": (-1.0, 1.0), "wheel": (-np.pi, np.pi)}
    parts = [
        Component(n, (marker,), joint=Joint("base", Pose.identity(), np.array([0, 0, 1.0]), *ends))
        for n, ends in joints.items()
    ]
    model = ObjectModel("thing", (Component("base", (marker,), required=True), *parts))
    name = posed(0.0).object
    tracker = Tracker(replace(SMOOTH, predict=0.5), [Target(name, model, 1)])
    told = []
    for k in range(40):
        q = {"lid": min(-1 + 0.1 * k, 1.0), "wheel": (0.5 * k + np.pi) % (2 * np.pi) - np.pi}
        d = replace(posed(0.0), score=0.99, joints=q, joint_deviations=dict.fromkeys(q, 0.02))
        seen = frame(d) if k < 30 else frame()
        told += [(k, other) for other in tracker.update(START + k * PERIOD, seen).detections]
    assert any(d.predicted for _, d in told)
    for k, d in told:
        for n, (low, high) in joints.items():
            assert low <= d.told_joints[n] <= high
        if 10 < k < 30:
            off = np.angle(np.exp(1j * (d.told_joints["wheel"] - d.joints["wheel"])))
            assert abs(off) < 0.3


def test_a_sudden_start_is_followed():
    """At rest for two seconds, then off at once: the filter is soon no worse than what it is fed with."""
    rng, tracker, off = np.random.default_rng(1), Tracker(SMOOTH), []
    for k in range(90):
        x = max(0, k - 60) * 0.6 / 30
        e = rng.normal(size=3) * 0.005
        d = replace(posed(x + e[0], e[1], 1 + e[2]), score=0.99)
        found = tracker.update(START + k * PERIOD, frame(d)).detections[0]
        off.append(found.filtered.pose.position[0] - x)
    assert np.abs(off[60:]).max() < 0.03 and np.sqrt(np.mean(np.square(off[70:]))) < 0.005


def test_a_mirrored_turn_of_one_frame_moves_nothing():
    tracker = Tracker(SMOOTH)
    for k in range(20):
        d = replace(posed(0.0, turn=1.2 if k == 15 else 0.0), score=0.99)
        (found,) = tracker.update(START + k * PERIOD, frame(d)).detections
        np.testing.assert_allclose(found.filtered.pose.rotation, np.eye(3), atol=0.02)


def test_one_that_stays_turned_is_believed():
    tracker = Tracker(SMOOTH)
    for k in range(25):
        d = replace(posed(0.0, turn=1.2 if k >= 15 else 0.0), score=0.99)
        (found,) = tracker.update(START + k * PERIOD, frame(d)).detections
    np.testing.assert_allclose(found.filtered.pose.rotation, found.pose.rotation, atol=0.02)


def test_what_has_no_pose_of_its_own_has_no_motion():
    tracker = Tracker(SMOOTH)
    for k in range(5):
        by_size = replace(posed(0.3), pose_from="size", score=0.99)
        found = tracker.update(START + k * PERIOD, frame(replace(flat(100), score=0.99), by_size)).detections
    assert all(d.motion is None and d.filtered is None for d in found)


def test_what_moves_on_a_plane_has_speeds_and_a_filtered_pose_in_the_planes_frame():
    """Though its place there says nothing of how far it is from the camera: here it passes the plane's origin."""
    rng, tracker = np.random.default_rng(4), Tracker(replace(SMOOTH, predict=0.5))
    covariance = np.diag([1e-3, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2]) ** 2
    for k in range(60):
        x, y = 0.9 * (k - 30) / 30, 0.3 * (k - 30) / 30
        d = replace(posed(x), pose_from="plane", frame_id="field", score=0.99, pose_covariance=covariance)
        pose = replace(d.pose, position=np.array([x, y, 0.0]) + rng.normal(0, 1e-3, 3) * (1, 1, 0))
        (found,) = tracker.update(START + k * PERIOD, frame(replace(d, pose=pose))).detections
    assert (found.id, found.frame_id) == (0, "field")
    np.testing.assert_allclose(found.motion.twist[:3], (0.9, 0.3, 0), atol=0.1)
    np.testing.assert_allclose(found.filtered.pose.position, (x, y, 0), atol=3e-3)
    (expected,) = tracker.update(START + 60 * PERIOD, frame()).detections
    assert expected.predicted and (expected.frame_id, expected.pose_from) == ("field", "plane")
    np.testing.assert_allclose(expected.pose.position, (0.9, 0.3, 0), atol=1e-2)


def test_where_poses_come_in_another_frame_the_filter_begins_anew():
    tracker = Tracker(SMOOTH)
    for n in range(10):
        before = replace(posed(0.3), score=0.99)
        tracker.update(START + n * PERIOD, frame(before))
    on_plane = replace(posed(0.3), pose_from="plane", frame_id="field", score=0.99)
    pose = replace(on_plane.pose, position=np.array([0.1, -0.2, 0.0]))
    (found,) = tracker.update(START + 10 * PERIOD, frame(replace(on_plane, pose=pose))).detections
    assert found.id == 0 and found.motion is None
    np.testing.assert_allclose(found.filtered.pose.position, (0.1, -0.2, 0), atol=1e-9)


def test_a_late_frame_moves_nothing():
    """It shows what was a while ago: taken for now, what goes forward would go back."""
    steps = [replace(posed(0.02 * k), score=0.99, pose_covariance=np.eye(6) * 1e-6) for k in range(20)]
    plain, late = Tracker(SMOOTH), Tracker(SMOOTH)
    for k, step in enumerate(steps):
        expected = plain.update(START + k * PERIOD, frame(step)).detections[0]
        if k == 15:
            before = late.update(START + 12 * PERIOD, frame(steps[12])).detections[0]
            assert before.id == expected.id and before.pose is steps[12].pose
        found = late.update(START + k * PERIOD, frame(step)).detections[0]
        np.testing.assert_array_equal(found.filtered.pose.position, expected.filtered.pose.position)
    assert found.motion.twist[0] == pytest.approx(0.6, abs=0.05)


def test_of_what_was_seen_once_no_speed_is_predicted():
    tracker = Tracker(replace(SMOOTH, predict=1.0))
    tracker.update(START, frame(replace(posed(0.0), score=0.99)))
    (expected,) = tracker.update(START + PERIOD, frame()).detections
    assert expected.predicted and expected.motion is None


def test_an_object_that_was_put_elsewhere_may_be_in_either_place_until_that_is_known():
    tracker = Tracker(SMOOTH)
    there = replace(
        posed(0.0), score=0.99, pose_covariance=np.eye(6) * 1e-6, joints={"arm": 0.0}, joint_deviations={"arm": 0.01}
    )
    elsewhere = replace(there, pose=Pose(there.pose.rotation, np.array([0.0, 0.0, 1.3])), joints={"arm": 1.0})
    for k in range(20):
        tracker.update(START + k * PERIOD, frame(there))
    told = [tracker.update(START + k * PERIOD, frame(elsewhere)).detections[0].filtered for k in range(20, 26)]
    off = np.array([f.pose.position - elsewhere.pose.position for f in told])
    deviations = np.sqrt([np.trace(f.covariance[:3, :3]) for f in told])
    assert off[0, 2] == pytest.approx(-0.3, abs=0.01) and (np.linalg.norm(off, axis=1) < 2 * deviations).all()
    joints = [(f.joints["arm"] - 1.0, f.joint_deviations["arm"]) for f in told]
    assert all(abs(error) < 3 * deviation for error, deviation in joints)
    assert abs(off[-1, 2]) < 0.01 and abs(joints[-1][0]) < 0.02


def test_a_clock_that_is_set_back_stops_nothing():
    """One frame out of order, or two, are late; where all that come are, time goes on from there."""
    tracker, found = Tracker(SMOOTH), []
    for k in range(20):
        tracker.update(START + k * PERIOD, frame(replace(posed(0.02 * k), score=0.99)))
    for k in range(20, 40):
        found += tracker.update(START + (k - 12) * PERIOD, frame(replace(posed(0.02 * k), score=0.99))).detections
    assert {d.id for d in found} == {0} and not any(d.predicted for d in found)
    assert found[-1].motion.twist[0] == pytest.approx(0.6, abs=0.1)


def test_a_number_that_a_late_frame_gave_is_nobody_elses():
    tracker = Tracker(TrackingConfig(), recognizer=RecognizerConfig(memory=False))
    both = [replace(posed(x), score=0.99) for x in (-0.5, 0.5)]
    for k in range(10):
        tracker.update(START + k * PERIOD, frame(*both))
    late = tracker.update(START + 5 * PERIOD, frame(*both, replace(posed(0.0, y=0.4), score=0.99))).detections
    after = tracker.update(START + 10 * PERIOD, frame(*both, replace(posed(0.0, y=-0.4), score=0.99))).detections
    assert late[2].id == 2 and after[2].id == 3
