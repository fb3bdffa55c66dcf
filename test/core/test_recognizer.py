"""Whole frames of known truth."""

import dataclasses

import numpy as np
import pytest
from cranes import BLUE, CRANE, RED
from recognizers import SIZE, recognizer
from scene import Placed, capsule, crane, crane_placed, disc, draw, flag, polygon, rectangle, render

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.learning.pair_learning import learn
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target


def agrees(detection, placed, place_px=2.0, angle=0.08):
    """Every component of a detection lies on the truth's own, and none of the truth's is missing."""
    if {(c.component, c.marker) for c in detection.components} != set(placed):
        return False
    for c in detection.components:
        truth = placed[c.component, c.marker]
        turned = np.angle(np.exp(1j * (c.theta - truth.theta)))
        if np.hypot(c.x - truth.x, c.y - truth.y) > place_px or abs(turned) > angle:
            return False
        if abs(c.scale / truth.scale - 1) > 0.05:
            return False
    return True


def test_several_cranes_in_one_image_flanks_told_apart():
    rng = np.random.default_rng(3)
    engine = recognizer()
    for _ in range(3):
        truths = [
            crane_placed(
                x, rng.uniform(90, 150), rng.uniform(-3, 3), 40, tuple(rng.uniform(-0.4, 0.4, 2)), bool(rng.integers(2))
            )
            for x in (90, 210, 330)
        ]
        result = engine.recognize(render(SIZE, crane(), truths, RED))
        assert result.complete
        assert len(result.detections) == 3
        assert [d.id for d in result.detections] == [0, 1, 2]
        for truth in truths:
            assert sum(agrees(d, truth) for d in result.detections) == 1
        for d in result.detections:
            assert 0.7 < d.score <= 1
            assert d.components[0].component == "base"
            assert (d.image.x, d.image.scale) == (d.components[0].x, d.components[0].scale)


@pytest.mark.parametrize("shown", [RED, BLUE])
def test_a_component_with_alternative_classes_is_found_in_each(shown):
    base, fore, aft = crane().components
    coloured = ObjectModel("crane", (base, dataclasses.replace(fore, label=shown), aft))
    either = dataclasses.replace(fore, classes={"red": RED, "blue": BLUE})
    truth = crane_placed(150, 110, 0.2, 55)
    labels = render(SIZE, coloured, [truth], RED)
    result = recognizer(Target("crane", ObjectModel("crane", (base, either, aft)), RED, CRANE)).recognize(labels)
    assert len(result.detections) == 1 and agrees(result.detections[0], truth)
    plain = recognizer(Target("crane", crane(), RED, CRANE)).recognize(labels).detections
    assert ("fore" in {c.component for c in plain[0].components}) == (shown == RED)


def test_components_that_merge_into_one_blob():
    swings = (0.35, -0.35)  # the bars cross, and one reaches the base
    truth = crane_placed(200, 90, 0.1, 70, swings)
    for key, place in list(truth.items()):
        if key[0] == "fore":
            truth[key] = place.moved(-0.12, -0.1, 0.0)
    labels = render(SIZE, crane(), [truth], RED)
    result = recognizer().recognize(labels)
    assert len(result.detections) == 1
    assert {c.component for c in result.detections[0].components} == {"base", "fore", "aft"}


def test_a_missing_component_lowers_the_score_and_a_false_positive_changes_nothing():
    engine = recognizer()
    truth = crane_placed(150, 110, 0.2, 55)
    whole = engine.recognize(render(SIZE, crane(), [truth], RED)).detections[0]
    stray = {("fore", "bar"): Placed(340, 60, 1.0, 55)}
    with_stray = engine.recognize(render(SIZE, crane(), [truth, stray], RED)).detections
    assert len(with_stray) == 1 and agrees(with_stray[0], truth)
    del truth["aft", "bar"]
    less = engine.recognize(render(SIZE, crane(), [truth], RED)).detections
    assert len(less) == 1 and agrees(less[0], truth)
    assert less[0].score < whole.score


