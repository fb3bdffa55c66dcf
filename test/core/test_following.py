"""What one frame knows helps the next: the same objects, found with less; and nothing that is not there."""

import dataclasses
import json
import time
from collections import Counter

import numpy as np
import pytest
from solids import BLUE, RED, camera_of, pose, render, truck

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig, SearchConfig
from artrec_ros.core.base.patience import Patience
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.memory.memory import Known
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.spatial_looks import SpatialLooks
from artrec_ros.io.results.journal import Recognised, _packed, _unpacked

CAMERA = camera_of()
TRUCK = truck()
STEP_NS = 33_000_000


def recognizer(**options):
    targets = [Target("red", TRUCK, RED), Target("blue", TRUCK, BLUE)]
    config = RecognizerConfig(**{"time_budget_ms": 600000.0, "threads": 1, **options})
    return Recognizer(targets, config, Segmenter(ImageConfig()))


ONE = recognizer()
recognizer_of_short_memory = recognizer(refresh_s=0.3)


@pytest.fixture
def looks(monkeypatch):
    """How often each kind of look was taken."""
    count = dict.fromkeys(("plain", "close"), 0)

    def counted(name, original):
        def look(self, *args):
            count[name] += 1
            return original(self, *args)

        return look

    for name in count:
        monkeypatch.setattr(SpatialLooks, name, counted(name, getattr(SpatialLooks, name)))
    return count


def driving(k):
    """A truck that drives and moves its legs, in frame k."""
    return pose(-0.2 + 0.006 * k, 0, 0.9 + 0.002 * k, 0.3, model=TRUCK, joints={"fore": 0.4 - 0.03 * k})


def picture(*trucks, label=RED):
    return render(CAMERA, [(TRUCK, at, label) for at in trucks])


CLUTTER = picture()
CLUTTER[20:30, 250:262] = RED  # too little of a truck


def written(result):
    """All of a result but its times."""
    return json.dumps(_packed(dataclasses.replace(result, timing_ms={})))


def play(images, step_ns=STEP_NS, recognise=ONE, camera=CAMERA):
    memory, results = None, []
    for k, image in enumerate(images):
        result, memory = recognise.follow(image, camera, k * step_ns, memory)
        results.append(result)
    return results, memory


def test_a_known_object_is_followed_without_another_look(looks):
    results, _ = play([picture(driving(k)) for k in range(8)])
    assert looks["plain"] <= 2 and not looks["close"]  # one frame's fit may stray
    for k, result in enumerate(results):
        (d,) = result.detections
        np.testing.assert_allclose(d.pose.position, driving(k).t[0], atol=0.02)
        assert d.joints["fore"] == pytest.approx(0.4 - 0.03 * k, abs=0.15)


def test_what_another_hides_in_part_is_followed_in_what_that_one_leaves(looks):
    def far(k):
        return pose(-0.08 + 0.004 * k, 0, 1.25, 0.3, model=TRUCK, joints={"fore": 0.2})

    def near(k):
        return pose(-0.16 + 0.002 * k, 0, 0.8, 0.3, model=TRUCK)

    images = [render(CAMERA, [(TRUCK, far(k), RED), (TRUCK, near(k), BLUE)]) for k in range(8)]
    results, _ = play(images)
    for k, result in enumerate(results):
        red, blue = sorted(result.detections, key=lambda d: -d.pose.position[2])
        assert (red.object, blue.object) == ("red", "blue")
        np.testing.assert_allclose(red.pose.position, far(k).t[0], atol=0.04)  # its deviation is up to 0.026
    # in the first frame, the half hidden one's blob in full, and when it is their turn again
    assert looks["plain"] <= 5 and looks["close"] <= 1


def test_doubt_is_paid_once_and_told_to_wait(looks):
    results, _ = play([np.where(CLUTTER == RED, RED, picture(driving(k))) for k in range(8)])
    assert looks["close"] <= 3  # soon once more, and then ever later
    assert [r.waiting for r in results[:2]] == [0, 1] and sum(r.waiting for r in results) >= 5
    assert [len(r.detections) for r in results] == [1] * 8


def impatient():
    """Who has just taken a long look, while newer images wait."""
    patience = Patience(lambda: True)
    patience.spent_on(lambda: time.sleep(1e-3), 1e-9)
    return patience


def test_while_newer_images_wait_doubt_waits_and_what_is_known_is_told(looks):
    images = [np.where(CLUTTER == RED, RED, picture(driving(k))) for k in range(5)]
    memory = None
    for k, image in enumerate(images[:4]):
        result, memory = ONE.follow(image, CAMERA, k * STEP_NS, memory, impatient())
        assert len(result.detections) == 1 and result.waiting == 1
    assert not looks["close"]
    ONE.follow(images[4], CAMERA, 4 * STEP_NS, memory)
    assert looks["close"] == 1  # what was put off is searched as soon as there is time


