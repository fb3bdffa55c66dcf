"""Images without calibration to whole flat objects: clean scenes of known truth, and images without any."""

import dataclasses

import cv2
import numpy as np
import pytest
from settings import settings
from squares import (
    ARM,
    BACK,
    COLOURS,
    DOTS,
    PAIRS,
    SIZE,
    TEAM,
    Placing,
    Plate,
    gate,
    patch,
    plate,
    rendered,
    robot,
)  # fmt: skip

from artrec_ros.core.base import deadline
from artrec_ros.core.base.config import ClassConfig, ImageConfig, PlaneConfig, SceneConfig
from artrec_ros.core.facing_search import FacingSearch
from artrec_ros.core.facing_stage import FacingStage
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.facing_guesses import FacingGuesser, Guesses
from artrec_ros.core.recognizer import Recognizer

NAMES = [name for name, *_ in PAIRS]


def recognizer(model, **options):
    return Recognizer(
        (Target(model.name, model, TEAM),), settings(**{"time_budget_ms": 60000, **options}), Segmenter(ImageConfig())
    )


@pytest.fixture(scope="module")
def robots():
    return recognizer(robot())


def errors(detection, at, outline=BACK):
    """Of the required component: place in pixels, turn in degrees, scale as a share."""
    (part,) = (c for c in detection.components if c.component == "team")
    x, y = at.at([outline.mean(axis=0)])[0]
    turned = np.angle(np.exp(1j * (part.theta + at.turn)))  # theta runs from x to y, which is down
    return np.hypot(part.x - x, part.y - y), abs(np.degrees(turned)), abs(part.scale / at.scale - 1)


def assert_found(result, *placed, place=0.35, turn=1.2, scale=0.02):
    assert len(result.detections) == len(placed), [r.reason for r in result.rejected]
    for at in placed:
        near = min(result.detections, key=lambda d: errors(d, at)[0])
        assert np.less(errors(near, at), (place, turn, scale)).all(), (at, errors(near, at))
        assert near.pose is None and near.pose_covariance is None and 0.5 < near.score <= 1
        assert (near.image.x, near.image.scale) == (near.components[0].x, near.components[0].scale)


CORNERS = [(x, y) for x in (21.3, SIZE[0] - 22.7) for y in (21.7, SIZE[1] - 22.3)]


@pytest.mark.parametrize("turn", [-2.4, 0.35, 1.2, 2.7])
@pytest.mark.parametrize(("x", "y"), [(75.2, 60.4), (66.6, 31.1), *CORNERS])
def test_place_turn_and_scale_are_found_all_over_the_image(robots, x, y, turn):
    at = Placing(x, y, turn, 330.0, "gv")
    result = robots.recognize(rendered(at))
    assert_found(result, at)
    (d,) = result.detections
    assert d.name == "robot_gv"
    assert {c.component: c.shows for c in d.components} == {"team": "", "left": "g", "right": "v"}


@pytest.mark.parametrize("name", ["gr", "rg"])
@pytest.mark.parametrize("turn", [0.2, 1.9, -2.4, -0.9])
def test_colours_tell_the_turn_where_all_else_looks_the_same(name, turn):
    at = Plate(70.3, 58.4, turn, 500.0, name)
    d = recognizer(plate()).recognize(rendered(at)).detections[0]
    assert d.identity.name == name
    places = {c.component: (c.x, c.y) for c in d.components}
    for corner, where in DOTS.items():
        np.testing.assert_allclose(places[corner], at.at([where])[0], atol=6.0)


def test_with_a_calibration_limits_of_the_range_are_limits_of_the_search(monkeypatch):
    camera, searched = (
        Camera(np.array([[660.0, 0, SIZE[0] / 2], [0, 660.0, SIZE[1] / 2], [0, 0, 1]]), np.zeros(5), SIZE),
        [],
    )
    run = FacingSearch.run

    def noted(self, frame, blobs, limits, *rest):
        searched.append(limits)
        return run(self, frame, blobs, limits, *rest)

    monkeypatch.setattr(FacingSearch, "run", noted)
    plane = PlaneConfig((0.0, 0.0, 100.0, 0.0, 100.0, 100.0, 0.0, 100.0), (0.0, 0.3, 0.3, 0.3, 0.3, 0.0, 0.0, 0.0))
    engine = recognizer(robot(), min_range_m=1.5, max_range_m=2.5, scene=SceneConfig(plane=plane))
    engine.recognize(rendered(Placing(75.2, 60.4, 0.3, 330.0)), camera)
    assert tuple(searched[-1]) == pytest.approx((660 / 2.5, 660 / 1.5))


