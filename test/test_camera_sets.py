"""The shipped pendulum and soccer configurations on real camera frames that they were not trained on."""

from __future__ import annotations

import csv
import math
import os
from collections import Counter
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection
from artrec_ros.io.parameters.parameter_file import load_parameters

ROOT = Path(__file__).parents[1]
DATA = Path(os.environ.get("ARTREC_SHARED", ROOT.parent / "shared")) / "data"

needs_pendulum = pytest.mark.skipif(not (DATA / "pendulum").is_dir(), reason="the pendulum's frames are not here")
needs_vss = pytest.mark.skipif(not (DATA / "vss").is_dir(), reason="the soccer robots' frames are not here")


def truth_rows(every: int) -> list[dict[str, str]]:
    """Some frames of the truth; training used numbers 0, 3, 6, ..."""
    with open(DATA / "pendulum" / "ground_truth.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))[1::every]


def link_errors_deg(row: dict[str, str], found: Detection) -> list[float]:
    points = [(float(row[f"{n}_x"]), float(row[f"{n}_y"])) for n in "ABC"]
    theta = {c.component: c.theta for c in found.components}
    errors = []
    for name, (tail, head) in zip(("upper", "lower"), zip(points, points[1:], strict=False), strict=True):
        truth = math.atan2(head[1] - tail[1], head[0] - tail[0])
        errors.append(abs(math.degrees(math.remainder(theta[name] - truth, math.tau))))
    return errors


@needs_pendulum
@pytest.mark.parametrize("light", [1.0, 0.4])
def test_both_links_of_the_pendulum_point_where_the_truth_says(light: float):
    recognizer = load_parameters(ROOT / "config" / "pendulum.yaml").build()
    for row in truth_rows(every=9):
        image = cv2.imread(str(DATA / "pendulum" / row["file"]))
        result = recognizer.recognize(cv2.convertScaleAbs(image, alpha=light))
        assert [d.object for d in result.detections] == ["pendulum"], row["file"]
        assert max(link_errors_deg(row, result.detections[0])) < 2.0, row["file"]


@needs_pendulum
@pytest.mark.parametrize(("light", "size"), [(1.0, 1.0), (0.5, 1.0), (1.0, 0.5)])
def test_the_upper_links_direction_is_as_annotated_by_what_a_third_of_the_frames_taught(light: float, size: float):
    setup = load_parameters(ROOT / "config" / "pendulum.yaml")
    blank = tuple(int(v * size) for v in setup.image.blank)
    recognizer = replace(setup, image=replace(setup.image, blank=blank)).build()
    errors = []
    for row in truth_rows(every=3):
        image = cv2.resize(cv2.imread(str(DATA / "pendulum" / row["file"])), None, fx=size, fy=size)
        result = recognizer.recognize(cv2.convertScaleAbs(image, alpha=light))
        errors.append(link_errors_deg(row, result.detections[0]))
    upper, lower = np.median(errors, axis=0)
    assert upper <= 0.25 and lower <= 0.15


@needs_pendulum
def test_the_pendulums_labels_stand_a_change_of_light():
    segmenter = Segmenter(load_parameters(ROOT / "config" / "pendulum.yaml").image)
    image = cv2.imread(str(DATA / "pendulum" / truth_rows(every=9)[1]["file"]))
    bright = segmenter.labels(image)
    assert np.unique(bright).tolist() == [0, 1, 2, 3]
    for light in (0.3, 0.6, 1.4):
        labels = segmenter.labels(cv2.convertScaleAbs(image, alpha=light))
        assert np.count_nonzero(labels != bright) < 0.02 * np.count_nonzero(bright)


@needs_vss
def test_two_yellow_and_three_blue_robots_are_found_and_the_ball_is_none():
    recognizer = load_parameters(ROOT / "config" / "vss.yaml").build()
    frames = sorted((DATA / "vss" / "frames").glob("*.jpg"))[1::9]
    assert frames
    for path in frames:
        found = recognizer.recognize(cv2.imread(str(path))).detections
        assert Counter(d.object for d in found) == {"yellow": 2, "blue": 3}, path.name
        assert all(len(d.components) == 2 for d in found), path.name
