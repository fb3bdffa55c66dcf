"""Names that stay: missed frames, crossings, clutter, resets."""

from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.base.config import TrackingConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.found import Detection, ImagePose
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.core.tracking.tracker import Tracker

START, PERIOD = 1_700_000_000_000_000_000, 33_333_333
COVARIANCE = np.diag([0.005, 0.005, 0.015, 0.05, 0.05, 0.05]) ** 2


def posed(x, y=0.0, z=1.0, name="red", turn=0.0):
    R = rotation_from_rotvec([0.0, turn, 0.0])
    image = ImagePose(300 * x / z + 320, 300 * y / z + 240, 0.0, 300 / z)
    return Detection(name, 0, 0.9, image, (), Pose(R, np.array([x, y, z])), {}, COVARIANCE)


def flat(x, y=0.0, scale=300.0, theta=0.0, name="red"):
    return Detection(name, 0, 0.9, ImagePose(x, y, theta, scale), ())


def frame(*detections, size=(640, 480)):
    return FrameResult(size, tuple(replace(d, id=n) for n, d in enumerate(detections)))


def ids(tracker, frames, start=START, period=PERIOD):
    """The ids of each frame's detections in their order."""
    return [
        [d.id for d in tracker.update(start + k * period, frame(*detections)).detections]
        for k, detections in enumerate(frames)
    ]


def ids_among_others(frames, names=("red",)):
    """The same where two of each name were seen at once, two seconds ago."""
    before = [[posed(x, z=3.0, name=name) for x in (-1, 1) for name in names], *[[]] * 60]
    return ids(Tracker(TrackingConfig()), [*before, *frames])[len(before) :]


def test_order_does_not_matter():
    a, b = posed(-0.3), posed(0.3)
    assert ids(Tracker(TrackingConfig()), [[a, b], [b, a], [a, b], [b, a]]) == [[0, 1], [1, 0], [0, 1], [1, 0]]


def test_names_count_for_each_object_alone():
    assert ids(Tracker(TrackingConfig()), [[posed(0, name="red"), posed(0.01, name="blue")]]) == [[0, 0]]
    swapped = [[posed(0, name="red"), posed(0.5, name="blue")], [posed(0.5, name="red"), posed(0, name="blue")]]
    assert ids_among_others(swapped, ("red", "blue"))[1] == [1, 1]  # another object where one was is not that one


@pytest.mark.parametrize("make", [lambda x: posed(x), lambda x: flat(300 * x)])
def test_missed_frames_are_survived(make):
    seen = [[make(0.01 * k)] for k in range(10)] + [[]] * 8 + [[make(0.01 * k)] for k in range(18, 25)]
    assert {i for found in ids(Tracker(TrackingConfig()), seen) for i in found} == {0}


@pytest.mark.parametrize("gap_frames, number", [(28, 0), (31, 2)])
def test_who_was_away_too_long_is_somebody_else(gap_frames, number):
    sure = replace(posed(0.0, z=2.0), score=0.99)
    seen = [*[[sure]] * 20, *[[]] * gap_frames, [sure]]
    beside = [[*found, posed(-1.0, z=2.0)] for found in seen]
    beside[-1].insert(0, posed(1.0, z=2.0))  # a newcomer takes the first id that is free
    assert ids(Tracker(TrackingConfig(max_gap_s=1.0)), beside)[-1] == ([2, 0, 1] if number == 0 else [0, 2, 1])


@pytest.mark.parametrize("gap_frames, number", [(2, 0), (5, 1)])
def test_what_was_seen_once_is_soon_forgotten(gap_frames, number):
    assert ids_among_others([[posed(0.0)], *[[]] * gap_frames, [posed(0.0)]])[-1] == [number]


@pytest.mark.parametrize("depth", [1.0, 1.1])
def test_objects_that_cross_keep_their_names(depth):
    """At 0.45 m/s each, at one range and one behind the other."""
    seen = [[posed(0.015 * (k - 20)), posed(-0.015 * (k - 20.4), z=depth)] for k in range(41)]
    assert ids(Tracker(TrackingConfig()), seen) == [[0, 1]] * 41


def test_objects_that_cross_in_the_image_keep_their_names():
    seen = [[flat(5 * (k - 20)), flat(-5 * (k - 20.4))] for k in range(41)]
    assert ids(Tracker(TrackingConfig()), seen) == [[0, 1]] * 41