def test_limits_of_the_range_refuse_where_a_calibration_tells_it_alone():
    camera = Camera(np.array([[660.0, 0, SIZE[0] / 2], [0, 660.0, SIZE[1] / 2], [0, 0, 1]]), np.zeros(5), SIZE)
    image, found = rendered(Placing(75.2, 60.4, 0.3, 330.0)), []
    plane = PlaneConfig((0.0, 0.0, 100.0, 0.0, 100.0, 100.0, 0.0, 100.0), (0.0, 0.3, 0.3, 0.3, 0.3, 0.0, 0.0, 0.0))
    for far_m in (1.0, 3.0):  # it is 2 m away
        engine = recognizer(robot(), max_range_m=far_m, scene=SceneConfig(plane=plane))
        found.append([len(engine.recognize(image, known).detections) for known in (None, camera)])
    assert found == [[1, 0], [1, 1]]


@pytest.mark.parametrize("scale", [210.0, 330.0, 500.0, 760.0])
def test_large_and_small(robots, scale):
    rng = np.random.default_rng(int(scale))
    reach = 0.054 * scale + 1
    for _ in range(4):
        x, y = rng.uniform(reach, np.array(SIZE) - reach)
        at = Placing(x, y, rng.uniform(-np.pi, np.pi), scale, str(rng.choice(NAMES)))
        result = robots.recognize(rendered(at))
        assert_found(result, at, turn=2.6, scale=0.03, place=0.35)
        assert result.detections[0].identity.name == at.name


def test_what_the_border_cuts_is_found_where_it_is(robots):
    for x, y in ((9.0, 60.3), (140.6, 40.2), (70.4, 8.7)):
        at = Placing(x, y, 0.35, 330.0, "rg")
        (d,) = robots.recognize(rendered(at)).detections
        contour = next(c.contour for c in d.components if c.component == "team")
        truth = at.at(BACK)
        assert np.linalg.norm(contour[:, None] - truth, axis=2).min(axis=1).max() < 1.0


@pytest.mark.parametrize("turns", [(0.0, 0.0), (0.7, 0.7), (1.1, 1.1 + np.pi / 2)])
def test_two_that_touch_are_told_apart_though_they_are_one_blob(turns):
    """Back to back, where both team patches are a square, and across. Two sizes fit a square: limits tell."""
    first = Placing(60.3, 60.4, turns[0] + np.pi, 330.0, "gr")
    ahead = np.array([np.cos(turns[0]), -np.sin(turns[0])]) * 0.0752 * first.scale
    second = Placing(*(np.array([60.3, 60.4]) + ahead), turns[1], 330.0, "vr")
    result = recognizer(robot(), min_scale=250.0, max_scale=430.0).recognize(rendered(first, second))
    assert_found(result, first, second, place=1.3, turn=2.5, scale=0.04)
    assert sorted(d.name for d in result.detections) == ["robot_gr", "robot_vr"]


@pytest.mark.parametrize("seed", [35, 48])
def test_a_patch_that_a_long_line_runs_into_is_looked_for_at_its_own_size(seed):
    """Their blob is many times the patch; how large that can be is known."""
    rng, size = np.random.default_rng(seed), (320, 240)
    at = Placing(*rng.uniform((60, 60), (260, 180)), rng.uniform(-np.pi, np.pi), 300.0, "gr")
    along = np.array([np.cos(angle := rng.uniform(0, np.pi)), np.sin(angle)])
    middle = np.array([at.x, at.y]) + rng.uniform(-12, 12) * along[::-1] * (-1, 1)
    picture, line = rendered(at, size=size), np.zeros(size[::-1], np.uint8)
    ends = [tuple(map(int, middle + way * 600 * along)) for way in (-1, 1)]
    cv2.line(line, *ends, 1, 5)
    picture[(line > 0) & (picture == 0)] = TEAM
    engine = recognizer(robot(), min_scale=220.0, max_scale=480.0)
    assert any(errors(d, at)[0] < 2 for d in engine.recognize(picture).detections if d.name == "robot_gr")