def test_a_base_alone_is_rejected_with_the_constraint_that_fails():
    engine = recognizer()
    truth = crane_placed(150, 110, 0.2, 55)
    lonely = {key: place for key, place in truth.items() if key[0] == "base"}
    result = engine.recognize(render(SIZE, crane(), [lonely], RED))
    assert result.detections == ()
    assert "base" in result.rejected[0].reason and "fore or aft" in result.rejected[0].reason
    far = {**lonely, ("fore", "bar"): truth["fore", "bar"].moved(1.2, 0.0, 0.0)}
    result = engine.recognize(render(SIZE, crane(), [far], RED))
    assert result.detections == ()
    reason = next(r.reason for r in result.rejected if "outside" in r.reason)
    assert "distance_m" in reason or "bearing_rad" in reason
    alone = recognizer(min_components=1).recognize(render(SIZE, crane(), [lonely], RED))
    assert len(alone.detections) == 1
    assert alone.detections[0].score < 0.7


def test_a_large_blob_that_no_outline_fits_is_told_and_none_that_an_object_explains():
    labels = render(SIZE, crane(), [truth := crane_placed(150, 110, 0.2, 55)], RED)
    y, x = np.indices(labels.shape)
    labels[np.hypot(x - 360, y - 190) < 26] = RED
    result = recognizer().recognize(labels)
    assert len(result.detections) == 1 and agrees(result.detections[0], truth)
    told = [r for r in result.rejected if "no outline of 'base' fits this blob of" in r.reason]
    assert len(told) == 1 and np.hypot(told[0].x - 360, told[0].y - 190) < 1
    assert not [r for r in result.rejected if r is not told[0] and "blob" in r.reason]


@pytest.mark.parametrize("profile", ["default", "paper"])
def test_that_no_outline_fits_is_not_said_where_one_does(profile):
    """Though nothing else is told of it, as of a base that the paper's profile groups with none."""
    lonely = {("base", "flag"): Placed(150, 110, 0.2, 55)}
    result = recognizer(profile=profile, min_components=3).recognize(render(SIZE, crane(), [lonely], RED))
    assert result.detections == () and not any("no outline" in r.reason for r in result.rejected)


def test_a_contested_component_goes_where_it_belongs():
    rng = np.random.default_rng(0)
    model = ObjectModel(
        "pair", (Component("base", (flag(),), required=True), Component("bar", (rectangle("bar", 0.8, 0.16),)))
    )
    rows = [
        {
            ("base", "flag"): (base := Placed(0, 0, rng.uniform(-3, 3), 50)),
            ("bar", "bar"): base.moved(rng.uniform(0.7, 2.2), 0, np.pi / 2),
        }
        for _ in range(40)
    ]
    engine = recognizer(Target("pair", model, RED, learn(model, rows)))
    left = Placed(70, 120, 0.0, 45)
    right = Placed(160, 120, 0.0, 45)
    own = left.moved(0.9, 0, np.pi / 2)
    also = right.moved(1.2, 0, np.pi / 2)
    labels = render(
        SIZE,
        model,
        [{("base", "flag"): left, ("bar", "bar"): own}, {("base", "flag"): right, ("bar", "bar"): also}],
        RED,
    )
    result = engine.recognize(labels)
    assert len(result.detections) == 2
    bars = sorted(c.x for d in result.detections for c in d.components if c.component == "bar")
    np.testing.assert_allclose(bars, [own.x, also.x], atol=1.5)
    one_bar = render(SIZE, model, [{("base", "flag"): left, ("bar", "bar"): own}, {("base", "flag"): right}], RED)
    result = engine.recognize(one_bar)
    assert len(result.detections) == 1  # it cannot serve two


def test_targets_of_one_label_share_no_pixels_and_colours_are_kept_apart():
    truths = [crane_placed(110, 120, 0.3, 50), crane_placed(300, 110, -2.0, 50)]
    labels = render(SIZE, crane(), truths[:1], RED) + render(SIZE, crane(), truths[1:], BLUE)
    red, blue = Target("red", crane(), RED, CRANE), Target("blue", crane(), BLUE, CRANE)
    result = recognizer(red, blue).recognize(labels)
    assert {d.object: agrees(d, t) for d, t in zip(result.detections, truths, strict=True)} == {
        "red": True,
        "blue": True,
    }
    twin = dataclasses.replace(red, name="twin")
    assert len(recognizer(red, twin).recognize(labels).detections) == 1


