"""What one frame shows of what faces the camera helps the next: the same objects, and nothing that is not there."""

import dataclasses
import json

import fields
import numpy as np
import pytest
from settings import settings
from squares import TEAM, Placing, Plate, gate, plate, rendered, robot

from artrec_ros.core.base.config import ImageConfig, SceneConfig
from artrec_ros.core.facing_search import FacingSearch
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.results.journal import Recognised, _packed, _unpacked

STEP_NS = 33_333_333
# directions so far apart that a frame alone seldom comes to a plate that is turned between two of them
COARSE = {"turns": 4, "grid_points": 4, "per_patch": 1, "rivals": 1, "facing_rounds": (1, 1)}


def recognizer(model, label=TEAM, **options):
    config = settings(**{"time_budget_ms": 600000.0, **options})
    return Recognizer((Target(model.name, model, label),), config, Segmenter(ImageConfig()), calibrated=False)


ONE = recognizer(robot())


@pytest.fixture
def blind(monkeypatch):
    """Once it is called blobs lead to nothing."""
    return lambda: monkeypatch.setattr(FacingSearch, "_best_of_each", lambda *args: np.zeros(0, np.int64))


@pytest.fixture
def searched(monkeypatch):
    """How many blobs of the required component were searched in each frame, what is found at first alone."""
    count, original = [], FacingSearch._searched

    def noted(self, *given):
        count.append(sum(b.label in self.finder.root_labels for b in given[-1]))
        return original(self, *given)

    monkeypatch.setattr(FacingSearch, "_searched", noted)
    return count


def play(images, recognise=ONE, step_ns=STEP_NS, memory=None, first=0):
    results = []
    for k, image in enumerate(images, first):
        result, memory = recognise.follow(image, None, k * step_ns, memory)
        results.append(result)
    return results, memory


def written(result):
    """All of a result but its times."""
    return json.dumps(_packed(dataclasses.replace(result, timing_ms={})))


def driving(k):
    return Placing(45.3 + 1.7 * k, 60.4, 0.3 + 0.04 * k, 330.0, "gv")


def places(result):
    return sorted((d.identity.name, round(d.image.x), round(d.image.y)) for d in result.detections)


def assert_at(result, at):
    (d,) = result.detections
    (part,) = (c for c in d.components if c.component == "team")
    outline = at.patches()[0][0]
    assert np.hypot(*(np.array([part.x, part.y]) - (outline.min(0) + outline.max(0)) / 2)) < 2.5
    return d


def test_what_the_frame_before_showed_is_told_where_the_search_misses_it():
    coarse = recognizer(plate(), **COARSE)
    images = [rendered(Plate(60 + 2 * k, 60, 0.05 * k, 500.0, "gr")) for k in range(16)]
    alone = [len(coarse.recognize(image).detections) for image in images]
    results, _ = play(images, coarse)
    assert sum(alone) < 12
    for k, result in enumerate(results):
        (d,) = result.detections
        assert np.hypot(d.image.x - 60 - 2 * k, d.image.y - 60) < 1.5


def test_joints_are_sought_anew_where_an_object_is_known(blind):
    swinging = recognizer(gate())
    _, memory = play([rendered(Placing(70.2, 60.4, 0.3, 330.0, arm=0.1))], swinging)
    blind()
    (result,), _ = play([rendered(Placing(71.0, 60.4, 0.33, 330.0, arm=0.6))], swinging, memory=memory, first=1)
    (d,) = result.detections
    assert d.joints["arm"] == pytest.approx(0.6, abs=0.1)


def test_what_moves_is_expected_where_its_way_leads(blind):
    _, memory = play([rendered(driving(4 * k)) for k in range(3)])
    (known,) = memory.known["robot"]
    assert np.linalg.norm(known.shift) > 0
    blind()
    results, _ = play([rendered(driving(4 * k)) for k in (3, 4)], memory=memory, first=3)
    for k, result in zip((3, 4), results, strict=True):
        assert_at(result, driving(4 * k))


def test_what_looks_a_tenth_larger_is_the_same_object():
    """Its depth stands for its scale alone: told as another one, it would have no speed."""
    _, memory = play([rendered(dataclasses.replace(driving(k), scale=330.0 * 1.05**k)) for k in range(3)])
    (known,) = memory.known["robot"]
    assert known.shift[2] < 0


def test_what_was_hidden_for_a_while_is_still_known(blind):
    image = rendered(driving(0))
    _, memory = play([image, image, np.zeros_like(image), np.zeros_like(image)])
    blind()
    (result,), _ = play([image], memory=memory, first=4)
    assert_at(result, driving(0))
    _, memory = play([np.zeros_like(image)] * 16, memory=memory, first=4)
    (result,), _ = play([image], memory=memory, first=20)
    assert not result.detections and not memory.known["robot"]


def test_nothing_is_told_for_having_been_there():
    empty, there = rendered(), rendered(driving(0))
    covered = there.copy()
    covered[:, 30:62] = 9
    results, _ = play([empty, there, there, empty, covered, there])
    assert [len(r.detections) for r in results] == [0, 1, 1, 0, 0, 1]


def test_what_was_put_elsewhere_or_changed_is_found_as_it_is():
    scenes = [driving(0), driving(0), Placing(110.2, 80.4, -2.0, 330.0, "rg"), Placing(110.2, 80.4, 1.1, 330.0, "gr")]
    results, _ = play([rendered(at) for at in scenes])
    for at, result in zip(scenes, results, strict=True):
        assert assert_at(result, at).identity.name == at.name


