"""COCO keypoints: the similarity that two points fix, selection, and mistakes."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from changes import changed
from scene import apply_similarity

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.transforms import wrap_angle
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.io.learned.annotations import instance_from_axis, load_coco

FLAG = Marker("flag", np.array([[0, 0], [0.4, 0], [0.3, 0.1], [0.4, 0.2], [0, 0.2]]), [0.05, 0.02], [0.1, 0.17])
MODEL = ObjectModel("toy", (Component("base", (FLAG,), required=True), Component("arm", (FLAG,))))

COCO: dict[str, Any] = {
    "info": {"made by": "a test"},
    "images": [{"id": 7, "file_name": "a.png"}, {"id": 8, "file_name": "sub/b.png"}],
    "categories": [
        {"id": 1, "name": "red", "keypoints": ["base/flag.tail", "base/flag.head", "arm/flag.tail", "arm/flag.head"]},
        {"id": 2, "name": "cat", "keypoints": ["nose"]},
        {"id": 3, "name": "box"},
    ],
    "annotations": [
        {"image_id": 7, "category_id": 1, "keypoints": [1, 2, 2, 5, 2, 1, 0, 0, 0, 0, 0, 0]},
        {"image_id": 8, "category_id": 1, "keypoints": [1, 2, 2, 5, 2, 2, 9, 9, 2, 9, 5, 2], "iscrowd": 0},
        {"image_id": 8, "category_id": 1, "keypoints": [1, 2, 2, 0, 0, 0, 9, 9, 2, 9, 5, 2]},
        {"image_id": 8, "category_id": 1, "keypoints": [], "iscrowd": 1},
        {"image_id": 8, "category_id": 2, "keypoints": [4, 4, 2]},
        {"image_id": 8, "category_id": 3, "bbox": [0, 0, 1, 1]},
    ],
}


def _write(folder: Path, content: Any, name: str = "coco.json") -> Path:
    path = folder / name
    path.write_text(json.dumps(content))
    return path


def test_crowds_are_counted_by_category(tmp_path: Path) -> None:
    annotations = load_coco([_write(tmp_path, COCO)])
    assert annotations.crowds == ("red",) and annotations.of(["cat"]).crowds == ()


def test_a_category_without_keypoints_is_told_as_such(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="category 'box': has no keypoints"):
        load_coco([_write(tmp_path, COCO)]).of(["box"])


@pytest.mark.parametrize("table", ["images", "categories"])
def test_an_id_that_is_there_twice_is_told(table: str, tmp_path: Path) -> None:
    rows = [*COCO[table], {**COCO[table][0], "file_name": "c.png", "name": "dog"}]
    with pytest.raises(ConfigError, match=rf"coco.json: {table}\[{len(rows) - 1}\].id: the id \d is there twice"):
        load_coco([_write(tmp_path, {**COCO, table: rows})])


def test_a_missing_file_is_named_once(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        load_coco([tmp_path / "none.json"])
    assert str(caught.value).count("none.json") == 1


def test_a_key_that_is_given_twice_is_told(tmp_path: Path) -> None:
    path = tmp_path / "coco.json"
    path.write_text(json.dumps(COCO)[:-1] + ', "images": []}')
    with pytest.raises(ConfigError, match=r"coco.json: the key 'images' is given twice in one object; keep one"):
        load_coco([path])


def test_two_points_give_back_the_similarity() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        x, y, turn, k = rng.uniform(0, 300), rng.uniform(0, 300), rng.uniform(-3, 3), rng.uniform(20, 500)
        T = np.array([[x, y, turn, k]])
        ends = (np.stack([FLAG.tail, FLAG.head]) - FLAG.centroid) * (1, -1)
        tail_px, head_px = apply_similarity(T, ends)[0]
        found = instance_from_axis("base", FLAG, tail_px, head_px)
        assert (found.x, found.y, found.scale) == pytest.approx((x, y, k))
        assert wrap_angle(found.theta - turn - FLAG.axis_angle) == pytest.approx(0, abs=1e-9)


def test_examples_of_a_category(tmp_path: Path) -> None:
    annotations = load_coco([_write(tmp_path, COCO)])
    assert set(annotations.categories) == {"red", "cat"}
    red = annotations.of(["red"])
    assert [o.image for o in red.objects] == [tmp_path / "a.png", tmp_path / "sub/b.png", tmp_path / "sub/b.png"]
    base, arm = ("base", "flag"), ("arm", "flag")
    first, second, third = red.examples(MODEL)
    assert (set(first), set(second), set(third)) == ({base}, {base, arm}, {arm})
    assert red.half_labelled() == 1
    assert first[base].theta == pytest.approx(0)  # to the right
    assert second[arm].theta == pytest.approx(-np.pi / 2)  # up: y is down
    assert first[base].scale == pytest.approx(4 / np.hypot(0.05, 0.15))


def test_files_add_up(tmp_path: Path) -> None:
    paths = [_write(tmp_path, COCO), _write(tmp_path, COCO, "more.json")]
    assert len(load_coco(paths).of(["red"]).objects) == 6
    other = copy.deepcopy(COCO)
    other["categories"][0]["keypoints"].reverse()
    with pytest.raises(ConfigError, match="other.json.*'red'.*differ"):
        load_coco([paths[0], _write(tmp_path, other, "other.json")])


def test_unknown_names_come_with_the_nearest(tmp_path: Path) -> None:
    annotations = load_coco([_write(tmp_path, COCO)])
    with pytest.raises(ConfigError, match="'rad'.*'red'"):
        annotations.of(["rad"])
    with pytest.raises(ConfigError, match="'nose'.*'cat'.*--category"):
        annotations.examples(MODEL)
    content = copy.deepcopy(COCO)
    content["categories"][0]["keypoints"][0] = "base/flg.tail"
    with pytest.raises(ConfigError, match="'base/flg.tail'.*'base/flag.tail'"):
        load_coco([_write(tmp_path, content)]).of(["red"]).examples(MODEL)


def test_an_axis_without_length_names_its_annotation(tmp_path: Path) -> None:
    content = copy.deepcopy(COCO)
    content["annotations"][1]["keypoints"][3:5] = [1, 2]
    with pytest.raises(ConfigError, match=r"coco.json: annotations\[1\] \(.*\): base/flag: .*same point"):
        load_coco([_write(tmp_path, content)]).of(["red"]).examples(MODEL)


@pytest.mark.parametrize(
    ("change", "value", "parts"),
    [
        ("images", None, ("images", "missing")),
        ("annotations", {}, ("annotations", "list")),
        ("annotations/0/image_id", 9, ("annotations[0].image_id", "9")),
        ("annotations/0/category_id", 9, ("annotations[0].category_id", "9")),
        ("annotations/0/keypoints", [1, 2, 2], ("annotations[0].keypoints", "12 numbers", "has 3")),
        ("annotations/0/keypoints/2", 3, ("annotations[0].keypoints[2]", "visibility", "base/flag.tail")),
        ("annotations/0/keypoints/0", "x", ("annotations[0].keypoints[0]", "number")),
        ("annotations/0/keypoints/0", float("nan"), ("annotations[0].keypoints[0]", "finite")),
        ("categories/0/name", None, ("categories[0]", "name", "missing")),
        ("categories/0/keypoints/1", "base/flag.tail", ("categories[0].keypoints", "twice")),
    ],
)
def test_mistakes_are_refused_by_their_place(tmp_path: Path, change: str, value: Any, parts: tuple[str, ...]) -> None:
    path = _write(tmp_path, changed(COCO, change, value))
    with pytest.raises(ConfigError) as caught:
        load_coco([path])
    for part in (str(path), *parts):
        assert part in str(caught.value)


def test_what_is_no_json_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bad.json"
    path.write_text('{"images": [,]}')
    with pytest.raises(ConfigError, match="bad.json: line 1: is no valid JSON"):
        load_coco([path])
    path.write_text("[" * 100000)
    with pytest.raises(ConfigError, match="bad.json"):
        load_coco([path])