def robots():
    """Two squares that touch at a corner, each of its own class."""
    square = rectangle("patch", 1.0, 1.0)
    model = ObjectModel("robot", (Component("team", (square,), required=True), Component("accent", (square,), label=5)))
    rng = np.random.default_rng(0)
    rows = []
    for _ in range(20):
        team = Placed(0, 0, rng.uniform(-3, 3), 12)
        rows.append({("team", "patch"): team, ("accent", "patch"): team.moved(1, 1, 0)})
    return model, learn(model, rows)


def test_tiny_squares_take_their_heading_from_each_other():
    model, constraints = robots()
    rng = np.random.default_rng(5)
    truths = []
    for x in (60, 140, 220, 300, 370):
        team = Placed(x + rng.uniform(-9, 9), rng.uniform(40, 200), rng.uniform(-np.pi, np.pi), 12.5)
        truths.append({("team", "patch"): team, ("accent", "patch"): team.moved(1, 1, 0)})
    labels = render(SIZE, model, truths, RED)
    result = recognizer(Target("robot", model, RED, constraints)).recognize(labels)
    assert len(result.detections) == 5
    for truth in truths:
        assert sum(agrees(d, truth, 1.0, 0.2) for d in result.detections) == 1


def test_double_pendulum_alike_links_are_told_apart_by_their_discs():
    link, spot = capsule("link", 0.14, 1.0), disc("spot", 0.1)
    model = ObjectModel(
        "pendulum",
        (
            Component("lower", (link,), required=True),
            Component("joint", (spot,), label=5),
            Component("tip", (spot,), label=6),
            Component("upper", (link,)),
        ),
    )
    rng = np.random.default_rng(1)

    def pendulum(x, y, upper, lower, scale):
        pivot = Placed(x, y, upper, scale)
        joint = pivot.moved(1, 0, lower - upper)
        return {
            ("upper", "link"): pivot.moved(0.5, 0, 0),
            ("lower", "link"): joint.moved(0.5, 0, 0),
            ("joint", "spot"): joint,
            ("tip", "spot"): joint.moved(1, 0, 0),
        }

    rows = [pendulum(0, 0, a, a + rng.uniform(-2, 2), 80) for a in rng.uniform(-3, 3, 40)]
    engine = recognizer(Target("pendulum", model, RED, learn(model, rows)))
    for upper, bend in ((0.3, 1.0), (2.0, -0.6), (-2.5, 0.0), (1.0, 1.9)):
        truth = pendulum(210, 120, upper, upper + bend, 55)
        order = [("upper", "link"), ("lower", "link"), ("joint", "spot"), ("tip", "spot")]
        result = engine.recognize(render(SIZE, model, [{k: truth[k] for k in order}], RED))
        assert len(result.detections) == 1
        found = {c.component: c for c in result.detections[0].components}
        for name in ("upper", "lower"):
            assert abs(np.angle(np.exp(1j * (found[name].theta - truth[name, "link"].theta)))) < 0.04
        assert {"joint", "tip"} <= set(found)


def test_a_single_component_object_needs_no_constraints():
    model = ObjectModel("sign", (Component("sign", (flag(),), required=True),))
    labels = np.zeros(SIZE[::-1], np.uint8)
    truth = Placed(100, 100, 0.4, 50)
    draw(labels, flag(), truth, RED)
    result = recognizer(Target("sign", model, RED)).recognize(labels)
    assert len(result.detections) == 1 and agrees(result.detections[0], {("sign", "flag"): truth})


def test_of_an_object_that_occurs_once_the_likeliest_is_told():
    labels = np.zeros(SIZE[::-1], np.uint8)
    draw(labels, flag(), Placed(100, 100, 0.4, 50), RED)
    draw(labels, flag(), Placed(300, 120, 1.4, 50), RED)
    labels[:, 310:316] = 0
    model = ObjectModel("sign", (Component("sign", (flag(),), required=True),))
    both = recognizer(Target("sign", model, RED), min_alone_match=0.6).recognize(labels)
    assert len(both.detections) == 2
    once = Target("sign", dataclasses.replace(model, unique=True), RED)
    result = recognizer(once, min_alone_match=0.6).recognize(labels)
    assert [round(d.image.x) for d in result.detections] == [100]
    (other,) = [r for r in result.rejected if "occurs once" in r.reason]
    assert round(other.x) == pytest.approx(300, abs=5)