def test_what_is_suddenly_of_another_size_is_not_taken_for_what_it_was():
    """A climb from the old one may end at a size in which it is sure for all that, and nothing else was sought."""
    scales = np.exp(np.random.default_rng(4).uniform(np.log(250), np.log(800), 40))
    results, _ = play([rendered(Placing(75.0, 60.0, 0.3, scale, "gr"), fine=4) for scale in scales])
    for scale, result in zip(scales, results, strict=True):
        (d,) = result.detections
        assert d.image.scale == pytest.approx(scale, rel=0.08)


def test_what_known_objects_explain_is_searched_anew_in_its_turn_alone(searched):
    short = recognizer(robot(), refresh_s=0.3)
    searched.clear()  # of getting ready
    results, _ = play([SCENES[0]] * 24, short)
    assert all(len(r.detections) == 3 for r in results)
    assert searched[0] == 3 and 9 <= sum(searched) <= 24  # each of them every 0.15 to 0.3 s
    assert max(np.diff(np.flatnonzero(searched))) * STEP_NS * 1e-9 <= 0.3
    searched.clear()
    play([SCENES[0]] * 4, short, step_ns=10**9)
    assert searched == [3] * 4


def test_each_blob_is_searched_in_full_while_its_object_is_in_doubt(searched):
    half = rendered(driving(0))
    half[60:] = 9
    results, _ = play([half] * 4)
    assert searched[-4:] == [1] * 4


@pytest.mark.parametrize("apart", [1.0, 1.6])
def test_what_comes_is_found_at_once_though_it_touches_what_is_known(apart):
    first = Placing(60.3, 60.4, 0.7 + np.pi, 330.0, "gr")
    ahead = np.array([np.cos(0.7), -np.sin(0.7)]) * 0.0752 * first.scale * apart
    both = rendered(first, Placing(*(np.array([60.3, 60.4]) + ahead), 0.7, 330.0, "vr"))
    near = recognizer(robot(), min_scale=250.0, max_scale=430.0)
    results, _ = play([rendered(first)] * 3 + [both] * 2, near)
    alone = places(near.recognize(both))
    assert len(alone) == 2
    for (name, *here), (same, *there) in zip(alone + alone, places(results[3]) + places(results[4]), strict=True):
        assert name == same and np.hypot(*np.subtract(here, there)) <= 2


SCENES = [
    rendered(
        driving(k), Placing(110.2, 30.4 + 2 * k, 0.4 * k, 300.0, "rg"), Placing(120.3, 95.2, -0.3 * k, 340.0, "vr")
    )
    for k in range(16)
]


@pytest.mark.parametrize("order", ["shuffled", "2", "4", "8"])
def test_frames_in_any_order_show_what_each_shows_alone(order):
    number = np.arange(len(SCENES))
    some = np.random.default_rng(3).permutation(number) if order == "shuffled" else number[:: int(order)]
    results, _ = play([SCENES[k] for k in some])
    for k, result in zip(some, results, strict=True):
        alone = ONE.recognize(SCENES[k])
        assert len(alone.detections) == 3 and len(result.detections) == 3
        for (name, *here), (same, *there) in zip(places(result), places(alone), strict=True):
            assert name == same and np.hypot(*np.subtract(here, there)) <= 2


def test_after_a_cut_there_is_what_each_scene_shows():
    apart = [rendered(Placing(30.3 + 25 * n, 35.0 + 50 * (n % 2), 1.0 + n, 330.0, "gr")) for n in range(4)]
    images = [image for n in range(4) for image in [apart[n]] * 3]
    for image, result in zip(images, play(images)[0], strict=True):
        assert places(result) == places(ONE.recognize(image))


def test_a_memory_is_a_value_that_can_be_kept_in_a_file():
    images = SCENES[:4]
    (*_, last), _ = play(images)
    _, memory = play(images[:3])
    assert memory.camera is None and len(memory.known["robot"]) == 3
    read = _unpacked(json.loads(json.dumps(_packed(Recognised(0, "", memory=memory))))).memory
    (again,), _ = play(images[3:], memory=read, first=3)
    assert written(again) == written(last)


def test_switched_off_each_frame_is_judged_by_itself():
    off = recognizer(robot(), memory=False)
    results, memory = play(SCENES[:4], off)
    assert memory is None
    assert [written(r) for r in results] == [written(off.recognize(image)) for image in SCENES[:4]]


def test_on_a_plane_that_is_seen_at_a_slant_objects_are_known_as_they_are_from_above(blind):
    camera = fields.camera()
    truth = np.array([[0.2, 0.2, 0.5], [0.6, 0.3, -1.2], [0.4, 0.6, 2.5]])
    scene = SceneConfig(plane=fields.plane(camera, 35.0))
    on_field = recognizer(fields.robot(0.06), fields.TEAM, scene=scene)
    images = [fields.render(camera, 35.0, 0.06, truth + [0.004 * k, 0, 0.02 * k]) for k in range(2)]
    _, memory = play(images[:1], on_field)
    blind()
    (result,), _ = play(images[1:], on_field, memory=memory, first=1)
    for x, y, _ in truth + [0.004, 0, 0.02]:
        assert min(np.hypot(*(d.pose.position[:2] - (x, y))) for d in result.detections) < 2e-3