def test_a_lost_object_lends_its_name_to_nobody():
    seen = [[posed(-0.3), posed(0.3)]] * 5 + [[posed(-0.3)]] * 2 + [[posed(-0.3), posed(0.3, z=2.0)]] * 3
    assert ids(Tracker(TrackingConfig()), seen)[-1] == [0, 2]


def test_the_one_seen_just_now_goes_before_the_one_lost_long_ago():
    """Of a lost object little is known, so it could be anywhere: that makes it no likelier."""
    seen = [[posed(0.0), posed(0.15)]] * 3 + [[posed(0.15)]] * 20 + [[posed(0.13)]]
    assert ids(Tracker(TrackingConfig()), seen)[-1] == [1]


def test_false_detections_take_no_name_along():
    rng = np.random.default_rng(0)
    seen = [[posed(0.005 * k), posed(*rng.uniform((-1, -0.8, 1.5), (1, 0.8, 3)))] for k in range(60)]
    found = ids(Tracker(TrackingConfig()), seen)
    assert {f[0] for f in found} == {0}
    assert all(f[1] != 0 for f in found)


def test_a_mirrored_turn_costs_no_name():
    seen = [[posed(0.0, turn=1.2 if k % 4 == 3 else 0.0)] for k in range(20)]
    assert ids(Tracker(TrackingConfig()), seen) == [[0]] * 20


def test_turn_tells_two_apart_where_places_do_not():
    a, b = posed(0.0, turn=0.0), posed(0.03, turn=1.5)
    later = posed(0.015, turn=1.5), posed(0.015, turn=0.0)
    assert ids(Tracker(TrackingConfig()), [[a, b], [*later]])[1] == [1, 0]


@pytest.mark.parametrize("make", [lambda x, y: posed(x, y), lambda x, y: flat(300 * x, 300 * y)])
def test_scenes_that_have_nothing_to_do_with_each_other(make):
    """Seconds apart nothing is carried on; at a camera's rate only what happens to lie near, and ids stay few."""
    rng = np.random.default_rng(1)
    seen = [[make(*rng.uniform((-0.8, -0.6), (0.8, 0.6)))] for _ in range(100)]
    found = [i for (i,) in ids_among_others(seen)]
    assert len(set(found[:30])) > 20 and max(found) <= 31
    pairs = [[a, b] for (a,), (b,) in zip(seen, reversed(seen), strict=True)]
    assert {tuple(sorted(f)) for f in ids(Tracker(TrackingConfig()), pairs, period=2 * 10**9)} == {(0, 1)}


@pytest.mark.parametrize("period", [PERIOD, 2 * 10**9])
@pytest.mark.parametrize("make", [lambda x, y: posed(x, y), lambda x, y: flat(300 * x, 300 * y)])
def test_one_of_a_name_is_number_0_however_it_moves(make, period):
    rng = np.random.default_rng(2)
    seen = [[make(*rng.uniform((-0.8, -0.6), (0.8, 0.6)))] * (k % 5 > 0) for k in range(100)]
    assert {i for found in ids(Tracker(TrackingConfig()), seen, period=period) for i in found} == {0}


def test_a_second_one_ends_that_and_takes_no_id_from_the_first():
    alone = [[posed(0.0)]] * 5
    together = [[posed(0.0), posed(0.6, z=2.0)]] * 5
    assert ids(Tracker(TrackingConfig()), [*alone, *together, [posed(-0.9, z=3.0)]])[4:] == [[0], *[[0, 1]] * 5, [2]]


def test_an_id_is_free_when_its_holder_is_long_gone_and_not_before():
    steady, lost = posed(0.5), posed(-0.5)
    for gap_frames, number in ((20, 2), (31, 0)):
        seen = [*[[lost, steady]] * 9, *[[steady]] * gap_frames, [steady, posed(-0.5, z=3.0)]]
        assert ids(Tracker(TrackingConfig()), seen)[-1] == [1, number]


def test_ids_stay_few_for_ever():
    rng = np.random.default_rng(3)
    seen = [[posed(*rng.uniform((-0.8, -0.6), (0.8, 0.6))) for _ in range(2)] for _ in range(400)]
    assert max(i for found in ids(Tracker(TrackingConfig()), seen) for i in found) <= 2 * 31


def test_what_is_played_again_is_named_as_it_was():
    tracker, frames = Tracker(TrackingConfig()), [[posed(0.4)], *[[posed(0.0), posed(0.4)]] * 60]
    first = ids(tracker, frames)
    assert first[0] == [0] and first[-1] == [1, 0]
    assert ids(tracker, frames) == first