def test_what_lies_beyond_the_image_explains_nothing():
    """Turned by a quarter and larger, two sides out of the image, the plate matches three of its own sides."""
    notch = (-15.4, -43), (-15.4, -38), (-6, -38), (-6, -43)
    plate = polygon("plate", (-37, -43), *notch, (37, -43), (37, 43), (-37, 43), axis=((-1, 0), (1, 0)))
    model = ObjectModel("plate", (Component("plate", (plate,), required=True),))
    labels = np.zeros((156, 156), np.uint8)
    draw(labels, plate, Placed(78, 78, 0.0, 1.5), RED)
    (found,) = recognizer(Target("plate", model, RED)).recognize(labels).detections
    assert found.score > 0.9 and found.image.scale == pytest.approx(1.5, rel=0.01)
    assert np.angle(np.exp(1j * found.image.theta)) == pytest.approx(0, abs=0.02)


def test_an_object_that_nothing_supports_must_match_well():
    model = ObjectModel("sign", (Component("sign", (flag(),), required=True),))
    labels = np.zeros(SIZE[::-1], np.uint8)
    draw(labels, flag(), Placed(120, 100, 0.0, 90), RED)
    labels[:, 140:] = 0  # a quarter of its outline is hidden
    strict, lenient = (
        recognizer(Target("sign", model, RED), min_alone_match=share).recognize(labels).detections
        for share in (0.9, 0.6)
    )
    assert len(strict) == 0
    assert len(lenient) == 1


def test_a_blob_that_stays_unexplained_refutes_what_was_found_in_it():
    bar = rectangle("bar", 1.0, 0.2)
    model = ObjectModel("stick", (Component("stick", (bar,), required=True),))
    labels = np.zeros(SIZE[::-1], np.uint8)
    draw(labels, bar, Placed(90, 120, 0.0, 80), RED)
    angle = np.linspace(0, 2 * np.pi, 80, endpoint=False)
    radius = np.where(np.arange(80) % 4 < 2, 1.0, 0.6)
    star = polygon("star", *zip(radius * np.cos(angle), radius * np.sin(angle), strict=True))
    draw(labels, star, Placed(230, 120, 0.0, 105), RED)
    counts = [
        len(
            recognizer(Target("stick", model, RED), min_explained=share, min_alone_match=0.6)
            .recognize(labels)
            .detections
        )
        for share in (0.0, 0.5)
    ]
    assert counts == [1, 0]


def test_paper_profile_finds_what_is_plain_and_much_besides():
    """Literally the published method: right poses are among its finds, and so are many others."""
    truth = crane_placed(200, 120, 0.0, 60)
    rows = [crane_placed(0, 0, 0.0, 60, (a, b)) for a in (-0.2, 0.2) for b in (-0.2, 0.2)]
    labels = render(SIZE, crane(), [truth], RED)
    paper = recognizer(Target("crane", crane(), RED, learn(crane(), rows)), profile="paper").recognize(labels)
    assert any(np.hypot(d.image.x - 200, d.image.y - 120) < 5 for d in paper.detections)
    strict = recognizer(Target("crane", crane(), RED, learn(crane(), rows)), profile="paper", paper_match=0.97)
    assert len(strict.recognize(labels).detections) < len(paper.detections)
    for d in paper.detections:
        names = [c.component for c in d.components]
        assert "base" in names and len(set(names)) == len(names)


def test_flat_objects_are_placed_by_their_size_where_the_camera_is_calibrated():
    """Profile paper stays literal, and what has no calibration has no place in space."""
    truth = crane_placed(200, 120, 0.3, 40, (0.2, -0.2), False)
    image = render(SIZE, crane(), [truth], RED)
    camera = Camera(np.array([[400.0, 0, 210], [0, 400, 120], [0, 0, 1]]), np.zeros(0), SIZE)
    (d,) = recognizer().recognize(image, camera).detections
    assert d.pose_from == "size" and d.pose_covariance.shape == (6, 6)
    assert d.pose.position[2] == pytest.approx(400 / 40, rel=0.05)
    np.testing.assert_allclose(d.pose.rotation[:, 2], (0, 0, -1), atol=1e-9)  # its marker's front is towards the camera
    (same,) = recognizer().recognize(image).detections
    assert same.pose is None and same.image == d.image and same.components == d.components
    assert all(d.pose is None for d in recognizer(profile="paper").recognize(image, camera).detections)