@pytest.mark.parametrize("turn", [0.0, 0.8, 2.2])
def test_what_is_a_small_part_of_a_large_blob_is_found(turn):
    """A line of the team's class runs into the robot: its patch is a tenth of their blob."""
    at, size = Placing(150.3, 60.2, turn, 420.0, "gr"), (300, 200)
    picture, line = rendered(at, size=size), np.zeros(size[::-1], np.uint8)
    way = [at.at([(-0.0375, 0.0)])[0], (150, 130), (30, 130), (30, 180), (270, 180), (270, 130)]
    cv2.polylines(line, [np.rint(way).astype(np.int32)], False, 1, 8)
    picture[(line > 0) & (picture == 0)] = TEAM
    assert_found(recognizer(robot()).recognize(picture), at, place=0.5, scale=0.03)


@pytest.mark.parametrize("kept", [-1, 1])
@pytest.mark.parametrize("turn", [0.3, 2.0])
def test_a_patch_that_lies_on_itself_is_turned_whichever_way_round_it_is_laid_on_its_blob(monkeypatch, turn, kept):
    """A coarse grid keeps one of two turns that its outline does not tell by chance: what else there is tells."""
    at, guess = Placing(70.3, 60.2, turn, 330.0, "gr"), FacingGuesser.guess

    def of_one_way_round(self, *args):
        found = guess(self, *args)
        ahead = found.poses.R[:, :2, 0] @ (np.cos(turn), -np.sin(turn))
        return Guesses(*(column[np.flatnonzero(kept * ahead > 0)] for column in found))

    monkeypatch.setattr(FacingGuesser, "guess", of_one_way_round)
    assert_found(recognizer(robot()).recognize(rendered(at)), at)


def test_a_full_field_is_named_together(robots):
    placed = [
        Placing(25.2, 25.3, 0.4, 300.0, "gr"), Placing(75.4, 28.1, 2.0, 300.0, "gv"),
        Placing(122.3, 30.4, -1.0, 300.0, "rg"), Placing(40.1, 85.2, 3.0, 300.0, "vr"),
    ]  # fmt: skip
    result = robots.recognize(rendered(*placed))
    assert_found(result, *placed)
    assert sorted(d.name for d in result.detections) == [f"robot_{name}" for name in sorted(NAMES)]
    assert sorted(d.id for d in result.detections) == [0, 1, 2, 3]


@pytest.mark.parametrize("arm", [-1.0, -0.3, 0.0, 0.62, 1.1])
def test_a_joint_in_the_plane_is_told(arm):
    at = Placing(60.3, 60.2, 0.5, 400.0, "gr", arm)
    result = recognizer(gate()).recognize(rendered(at))
    assert_found(result, at)
    (d,) = result.detections
    assert np.degrees(abs(d.joints["arm"] - arm)) < 2.0
    assert "arm" in {c.component for c in d.components}


def turned(model, T):
    """The same object with another frame: its plane is another one of its own."""
    parts = tuple(
        dataclasses.replace(
            c, markers=tuple(dataclasses.replace(m, T_component_marker=T @ m.T_component_marker) for m in c.markers)
        )
        for c in model.components
    )
    return dataclasses.replace(model, components=parts)


@pytest.mark.parametrize("rpy", [(np.pi / 2, 0, 0), (0, np.pi / 2, 0), (0.3, -np.pi / 2, 0.7), (0, 0, 2.0)])
def test_the_objects_plane_may_be_any_of_its_frame(rpy):
    """Also that of y and z, whose normal is x: turns are told by what lies in the plane."""
    engine = recognizer(turned(robot(), Pose.from_xyz_rpy((0.01, -0.02, 0.03), rpy)))
    for n, at in enumerate((Placing(50.3, 60.4, 0.5, 330.0, "gr"), Placing(90.3, 50.4, -2.5, 330.0, "vr"))):
        result = engine.recognize(rendered(at))
        assert_found(result, at)
        assert result.detections[0].identity.name == at.name, n


def test_limits_of_scale_are_kept():
    at = Placing(75.3, 60.2, 0.5, 330.0, "gr")
    labels, right = rendered(at), 0.0
    for low, high in ((300, 360), (320, 0), (0, 340), (450, 0), (0, 220)):
        result = recognizer(robot(), min_scale=float(low), max_scale=float(high)).recognize(labels)
        for d in result.detections:
            assert low - 1e-6 <= d.image.scale <= (high or np.inf) + 1e-6
        if low < at.scale < (high or np.inf):
            assert_found(result, at)
            right = result.detections[0].score
        else:  # of another size there is none, or one that fits less well
            assert all(d.score < right for d in result.detections)
    tight = recognizer(robot(), min_scale=335.0, max_scale=336.0).recognize(labels)
    assert 335.0 - 1e-6 <= tight.detections[0].image.scale <= 336.0 + 1e-6


