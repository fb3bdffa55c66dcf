"""The scale that marked images tell, of a leg of lamps whose radii are badly known."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from artrec_ros.core.learning.fixed_distances import fixed_distances
from artrec_ros.core.model.objects import ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.io.learned.marked_scales import beyond_marks_px, marked_scales
from artrec_ros.io.objects.object_reader import load_object

LEG = """
format: artrec_object/1
name: leg
markers: {lamp: {disc: {radius: 0.06}}}
components:
  hip: {required: true, markers: {lamp: {pose: {xyz: [0, 0, 0]}}}}
  knee: {markers: {lamp: {pose: {xyz: [0, -0.6, 0]}}}}
  ankle:
    markers: {lamp: {pose: {xyz: [0, -0.5, 0]}}}
    joint: {parent: knee, origin: {xyz: [0, -0.6, 0]}, axis: AXIS, limits: [-1.3, 0.2]}
"""
HIP, KNEE, ANKLE = ((name, "lamp") for name in ("hip", "knee", "ankle"))
SCALE, RADIUS_PX = 100.0, 5.0  # px/m; the file has 6 px, so discs alone tell 83 px/m


def leg(folder: Path, axis: str = "[0, 0, 1]") -> ObjectModel:
    (folder / "leg.yaml").write_text(LEG.replace("AXIS", axis))
    return load_object(folder / "leg.yaml")


def test_distances_are_fixed_where_no_joint_changes_them(tmp_path: Path) -> None:
    assert fixed_distances(leg(tmp_path)) == {(HIP, KNEE): pytest.approx(0.6), (KNEE, ANKLE): pytest.approx(0.5)}


def test_what_is_not_flat_shows_no_distance_as_it_is(tmp_path: Path) -> None:
    assert fixed_distances(leg(tmp_path, "[1, 0, 0]")) == {}


def test_the_distances_of_lamps_tell_the_scale_rather_than_their_radii(tmp_path: Path) -> None:
    bent = 0.7 * np.pi
    middles = np.array([[50, 50], [50, 110], [50 + 50 * np.cos(bent), 110 - 50 * np.sin(bent)]])
    ends = (middles[:, None] + RADIUS_PX * np.array([[-1, 0], [1, 0]])).reshape(-1, 2)
    keypoints = [f"{name}/lamp.{end}" for name in ("hip", "knee", "ankle") for end in ("tail", "head")]
    content = {
        "images": [{"id": 1, "file_name": "a.png"}],
        "categories": [{"id": 1, "name": "leg", "keypoints": keypoints}],
        "annotations": [{"image_id": 1, "category_id": 1, "keypoints": [v for x, y in ends for v in (x, y, 2)]}],
    }
    (tmp_path / "coco.json").write_text(json.dumps(content))
    coco = tmp_path / "coco.json"
    assert marked_scales([coco], [Target("leg", leg(tmp_path), 1)]) == pytest.approx([SCALE])
    assert beyond_marks_px([coco], [Target("leg", leg(tmp_path), 1)]) == {1: pytest.approx(0.06 * SCALE - 5, rel=0.01)}
    assert beyond_marks_px([coco], [Target("leg", leg(tmp_path, "[1, 0, 0]"), 1)]) == {}