def test_what_few_guesses_show_is_told_where_a_closer_look_is_put_off(looks):
    doubtful = recognizer(search=SearchConfig(beyond_doubt=1.0))
    image = picture(driving(0))
    result, _ = doubtful.follow(image, CAMERA, 0, None, impatient())
    assert not looks["close"] and result.waiting
    (found,) = result.detections
    np.testing.assert_allclose(found.pose.position, driving(0).t[0], atol=0.03)


def test_who_is_always_late_looks_at_all_that_is_in_doubt_in_turn(monkeypatch):
    now_s, seen = [0.0], Counter()
    monkeypatch.setattr(time, "monotonic", lambda: now_s[0])

    def thorough(self, frame, finder, blob):
        seen[round(blob.area_px)] += 1
        now_s[0] += 0.06
        return finder.surface.no_poses

    monkeypatch.setattr(SpatialLooks, "thorough", thorough)
    image, memory, late = picture(driving(0)), None, Patience(lambda: True)
    for n in range(4):
        image[10:22, 30 + 60 * n : 40 + 61 * n] = RED  # the last one is the largest
    for _ in range(100):
        result, memory = ONE.follow(image, CAMERA, round(now_s[0] * 1e9), memory, late)
        assert len(result.detections) == 1
        now_s[0] += STEP_NS * 1e-9
    assert len(seen) == 4 and max(seen.values()) - min(seen.values()) <= 2
    assert sum(seen.values()) * 0.06 < 0.3 * now_s[0]


def test_the_place_of_a_known_object_is_searched_again_when_there_is_time(looks):
    images = [picture(driving(0))] * 16
    memory, looked = None, []
    for k, image in enumerate(images):
        looks.update(plain=0)
        who = impatient() if k < 12 else None
        _, memory = recognizer_of_short_memory.follow(image, CAMERA, k * STEP_NS, memory, who)
        looked.append(looks["plain"])
    assert sum(looked[1:12]) == 0 and sum(looked[12:]) >= 1


def test_everything_is_searched_again_within_the_time_given(looks):
    play([CLUTTER] * 12, recognise=recognizer(refresh_s=0.2))
    assert 2 <= looks["close"] <= 4


def test_what_comes_is_found_at_once_and_what_goes_is_gone_at_once():
    empty, there = picture(), picture(driving(0))
    results, _ = play([empty, there, there, empty, there])
    assert [len(r.detections) for r in results] == [0, 1, 1, 0, 1]


def test_what_was_put_elsewhere_is_found_there():
    places = [driving(0), driving(0), pose(0.2, 0.1, 1.1, np.pi, model=TRUCK), driving(40)]
    results, _ = play([picture(at) for at in places])
    for at, result in zip(places, results, strict=True):
        (d,) = result.detections
        np.testing.assert_allclose(d.pose.position, at.t[0], atol=0.03)


def test_frames_in_any_order_are_judged_as_if_each_were_alone():
    scenes = [picture(driving(k), pose(0.2, 0.1, 1.1, 0.5 * k, model=TRUCK)) for k in range(0, 24, 4)]
    order = np.random.default_rng(3).permutation(len(scenes))
    results, _ = play([scenes[k] for k in order])
    for k, result in zip(order, results, strict=True):
        alone = ONE.recognize(scenes[k], CAMERA)
        assert len(result.detections) == len(alone.detections) == 2
        for d in alone.detections:
            off = min(np.linalg.norm(e.pose.position - d.pose.position) for e in result.detections)
            assert off < 0.02


def test_results_do_not_depend_on_the_number_of_threads():
    images = [np.where(CLUTTER == RED, RED, picture(driving(k), pose(0.2, 0.1, 1.1, 2, model=TRUCK))) for k in range(4)]
    (one, _), (three, _) = (play(images, recognise=recognizer(threads=n)) for n in (1, 3))
    for a, b in zip(one, three, strict=True):
        assert written(a) == written(b)


def test_a_memory_is_a_value_that_can_be_kept_in_a_file():
    images = [picture(driving(k)) for k in range(4)]
    (*_, last), _ = play(images)
    _, memory = play(images[:3])
    kept = Recognised(0, "", memory=memory)
    read = _unpacked(json.loads(json.dumps(_packed(kept)))).memory
    again, _ = ONE.follow(images[3], CAMERA, 3 * STEP_NS, read)
    assert written(again) == written(last)


def test_switched_off_nothing_is_remembered(looks):
    results, memory = play([picture(driving(k)) for k in range(3)], recognise=recognizer(memory=False))
    assert memory is None and looks["plain"] == 3
    assert [len(r.detections) for r in results] == [1] * 3


