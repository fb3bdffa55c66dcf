"""Targets that look alike, from frame to frame: which one is told, how often others are looked for, and what is known
of them where there was no time for that."""

import dataclasses
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from settings import settings
from solids import camera_of
from squares import SIZE, TEAM, rendered
from test_other_objects import CAMERAS, FLEET, OTHER, Pair, Plate, pair, plate

from artrec_ros.core.base import deadline
from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.base.patience import Patience
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.like_target_looks import LikeTargetLooks
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.other_objects import OtherObjects
from artrec_ros.io.results.journal import Recognised, _packed, _unpacked

BOTH = {"ahead": (pair(TEAM, OTHER), TEAM), "astern": (pair(OTHER, TEAM), OTHER)}
TWINS = {"one": BOTH["ahead"], "two": BOTH["ahead"]}


def recognizer(models, camera, **options):
    targets = [Target(name, model, label) for name, (model, label) in models.items()]
    return Recognizer(targets, settings(**options), Segmenter(ImageConfig()), calibrated=camera is not None)


def film(shape, frames, *name):
    """It moves and turns, and labels are missing here and there."""
    rng = np.random.default_rng(4)
    for n in range(frames):
        image = rendered(shape(50.0 + 2 * n, 60.0, 0.3 + 0.03 * n, 600.0, *name)).copy()
        image[rng.random(image.shape) < 0.01] = 0
        yield n * 33_333_333, image


def followed(engine, camera, images, patience=None):
    """What each frame tells, and the last memory."""
    memory, told = None, []
    for stamp_ns, image in images:
        result, memory = engine.follow(image, camera, stamp_ns, memory, patience)
        told.append(result.detections)
    return told, memory


@pytest.fixture
def looks(monkeypatch):
    """Of each frame how many looks in full there were for like targets."""
    plain_look, plain, number = LikeTargetLooks._look, LikeTargetLooks.candidates, []

    def candidates(*args):
        number.append(0)
        return plain(*args)

    def look(*args):
        number[-1] += 1
        return plain_look(*args)

    monkeypatch.setattr(LikeTargetLooks, "candidates", candidates)
    monkeypatch.setattr(LikeTargetLooks, "_look", look)
    return number


@CAMERAS
@pytest.mark.parametrize("models", [BOTH, TWINS], ids=["turned", "the same"])
def test_from_frame_to_frame_one_of_two_that_look_alike_is_told_at_about_a_half(camera, models):
    told, _ = followed(recognizer(models, camera), camera, film(Pair, 20))
    assert all(len(detections) == 1 for detections in told)
    assert len({d.object for (d,) in told}) == 1
    assert all(0.3 < d.as_told < 0.7 and d.other_object is not None for (d,) in told)
    assert max(abs(np.diff([d.as_told for (d,) in told]))) < 0.2


def test_what_may_be_there_instead_is_followed_and_what_may_not_is_looked_for_ever_later(looks):
    camera, fleet = camera_of(SIZE), {name: (plate(classes), TEAM) for name, classes in FLEET.items()}
    # of five that have its classes one looks the same after a quarter turn
    models = {**fleet, "1000": (plate([OTHER + 1, OTHER, OTHER, OTHER]), TEAM)}
    told, _ = followed(recognizer(models, camera), camera, film(Plate, 24, "0001"))
    assert {d.object for detections in told for d in detections} <= {"0001", "1000"}
    assert looks[0] > 0 and sum(looks[1:]) < 6 * looks[0]
    assert sum(looks[12:]) < sum(looks[:12])


def test_all_that_is_known_is_looked_for_anew_at_least_as_often_as_is_asked_for(looks):
    camera = camera_of(SIZE)
    followed(recognizer(BOTH, camera, refresh_s=0.2), camera, film(Pair, 20))
    frames = np.flatnonzero(looks)
    assert len(frames) < 10 and max(np.diff(frames)) <= 6


def test_while_newer_images_wait_few_looks_are_taken(looks):
    camera = camera_of(SIZE)
    followed(recognizer(BOTH, camera), camera, film(Pair, 8), Patience(lambda: True))
    assert max(looks) <= 1