def test_without_time_or_without_anything_in_view_nothing_is_found(robots):
    for image in (np.zeros((90, 110), np.uint8), np.full((90, 110), 9, np.uint8), np.zeros((1, 1), np.uint8)):
        result = robots.recognize(image)
        assert result.complete and not result.detections and not list(result.rejected)
    late = recognizer(robot(), time_budget_ms=1).recognize(rendered(*(Placing(40, 40, 0.3, 300.0),) * 2))
    assert late.size == SIZE
    assert late.ended_by in ((), ("recognizer.time_budget_ms",))


@pytest.mark.parametrize("share", [0.01, 0.03, 0.1, 0.3, 0.6])
def test_every_stage_ends_with_the_time_where_all_is_full_of_patches(monkeypatch, share):
    """The clock is asked between pieces of work: once it has struck, little more is begun. (speed.py has the times.)"""
    rgb = {TEAM: (230, 200, 30), 4: (40, 160, 60), 5: (210, 40, 60), 6: (120, 60, 170)}
    classes = {f"c{label}": ClassConfig(label=label, rgb=colour) for label, colour in rgb.items()}
    model, image = robot(), ImageConfig(kind="colour", classes=classes, background=(60, 60, 62))
    squares = np.random.default_rng(0).integers(0, 255, (60, 80, 3), dtype=np.uint8)
    picture = cv2.resize(squares, (640, 480), interpolation=cv2.INTER_NEAREST)
    targets, config = (Target("robot", model, TEAM), Target("other", model, 4)), settings(min_probability=0.15)
    engine, asked = Recognizer(targets, config, Segmenter(image)), []

    def clock(strikes_after):
        asked.append(True)
        return np.inf if len(asked) > strikes_after else 0.0

    def asked_in_all(strikes_after):
        asked.clear()
        monkeypatch.setattr(deadline.time, "perf_counter", lambda: clock(strikes_after))
        return engine.recognize(picture), len(asked)

    whole, pieces = asked_in_all(np.inf)
    cut, until_it_ended = asked_in_all(int(share * pieces))
    assert whole.ended_by == () and cut.ended_by == ("recognizer.time_budget_ms",)
    assert until_it_ended < (share + 0.15) * pieces


def test_what_was_found_stays_where_time_ends_while_merged_ones_are_looked_for(monkeypatch):
    placed = [Placing(30.0 + 48 * i, 30.0 + 48 * j, 0.4 + i + j, 300.0) for i in range(12) for j in range(6)]
    picture = rendered(*placed, size=(600, 400), fine=4)
    picture[365:395, 50:250] = picture[320:395, 50:70] = TEAM  # no marker's shape, and no object explains it
    engine, over, original = recognizer(robot(unique=False)), [], FacingStage._of_the_rest

    def late(self, *args):
        found = original(self, *args)
        assert found
        over.append(True)
        monkeypatch.setattr(deadline.time, "perf_counter", lambda: np.inf)
        return found

    monkeypatch.setattr(FacingStage, "_of_the_rest", late)
    result = engine.recognize(picture)
    assert over and result.ended_by == ("recognizer.time_budget_ms",)
    assert len(result.detections) >= len(placed)


@pytest.mark.parametrize(("greatest", "looks"), [(0.0, 2), (2000.0, 3), (330.0, 1)])
def test_what_has_no_smaller_scale_to_try_is_not_looked_through_twice(monkeypatch, greatest, looks):
    picture, tasks, original = rendered(size=(300, 200)), [], FacingStage._found
    picture[165:195, 50:250] = picture[20:195, 50:70] = TEAM  # no marker's shape; a large one is told on part of it

    def noted(self, frame, searches, *rest, **more):
        tasks.append(len(searches))
        return original(self, frame, searches, *rest, **more)

    monkeypatch.setattr(FacingStage, "_found", noted)
    engine = recognizer(robot(), max_scale=greatest)
    tasks.clear()  # of getting ready
    engine.recognize(picture)
    assert tasks == [1] * looks