@pytest.mark.parametrize("change", ["clock", "camera", "size"])
def test_another_view_is_begun_anew(change, looks):
    image, camera = picture(driving(0)), CAMERA
    _, memory = ONE.follow(image, camera, 10**9, None)
    stamp = 10**9 + STEP_NS
    if change == "clock":
        stamp = 5 * 10**8
    elif change == "camera":
        camera = dataclasses.replace(CAMERA, matrix=CAMERA.matrix * [[1.01], [1.01], [1]])
    else:
        image = np.pad(image, ((0, 20), (0, 0)))
    looks.update(plain=0)
    result, _ = ONE.follow(image, camera, stamp, memory)
    assert looks["plain"] == 1 and len(result.detections) == 1


@pytest.mark.parametrize("nearer", [1.0, 0.985])
def test_the_place_of_a_known_object_is_searched_again_in_time_however_it_grows(nearer, looks):
    images = [picture(pose(0, 0, 1.3 * nearer**k, 0.3, model=TRUCK)) for k in range(32)]
    looked = []
    memory = None
    for k, image in enumerate(images):
        looks.update(plain=0)
        result, memory = recognizer_of_short_memory.follow(image, CAMERA, k * STEP_NS, memory)
        assert len(result.detections) == 1
        looked.append(looks["plain"])
    times = np.flatnonzero(looked) * STEP_NS * 1e-9
    assert np.diff(times).max() <= 0.3 + 1e-9 and len(times) < 16


def test_what_the_clock_cuts_short_is_searched_in_the_next_frame(monkeypatch):
    image, over = picture(driving(0)), [True]
    original = SpatialLooks.plain

    def cut(self, frame, finder, blob):
        if over[0]:
            monkeypatch.setattr(type(frame.deadline), "expired", property(lambda self: over[0]))
            return finder.surface.no_poses
        return original(self, frame, finder, blob)

    monkeypatch.setattr(SpatialLooks, "plain", cut)
    result, memory = ONE.follow(image, CAMERA, 0, None)
    assert not result.detections
    over[0] = False
    result, _ = ONE.follow(image, CAMERA, STEP_NS, memory)
    assert len(result.detections) == 1


def test_time_that_is_over_is_no_other_scene(monkeypatch):
    images = [np.where(CLUTTER == RED, RED, picture(driving(k))) for k in range(3)]
    _, memory = play(images[:2])
    known = sum(len(looks) for looks in memory.looks.values())
    original, over = SpatialLooks.follow, [True]

    def slow(self, frame, *args):
        monkeypatch.setattr(type(frame.deadline), "expired", property(lambda self: over[0]))
        return original(self, frame, *args)

    monkeypatch.setattr(SpatialLooks, "follow", slow)
    _, memory = ONE.follow(images[2], CAMERA, 2 * STEP_NS, memory)
    over[0] = False
    assert sum(len(looks) for looks in memory.looks.values()) >= known - 1


def test_no_known_object_is_begun_with_when_time_is_over(monkeypatch):
    images = [picture(driving(k)) for k in range(3)]
    _, memory = play(images[:2])
    (one,) = memory.known["red"]
    crowd = dataclasses.replace(memory, known={"red": tuple(dataclasses.replace(one) for _ in range(9)), "blue": ()})
    original, begun = SpatialLooks.follow, []

    def slow(self, frame, *args):
        begun.append(frame)
        monkeypatch.setattr(type(frame.deadline), "expired", property(lambda self: len(begun) > 2))
        return original(self, frame, *args)

    monkeypatch.setattr(SpatialLooks, "follow", slow)
    _, memory = ONE.follow(images[2], CAMERA, 2 * STEP_NS, crowd)
    assert len(begun) == 3 and memory.known["red"]


def test_a_joint_that_turns_without_limit_goes_the_short_way():
    q = Poses(np.eye(3)[None], np.zeros((1, 3)), np.array([[3.1, 0.1]]))
    seen = Known.first(q, 0.0, 1.0)
    later = Poses(q.R, q.t, np.array([[-3.1, 0.3]]))
    endless = np.array([True, False])
    bend = seen.then(later, 0.1, 1.0, 0.0, endless, steadiness=0.0).bend
    np.testing.assert_allclose(bend, [(2 * np.pi - 6.2) / 0.1, 2.0])


def test_frames_whose_stamps_stand_still_have_a_clock_too():
    results, memory = play([picture(driving(k)) for k in range(5)], step_ns=0)
    assert [len(r.detections) for r in results] == [1] * 5
    assert memory.clock_s == pytest.approx(4 / 30)
