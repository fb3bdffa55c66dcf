"""The recogniser with any image and any parameters: what it refuses, what ends a search, what it leaves alone."""

import numpy as np
import pytest
from cranes import CRANE, RED
from recognizers import SIZE, recognizer
from scene import crane, crane_placed, flag, render
from settings import settings

from artrec_ros.core.base.errors import ConfigError, ImageError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.model.frame_result import Rejection
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import _in_image
from artrec_ros.io.parameters.specs import all_specs


def test_the_limit_that_ended_a_search_is_named():
    """Three cranes that touch, and one node for each choice: there is time enough, and more of it would not help."""
    labels = render(SIZE, crane(), [crane_placed(x, 120, 0.2, 40) for x in (140, 200, 260)], RED)
    assert recognizer(time_budget_ms=60000).recognize(labels).ended_by == ()
    cut = recognizer(time_budget_ms=60000, search_nodes=1).recognize(labels)
    assert cut.ended_by == ("expert.grouping.search_nodes",) and not cut.complete and cut.timing_ms["total"] < 60000
    late = recognizer(time_budget_ms=1).recognize(labels)
    assert "recognizer.time_budget_ms" in late.ended_by
    assert {*cut.ended_by, *late.ended_by} <= set(all_specs([], []))


def test_that_time_ended_before_all_blobs_were_found_is_named():
    large = np.zeros((4000, 4000), np.uint16)
    large[:240, :320] = RED
    late = recognizer(profile="paper", time_budget_ms=1).recognize(large)
    assert late.ended_by == ("recognizer.time_budget_ms",)


@pytest.mark.parametrize("profile", ["default", "paper"])
def test_any_label_image_gives_a_result(profile):
    rng = np.random.default_rng(0)
    rows, columns = np.indices((240, 320))
    engine = recognizer(profile=profile, time_budget_ms=150)
    images = {
        "noise": rng.integers(0, 8, (240, 320)), "two": rng.integers(2, 4, (240, 320)),
        "full": np.full((240, 320), RED), "stripes": rows % 2 * RED, "checks": (rows + columns) % 2 * RED,
        "one": np.full((1, 1), RED),
        "row": np.full((1, 90), RED), "column": np.full((90, 1), RED), "empty": np.zeros((240, 320)),
        "others": np.full((240, 320), 9), "rings": ((np.hypot(rows - 120, columns - 160) % 9) < 4) * RED,
        "sixteen": rng.integers(0, 60000, (50, 60)).astype(np.uint16),
    }  # fmt: skip
    for name, image in images.items():
        image = image if image.dtype == np.uint16 else image.astype(np.uint8)
        result = engine.recognize(image)
        assert result.size == image.shape[::-1], name
        assert set(result.ended_by) <= {"recognizer.time_budget_ms"}, name
        assert all(0 <= d.score <= 1 for d in result.detections), name


def test_noise_invents_nothing_in_the_default_profile():
    rng = np.random.default_rng(1)
    for _ in range(3):
        assert recognizer().recognize(rng.integers(0, 8, (160, 208)).astype(np.uint8)).detections == ()


def test_timing_names_every_stage_and_labels_are_kept():
    labels = render(SIZE, crane(), [crane_placed(150, 110, 0.2, 55)], RED)
    result = recognizer().recognize(labels)
    assert set(result.timing_ms) == {"segmentation", "blobs", "alignment", "grouping", "pose", "total"}
    assert result.timing_ms["total"] >= result.timing_ms["alignment"] > 0
    np.testing.assert_array_equal(result.labels, labels)


def test_results_do_not_depend_on_what_came_before():
    engine = recognizer()
    labels = render(SIZE, crane(), [crane_placed(150, 110, 0.2, 55)], RED)
    first = engine.recognize(labels)
    engine.recognize(np.zeros((50, 50), np.uint8))
    again = engine.recognize(labels)
    assert again.detections == first.detections
    assert again.rejected == first.rejected


def test_what_does_not_fit_is_refused():
    with pytest.raises(ImageError):
        recognizer().recognize(np.zeros((10, 10, 3), np.uint8))
    with pytest.raises(ConfigError, match="crane, crane"):
        recognizer(Target("crane", crane(), 1), Target("crane", crane(), 2))
    other = ObjectModel("other", (Component("base", (flag(),), required=True),))
    with pytest.raises(ConfigError, match="fore/bar"):
        recognizer(Target("other", other, 1, CRANE))


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"anchor_tolerances_px": ()}, "anchor_tolerances_px"),
        ({"couple_spans": ()}, "couple_spans"),
        ({"min_scale": 50, "max_scale": 40}, "max_scale"),
        ({"min_match": 1.5}, "min_match"),
        ({"profile": "fast"}, "profile"),
    ],
)
def test_parameters_that_make_no_sense_are_refused(options, named):
    with pytest.raises(ConfigError, match=named):
        settings(**options)


@pytest.mark.parametrize(
    ("options", "scales"),
    [
        ({}, [40, 60]),
        ({"max_range_m": 6.0}, [60]),  # focal length 300 px: at 7.5 m and at 5 m
        ({"min_range_m": 6.0}, [40]),
        ({"max_scale": 50.0}, [40]),
        ({"min_range_m": 4.0, "max_range_m": 8.0}, [40, 60]),
    ],
)
def test_objects_are_looked_for_within_limits_of_range(options, scales):
    truths = [crane_placed(x, 120, 0.3, k, (0.1, -0.2), False) for x, k in ((100, 40), (300, 60))]
    labels = render((420, 240), crane(), truths, RED)
    camera = Camera(np.diag([300.0, 300.0, 1.0]), np.zeros(0), (420, 240))
    found = recognizer(**options).recognize(labels, camera).detections
    assert sorted(round(d.image.scale, -1) for d in found) == scales
    without = recognizer(**options).recognize(labels).detections
    assert len(without) == (1 if "max_scale" in options else 2)


def test_what_is_turned_down_has_its_place_in_the_image():
    far = [Rejection("thing", "it is not there", 0.1, x, y) for x, y in ((-3e5, 20.0), (400.0, 1e9), (30.5, 40.5))]
    assert [(r.x, r.y) for r in _in_image(far, (320, 240))] == [(0.0, 20.0), (319, 239), (30.5, 40.5)]