def test_any_label_image_gives_a_result(robots):
    rng = np.random.default_rng(0)
    rows, columns = np.indices((90, 120))
    images = {
        "noise": rng.integers(0, 9, (90, 120)), "full": np.full((90, 120), TEAM), "stripes": rows % 2 * TEAM,
        "checks": (rows + columns) % 2 * TEAM, "one": np.full((1, 1), TEAM), "row": np.full((1, 90), TEAM),
        "line": (rows == columns) * TEAM, "teams": rng.choice([0, TEAM], (90, 120)),
    }  # fmt: skip
    for name, image in images.items():
        result = robots.recognize(image.astype(np.uint8))
        assert all(0 <= d.score <= 1 for d in result.detections), name
        assert all(np.isfinite((d.image.x, d.image.y, d.image.scale)).all() for d in result.detections), name
        assert all(r.reason for r in result.rejected), name


def test_specks_are_no_robots(robots):
    labels = np.zeros(SIZE[::-1], np.uint8)
    labels[20:23, 30:33], labels[60:62, 80:85] = TEAM, TEAM
    assert not robots.recognize(labels).detections


def test_a_team_patch_alone_is_one_of_no_name(robots):
    """Its other patches' pixels show something else: which one it is cannot be told."""
    at = Placing(75.3, 60.2, 0.5, 330.0, "gr")
    labels = rendered(at)
    labels[np.isin(labels, list(COLOURS.values()))] = 9
    for d in robots.recognize(labels).detections:
        assert d.identity.name is None and d.name == "robot_unknown_0"


def test_calibrated_or_not_the_same_object_is_at_the_same_place():
    """In space the camera that takes the image tells; facing it, any does."""
    at = Placing(70.3, 55.2, 0.5, 330.0, "gr")
    engine, labels = recognizer(robot()), rendered(at)
    (bare,) = engine.recognize(labels).detections
    (posed,) = engine.recognize(labels, Camera.facing(SIZE)).detections
    assert bare.pose is None and posed.pose is not None
    np.testing.assert_allclose((bare.image.x, bare.image.y), (posed.image.x, posed.image.y), atol=0.5)
    assert bare.identity.name == posed.identity.name == "gr"


def test_soft_edges_of_colour_images_cost_no_robot():
    """Blurred colours whose mixtures are in doubt; the place is as good as on labels."""
    rgb = {TEAM: (230, 200, 30), 4: (40, 160, 60), 5: (210, 40, 60), 6: (120, 60, 170), 0: (60, 60, 62)}
    classes = {f"c{label}": ClassConfig(label=label, rgb=colour) for label, colour in rgb.items() if label}
    image = ImageConfig(kind="colour", classes=classes, background=rgb[0])
    model = robot()
    engine = Recognizer((Target("robot", model, TEAM),), settings(time_budget_ms=60000), Segmenter(image))
    rng = np.random.default_rng(2)
    for name, turn in (("gr", 0.4), ("vr", 2.2), ("rg", -1.2)):
        at = Placing(72.3, 58.4, turn, 330.0, name)
        labels = rendered(at)
        bgr = np.zeros((*labels.shape, 3))
        for label, colour in rgb.items():
            bgr[labels == label] = colour[::-1]
        bgr = cv2.GaussianBlur(bgr, (0, 0), 0.8) + rng.normal(0, 3, bgr.shape)
        result = engine.recognize(np.clip(np.rint(bgr), 0, 255).astype(np.uint8))
        assert_found(result, at, place=0.6, turn=2.0, scale=0.05)
        assert result.detections[0].identity.name == name


def test_a_marker_on_the_joint_alone_can_be_the_required_one():
    """All grows from the arm: the rest is found where its joint lets it be."""
    base, arm = gate().components[0], gate().components[-1]
    model = ObjectModel(
        "arm",
        (
            dataclasses.replace(base, required=False),
            Component("tip", (patch("arm", ARM),), required=True, label=7, joint=arm.joint),
        ),
    )
    at = Placing(60.3, 60.2, 0.5, 400.0, "gr", 0.6)
    labels = rendered(at)
    labels[np.isin(labels, list(COLOURS.values()))] = 0
    (d,) = recognizer(model).recognize(labels).detections
    found = {c.component: c for c in d.components}
    assert set(found) == {"team", "tip"} and np.degrees(abs(d.joints["tip"] - 0.6)) < 2.0