@pytest.mark.parametrize(
    ("other", "named"),
    [
        ({"result": frame(posed(0.0), size=(320, 240))}, [2]),
        ({"frame_id": "rear"}, [2, 3]),
        ({"stamp_ns": START - 2 * 10**9}, [0, 1]),
    ],
)
def test_another_view_or_an_earlier_clock_forgets(other, named):
    tracker = Tracker(TrackingConfig())
    usual = {"stamp_ns": START, "result": frame(posed(0.0), posed(0.4)), "frame_id": "front"}
    tracker.update(**usual)
    assert [d.id for d in tracker.update(**{**usual, **other}).detections] == named


def test_a_frame_out_of_order_costs_no_name():
    tracker, found = Tracker(TrackingConfig()), frame(posed(0.0), posed(0.4))
    for ms in (0, 33, 66, 53, 100):  # transports that lose frames may exchange two
        assert [d.id for d in tracker.update(START + ms * 10**6, found).detections] == [0, 1]


def test_a_frame_whose_name_comes_late_is_no_other():
    tracker = Tracker(TrackingConfig())
    found = [tracker.update(START, frame(posed(0.0)), name).detections[0].id for name in ("", "front", "", "front")]
    assert found == [0] * 4


def test_calibration_that_comes_or_goes_costs_no_name():
    bare = replace(posed(0.0), pose=None, pose_covariance=None)
    assert ids(Tracker(TrackingConfig()), [[bare], [bare], [posed(0.0)], [posed(0.0)], [bare]]) == [[0]] * 5


@pytest.mark.parametrize("stamp", [0, START])
def test_without_a_clock_frames_still_follow_each_other(stamp):
    seen = [[posed(0.01 * k)] for k in range(20)]
    assert ids(Tracker(TrackingConfig()), seen, start=stamp, period=0) == [[0]] * 20


def test_switched_off_ids_are_the_recognisers():
    tracker = Tracker(TrackingConfig(enabled=False))
    assert ids(tracker, [[posed(0.0), posed(0.3)], [posed(0.3)]]) == [[0, 1], [0]]


def test_switched_on_again_it_starts_anew():
    tracker = Tracker(TrackingConfig())
    ids(tracker, [[posed(0.0), posed(0.4)]])
    tracker.configure(TrackingConfig(enabled=False))
    tracker.configure(TrackingConfig())
    assert ids(tracker, [[posed(0.0), posed(0.4)]], start=START + PERIOD) == [[2, 3]]


def test_everything_else_of_a_result_stays():
    given = replace(frame(posed(0.0)), timing_ms={"total": 3.0}, ended_by=("recognizer.time_budget_ms",))
    got = Tracker(TrackingConfig()).update(START, given)
    assert got == given  # the first id is 0


@pytest.mark.parametrize("detection", [posed(0.0, z=1e-9), posed(0.0, z=-1.0), flat(0.0, scale=0.0), flat(1e9)])
def test_degenerate_detections_are_borne(detection):
    found = ids(Tracker(TrackingConfig()), [[detection]] * 3)
    assert all(np.isfinite(i) for (i,) in found)


@pytest.mark.parametrize("bad", [{"max_gap_s": -1.0}, {"steady_s": 0.0}, {"newcomer_odds": 0.0}])
def test_bad_parameters_are_refused(bad):
    with pytest.raises(ConfigError, match=f"tracking.{next(iter(bad))}"):
        TrackingConfig(**bad)


def test_what_is_placed_by_its_size_is_followed_in_the_image():
    """Its distance follows from a few pixels: a pose by size must cost nobody the name."""
    rng = np.random.default_rng(0)

    def noisy(x):
        d = flat(300 * x + 320, 240, 300 * rng.normal(1, 0.2))
        far = Pose(np.diag([1.0, -1, -1]), np.array([x, 0, 1]) * 300 / d.image.scale)
        return replace(d, pose=far, pose_covariance=COVARIANCE, pose_from="size")

    frames = [[noisy(-0.1 + 0.005 * k), noisy(0.1 - 0.005 * k)] for k in range(12)]
    with_poses = ids(Tracker(TrackingConfig()), frames)
    assert with_poses == ids(Tracker(TrackingConfig()), [[replace(d, pose=None) for d in f] for f in frames])