def test_a_memory_of_what_may_be_there_instead_comes_back_from_a_journal():
    camera = camera_of(SIZE)
    _, memory = followed(recognizer(BOTH, camera), camera, film(Pair, 3))
    assert any(known.instead for mine in memory.known.values() for known in mine)
    again = _unpacked(_packed(Recognised(0, "f", memory=memory))).memory
    first, second = ({n: [*map(dataclasses.asdict, mine)] for n, mine in m.known.items()} for m in (memory, again))
    np.testing.assert_equal(first, second)


def test_a_memory_of_names_that_change_while_time_is_over_does_not_grow(monkeypatch):
    decided, frame = OtherObjects.decided, [0]

    def decide(self, accepted, rivals, deadline):
        return decided(self, accepted, rivals, SimpleNamespace(expired=True) if frame[0] > 1 else deadline)

    def depth(known):
        return 1 + max((depth(one.known) for one in known.instead.values() if one.known is not None), default=0)

    monkeypatch.setattr(OtherObjects, "decided", decide)
    size, rng, memory, told = (200, 160), np.random.default_rng(2), None, []
    camera = camera_of(size)
    engine = recognizer(BOTH, camera)
    for frame[0] in range(30):
        image = rendered(Pair(80 + frame[0] / 2, 80, 0.05 + frame[0] / 50, 600.0), size=size).copy()
        image[rng.random(image.shape) < 0.01] = 0
        result, memory = engine.follow(image, camera, frame[0] * 33_333_333, memory)
        told += [d.object for d in result.detections]
    assert sum(before != after for before, after in pairwise(told)) > 5
    assert max(depth(known) for mine in memory.known.values() for known in mine) <= 2


@pytest.mark.parametrize("turn", [-1.25, -1.0, -0.75])
def test_where_a_plain_look_finds_less_than_is_there_a_closer_one_is_taken(turn):
    """Each of three looks like the others after a quarter turn."""
    models = {name: (plate([OTHER + int(one) for one in name]), TEAM) for name in ("0011", "1001", "0110")}
    (one,) = (
        recognizer(models, camera_of(SIZE))
        .recognize(rendered(Plate(75.0, 60.0, turn, 500.0, "0011")), camera_of(SIZE))
        .detections
    )
    assert one.as_told < 0.6


def struck(monkeypatch, look, strikes_after=np.inf):
    """What comes of a look where time is over once the clock was asked so often; and how often it was."""
    asked = []

    def clock():
        asked.append(True)
        return np.inf if len(asked) > strikes_after else 0.0

    monkeypatch.setattr(deadline.time, "perf_counter", clock)
    return look(), len(asked)


@CAMERAS
@pytest.mark.parametrize("share", [0.5, 0.7, 0.8, 0.9, 0.97])
def test_where_time_ends_before_others_are_compared_nothing_is_sure(monkeypatch, camera, share):
    engine, image = recognizer(BOTH, camera, time_budget_ms=1000.0), rendered(Pair(75.0, 60.0, 0.3, 600.0))

    def look():
        return engine.recognize(image, camera)

    result, _ = struck(monkeypatch, look, int(share * struck(monkeypatch, look)[1]))
    assert all(d.score < 0.75 and d.other_object is not None for d in result.detections)


def test_nothing_is_looked_for_in_vain_where_there_is_no_time_to_see_what_comes_of_it(monkeypatch):
    camera, image = camera_of(SIZE), rendered(Pair(75.0, 60.0, 0.3, 600.0))
    engine = recognizer(BOTH, camera, time_budget_ms=1000.0)

    def look():
        return engine.follow(image, camera, 0, None)[1]

    _, asked = struck(monkeypatch, look)
    memories = [struck(monkeypatch, look, n)[0] for n in range(asked // 2, asked)]
    instead = [one for m in memories for mine in m.known.values() for k in mine for one in k.instead.values()]
    assert instead and all(one.known is not None for one in instead)


@CAMERAS
@pytest.mark.parametrize("turn", [0.3, 2.1])
@pytest.mark.parametrize("models", [BOTH, TWINS], ids=["turned", "the same"])
def test_which_one_is_told_does_not_depend_on_which_is_listed_first(camera, turn, models):
    image, backwards = rendered(Pair(75.0, 60.0, turn, 600.0)), dict(reversed(models.items()))
    one, other = (recognizer(m, camera).recognize(image, camera).detections[0] for m in (models, backwards))
    assert (one.object, one.score) == (other.object, other.score)
