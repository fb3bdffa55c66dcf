"""Which frames `artrec studio` puts first: those from which it would learn most."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from studio_pictures import Pictures
from studio_sitting import again

from artrec_ros.core.model.found import Detection, IdentityFit, ImagePose, Instance
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.tools.studio_state.doubts import doubt_of, ranked, recognised
from artrec_ros.tools.studio_state.examples import Examples
from artrec_ros.tools.studio_state.jumps import jumps
from artrec_ros.tools.studio_state.rare_pairs import rare_pairs, shown_by
from artrec_ros.tools.studio_state.session import Session

STEP_NS = 10**8
BOX = np.array([[-15.0, -15.0], [15.0, 15.0]])  # an object of 42 px


def test_frames_in_which_objects_are_missing_come_first(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    full = session.recognise(1)
    none = dataclasses.replace(full, detections=())
    parts = {"robot": 2}
    assert doubt_of(0, none, 3, parts).why == "3 of the usual 3 objects missing"
    assert doubt_of(0, none, 3, parts).worth > doubt_of(0, full, 3, parts).worth
    assert doubt_of(0, FrameResult((3, 3)), 0, parts).worth == 0
    half = dataclasses.replace(full.detections[0], components=full.detections[0].components[:1], score=1.0, margin=1.0)
    doubt = doubt_of(0, dataclasses.replace(full, detections=(half,)), 1, parts)
    assert doubt.why.endswith("1 of the usual 2 components") and doubt.worth == 0.5
    shares: list[float] = []
    examples = Examples(session)
    examples.set_empty(2)
    order = ranked(session, examples, recognised(session, range(6), shares.append))
    assert {d.number for d in order} == {0, 1, 3, 4, 5} and shares[-1] == 1
    assert [d.worth for d in order] == sorted((d.worth for d in order), reverse=True)


def seen(x: float, y: float, theta: float = 0.0, name: str = "", component: str = "team") -> Detection:
    """An object at a place, with an identity where it has a name."""
    part = Instance(component, component, 1.0, x, y, theta, 100.0, BOX + (x, y))
    identity = IdentityFit(name, 1.0, unique=True) if name else None
    return Detection("robot", 0, 1.0, ImagePose(x, y, theta, 100.0), (part,), identity=identity, margin=1.0)


def film(frames: list[list[Detection]]) -> list[tuple[int, int, FrameResult]]:
    return [(i * STEP_NS, i, FrameResult((640, 480), tuple(found))) for i, found in enumerate(frames)]


def walk(count: int = 20) -> list[list[Detection]]:
    """Three robots that walk and turn, with noise, told in no order."""
    rng = np.random.default_rng(5)
    frames = []
    for i in range(count):
        found = [
            seen(*(np.array([60 + 4 * i, 80 + 90 * k]) + rng.normal(0, 0.4, 2)), 0.1 * i + k + rng.normal(0, 0.02))
            for k in range(3)
        ]
        frames.append([found[k] for k in rng.permutation(3)])
    return frames


def test_what_walks_steadily_does_not_jump() -> None:
    assert jumps(film(walk())) == []


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ((70.0, -20.0, 0.0), "robot_0 lies 7[23] px off"),
        ((0.0, 0.0, np.pi), "robot_0 is turned by 1[78][0-9] degrees against"),
    ],
)
def test_the_frame_in_which_one_object_jumps_is_told(change: tuple[float, float, float], why: str) -> None:
    frames = walk()
    d = frames[11][1]
    frames[11][1] = seen(d.image.x + change[0], d.image.y + change[1], d.image.theta + change[2])
    found = jumps(film(frames)[::-1])
    worst = max(found, key=lambda j: j.off)
    assert worst.number == 11 and re.fullmatch(f"{why} where the frames before and after have it", worst.why)
    assert {j.number for j in found} <= {10, 11, 12}, "its neighbours see it from the other side"


def test_what_moves_fast_is_no_jump_and_neither_is_what_comes_or_goes() -> None:
    frames = [[seen(30.0 * i, 100.0 + (i % 2))] for i in range(12)]
    assert jumps(film(frames)) == [], "as far apart before and after"
    for i in (3, 7):
        frames[i] = []
    frames[9].append(seen(500.0, 400.0))
    assert jumps(film(frames)) == []


def test_pictures_that_are_no_sequence_have_no_jumps() -> None:
    rng = np.random.default_rng(9)
    frames = [[seen(*rng.uniform(0, 480, 2), rng.uniform(-3, 3)) for _ in range(4)] for _ in range(40)]
    found = jumps(film(frames))
    assert len({j.number for j in found}) <= 2, "neighbours that agree by chance are few"
    assert jumps(film(frames[:2])) == [] and jumps([]) == []


def test_identities_tell_like_objects_that_pass_each_other_apart() -> None:
    ways = [[seen(20.0 * i, 100, name="a"), seen(400 - 20.0 * i, 104, name="b")] for i in range(20)]
    assert jumps(film(ways)) == []
    ways[6] = [seen(120.0, 100, name="b"), seen(280.0, 104, name="a")]
    assert max(jumps(film(ways)), key=lambda j: j.off).number == 6, "two names were exchanged"


def test_pairs_that_examples_hardly_show_are_rare(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    examples, target = Examples(session), session.setup.targets[0]
    result = session.recognise(5)
    both = [d for d in result.detections if len(d.components) == 2]
    assert both, "a robot with both of its markers"

    def worth() -> list[tuple[float, str]]:
        return sorted(rare_pairs(FrameResult((320, 240), (both[0],)), shown_by(examples, session.setup.targets)))

    assert worth() == [], "without any example all would be"
    tail, head = pictures.axes(0)[0]["team"]
    alone = examples.new(0, target, ("team", "team"), tail, head)
    examples.remove(alone)
    team = {name: p for name, p in alone.points.items() if name.startswith("team")}
    examples.objects.append(dataclasses.replace(alone, points=team))
    (never,) = worth()
    assert never[1].endswith("accent/accent and team/team together in no example")
    told = []
    for number in (0, 1, 2):
        examples.new(number, target, ("team", "team"), *pictures.axes(number)[0]["team"])
        told.append(worth())
    assert told[0][0][1].endswith("together in 1 example") and told[1][0][1].endswith("together in 2 examples")
    assert never[0] > told[0][0][0] > told[1][0][0] and told[2] == []
    turned = dataclasses.replace(both[0].components[0], theta=both[0].components[0].theta + 0.8)
    both[0] = dataclasses.replace(both[0], components=(turned, both[0].components[1]))
    assert "turn_rad" in worth()[-1][1] and "in 3 examples" in worth()[-1][1]


def test_the_queue_says_which_frame_jumps(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    results = {n: r for _, n, r in film(walk(6))}
    d = results[3].detections[0]
    far = seen(d.image.x + 200, d.image.y, d.image.theta)
    results[3] = dataclasses.replace(results[3], detections=(far, *results[3].detections[1:]))
    first = ranked(session, Examples(session), results)[0]
    assert first.number == 3 and "lies 200 px off" in first.why
