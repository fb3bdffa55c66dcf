"""Regions of classes from axes that were annotated for training: outlines, classes, what is ignored."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.config import PlaneConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.field_plane import FieldPlane
from artrec_ros.core.model.target import Target
from artrec_ros.io.learned.marked_objects import REST, load_marked_objects
from artrec_ros.io.objects.object_reader import load_object

OBJECT = """
format: artrec_object/1
name: robot
markers:
  team: {outline: [[0, -1], [2, -1], [2, 1], [0, 1]], axis: [[0, 0], [2, 0]]}
  patch: {outline: [[-2, -1], [0, -1], [0, 1], [-2, 1]], axis: [[-2, 0], [0, 0]]}
components:
  team: {required: true, markers: {team: {}}}
  patch: {classes: {g: 3, r: 4}, markers: {patch: {}}}
identities: {green: {patch: g}, crimson: {patch: r}}
"""
NAMES = {1: "yellow", 2: "blue", 3: "green", 4: "red"}
KEYPOINTS = ["team/team.tail", "team/team.head", "patch/patch.tail", "patch/patch.head"]
PLACED = [30, 20, 2, 30, 10, 2, 30, 30, 2, 30, 20, 2]  # five pixels a metre; ahead is up in the image


@pytest.fixture
def targets(tmp_path: Path) -> list[Target]:
    (tmp_path / "robot.yaml").write_text(OBJECT)
    model = load_object(tmp_path / "robot.yaml", {})
    return [Target("yellow", model, 1), Target("blue", model, 2)]


def coco(
    folder: Path, *annotations: dict[str, Any], categories: tuple[str, ...] = ("yellow",), name: str = "a"
) -> Path:
    cv2.imwrite(str(folder / "a.png"), np.zeros((40, 60, 3), np.uint8))
    content = {
        "images": [{"id": 7, "file_name": "a.png"}],
        "categories": [{"id": n, "name": c, "keypoints": KEYPOINTS} for n, c in enumerate(categories, 1)],
        "annotations": [{"image_id": 7, "category_id": 1, "keypoints": PLACED, **a} for a in annotations],
    }
    path = folder / f"{name}.json"
    path.write_text(json.dumps(content))
    return path


def numbers() -> dict[str, int]:
    return {REST: 0} | {name: label for label, name in NAMES.items()}


def test_outlines_lie_where_the_axes_put_them(tmp_path: Path, targets: list[Target]) -> None:
    path = coco(tmp_path, {"attributes": {"identity": "green"}})
    (marked,) = load_marked_objects([path], targets, NAMES)
    found = {name: {tuple(p) for p in np.round(outline, 6).tolist()} for name, outline in marked.regions}
    assert found == {
        "yellow": {(25, 20), (25, 10), (35, 10), (35, 20)},
        "green": {(25, 30), (25, 20), (35, 20), (35, 30)},
    }
    labels = marked.read(numbers(), 255)[1]
    assert labels[15, 30] == 1 and labels[25, 30] == 3 and labels[5, 5] == 0
    assert np.count_nonzero(labels) == 11 * 21


@pytest.mark.parametrize(
    "category, attributes, team, patch",
    [
        ("blue", {"identity": "crimson"}, "blue", "red"),
        ("blue_green", {}, "blue", "green"),
        ("yellow", {"patch": "r"}, "yellow", "red"),
    ],
)
def test_category_and_attributes_tell_the_classes(tmp_path, targets, category, attributes, team, patch) -> None:
    path = coco(tmp_path, {"attributes": attributes}, categories=(category,))
    (marked,) = load_marked_objects([path], targets, NAMES)
    assert [name for name, _ in marked.regions] == [team, patch]


@pytest.mark.parametrize("told", [{"attributes": {"identity": "r"}}, {"attributes": {"patch": "r"}}])
def test_where_no_identities_are_declared_all_may_be_named(tmp_path: Path, told: dict[str, Any]) -> None:
    (tmp_path / "robot.yaml").write_text(OBJECT.replace("identities: {green: {patch: g}, crimson: {patch: r}}", ""))
    target = Target("yellow", load_object(tmp_path / "robot.yaml", {}), 1)
    (marked,) = load_marked_objects([coco(tmp_path, told)], [target], NAMES)
    assert [name for name, _ in marked.regions] == ["yellow", "red"]


def test_an_identitys_name_alone_will_do_where_one_object_has_it(tmp_path: Path, targets: list[Target]) -> None:
    path = coco(tmp_path, {}, categories=("crimson",))
    (marked,) = load_marked_objects([path], targets[1:], NAMES)
    assert [name for name, _ in marked.regions] == ["blue", "red"]
    with pytest.raises(ConfigError, match="'crimson' could be any of several objects"):
        load_marked_objects([path], targets, NAMES)


@pytest.mark.parametrize(
    "annotation, category, words",
    [
        ({}, "yellow", "the class of component 'patch' is not told.*identity.*known: g, r"),
        ({"attributes": {"identity": "gren"}}, "yellow", "no identity 'gren'; did you mean 'green'"),
        (
            {"attributes": {"patch": "x"}},
            "yellow",
            "the class of component 'patch' is told as 'x'.*known: g, r",
        ),
        ({"attributes": {"identity": "green"}}, "yelow", "category 'yelow' is no object.*did you mean 'yellow'"),
    ],
)
def test_what_does_not_tell_a_class_is_refused(tmp_path, targets, annotation, category, words) -> None:
    with pytest.raises(ConfigError, match=rf"a.json: annotations\[0\] \(.*\): .*{words}"):
        load_marked_objects([coco(tmp_path, annotation, categories=(category,))], targets, NAMES)


def test_crowds_half_marked_objects_and_what_is_far_are_no_background(tmp_path: Path, targets: list[Target]) -> None:
    half = {"keypoints": [*PLACED[:6], *[0] * 6], "bbox": [24, 9, 12, 22]}
    crowd = {"iscrowd": 1, "bbox": [50, 0, 5, 5], "keypoints": [0] * 12}
    path = coco(tmp_path, half, crowd)
    (marked,) = load_marked_objects([path], targets, NAMES)
    labels = marked.read(numbers(), 255)[1]
    assert labels[15, 30] == 1 and labels[25, 30] == 255 and labels[2, 52] == 255 and labels[2, 45] == 0
    (marked,) = load_marked_objects([path], targets, NAMES, around_px=6)
    labels = marked.read(numbers(), 255)[1]
    assert labels[15, 40] == 0 and labels[15, 43] == 255 and labels[15, 30] == 1


def test_markers_without_keypoints_are_not_annotated_either(tmp_path: Path, targets: list[Target]) -> None:
    """Their object's box is no background, as where all keypoints are listed and some have visibility 0."""
    path = coco(tmp_path, {"keypoints": PLACED[:6], "bbox": [24, 9, 12, 22]})
    content = json.loads(path.read_text())
    content["categories"][0]["keypoints"] = KEYPOINTS[:2]
    path.write_text(json.dumps(content))
    (marked,) = load_marked_objects([path], targets, NAMES)
    labels = marked.read(numbers(), 255)[1]
    assert labels[15, 30] == 1 and labels[25, 30] == 255 and labels[2, 45] == 0


def test_an_image_in_two_files_is_one(tmp_path: Path, targets: list[Target]) -> None:
    green = {"attributes": {"identity": "green"}}
    away = {**green, "keypoints": [v - 20 if n % 3 == 0 else v for n, v in enumerate(PLACED)]}
    paths = [coco(tmp_path, green), coco(tmp_path, away, name="b")]
    (marked,) = load_marked_objects(paths, targets, NAMES)
    assert len(marked.regions) == 4


def test_bodies_of_what_lies_flat_follow_from_the_axes(tmp_path: Path) -> None:
    """What shows a body for sure, the markers on it, and nothing of what may be it or the floor."""
    body = "{label: 5, boxes: [{xyz: [0, 0, -0.5], size: [6, 4, 1]}]}"
    markers, given = "markers: {team: {}}", f"markers: {{team: {{pose: {{xyz: [0, 0, 0]}}}}}}, body: {body}"
    text = OBJECT.replace(markers, given).replace("{patch: {}}", "{patch: {pose: {xyz: [0, 0, 0]}}}")
    (tmp_path / "plate.yaml").write_text(text)
    targets = [Target("yellow", load_object(tmp_path / "plate.yaml", {}), 1)]
    (marked,) = load_marked_objects(
        [coco(tmp_path, {"attributes": {"identity": "green"}})], targets, {**NAMES, 5: "plate"}
    )
    labels = marked.read({**numbers(), "plate": 5}, 255)[1]
    assert labels[15, 30] == 1 and labels[25, 30] == 3  # six metres are 30 px, from row 5 to 35; four from column 20
    assert labels[8, 30] == 5 and labels[20, 22] == 5 and labels[32, 30] == 5
    assert labels[6, 30] == 255 and labels[20, 20] == 255 and labels[3, 30] == 0 and labels[20, 17] == 0


def test_bodies_of_what_does_not_lie_flat_are_left_to_be_drawn(tmp_path: Path) -> None:
    body = "{label: 5, boxes: [{xyz: [0, 0, -0.5], size: [6, 4, 1]}]}"
    text = OBJECT.replace("markers: {team: {}}", f"markers: {{team: {{pose: {{xyz: [0, 0, 0]}}}}}}, body: {body}")
    text = text.replace("{patch: {}}", "{patch: {pose: {xyz: [0, 0, 0], rpy: [1.57, 0, 0]}}}")
    (tmp_path / "upright.yaml").write_text(text)
    targets = [Target("yellow", load_object(tmp_path / "upright.yaml", {}), 1)]
    assert targets[0].model.is_spatial and not targets[0].model.is_flat
    path = coco(tmp_path, {"attributes": {"identity": "green"}})
    (marked,) = load_marked_objects([path], targets, {**NAMES, 5: "plate"})
    assert [name for name, _ in marked.regions] == ["yellow", "green"] and not marked.ignored


def test_regions_of_other_categories_go_with_axes(tmp_path: Path, targets: list[Target]) -> None:
    path = coco(tmp_path, {"attributes": {"identity": "green"}})
    content = json.loads(path.read_text())
    content["categories"].append({"id": 9, "name": "ball"})
    content["annotations"] += [
        {"image_id": 7, "category_id": 9, "bbox": [45, 5, 6, 6]},
        {"image_id": 7, "category_id": 9, "bbox": [5, 5, 6, 6], "iscrowd": 1},
        {"image_id": 7, "category_id": 9, "bbox": [0, 0, 0, 0]},
        {"image_id": 7, "category_id": 9, "bbox": None},
        {"image_id": 8, "category_id": 9, "bbox": [5, 5, 6, 6], "keypoints": []},
    ]
    content["categories"][-1]["keypoints"] = []
    content["images"].append({"id": 8, "file_name": "b.png"})
    path.write_text(json.dumps(content))
    marked, other = load_marked_objects([path], targets, NAMES)
    assert [name for name, _ in marked.regions] == ["yellow", "green", "ball"]  # the smaller one goes before
    assert [name for name, _ in other.regions] == ["ball"] and other.rest is None  # nobody has marked the robots there
    labels = marked.read({**numbers(), "ball": 6}, 255)[1]
    assert labels[8, 48] == 6 and labels[8, 8] == 255 and labels[15, 30] == 1


def test_outlines_on_a_plane_are_squeezed_as_it_is(tmp_path: Path, targets: list[Target]) -> None:
    """A plane seen at a slant: twice as many pixels a metre across as ahead, here without perspective."""
    corners = (0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)  # x is up in the image, y to the left
    pixels = [(40 - 10 * y, 35 - 5 * x) for x, y in corners]
    config = PlaneConfig(tuple(v for p in pixels for v in p), tuple(v for p in corners for v in p))
    points = [30, 20, 2, 30, 10, 2, 30, 30, 2, 30, 20, 2]  # both axes ahead: 2 m are 10 px
    path = coco(tmp_path, {"attributes": {"identity": "green"}, "keypoints": points})
    (marked,) = load_marked_objects([path], targets, NAMES, plane=FieldPlane.of(config, None))
    outlines = {name: {tuple(p) for p in np.round(outline, 4).tolist()} for name, outline in marked.regions}
    assert outlines == {
        "yellow": {(20, 20), (20, 10), (40, 10), (40, 20)},
        "green": {(20, 30), (20, 20), (40, 20), (40, 30)},
    }


def test_a_ball_is_marked_by_its_centre_and_its_edge(tmp_path: Path) -> None:
    """Beside what has axes; where one of the two is not labelled it is not told."""
    box, ball = "{size: [1, 1, 1]}", "{radius: 0.3, xyz: [0, 0, 1]}"
    parts = f"components: {{base: {{required: true, label: 2, box: {box}}}, knob: {{label: 3, ball: {ball}}}}}"
    (tmp_path / "robot.yaml").write_text(f"format: artrec_object/1\nname: robot\n{parts}\n")
    target = Target("robot", load_object(tmp_path / "robot.yaml", {}), 1)
    path = coco(
        tmp_path, {"keypoints": [30, 20, 2, 33, 24, 2]}, {"keypoints": [10, 20, 2, 0, 0, 0]}, categories=("robot",)
    )
    content = json.loads(path.read_text())
    content["categories"][0]["keypoints"] = ["knob.centre", "knob.edge"]
    path.write_text(json.dumps(content))
    (marked,) = load_marked_objects([path], [target], NAMES)
    ((name, outline),) = marked.regions
    assert name == "green"
    np.testing.assert_allclose(np.linalg.norm(outline - (30, 20), axis=1), 5)
    content["annotations"][0]["keypoints"] = [30, 20, 2, 30.3, 20, 2]
    path.write_text(json.dumps(content))
    with pytest.raises(ConfigError, match="'knob.edge' lies on 'knob.centre'"):
        load_marked_objects([path], [target], NAMES)
    content["categories"][0]["keypoints"] = ["base.centre", "knob.edge"]
    path.write_text(json.dumps(content))
    with pytest.raises(ConfigError, match="'base.centre' .* is no component/marker"):
        load_marked_objects([path], [target], NAMES)


def test_the_box_of_an_object_whose_balls_are_marked_is_background(tmp_path: Path) -> None:
    """Their sides' axes nobody marks."""
    parts = "components: {one: {required: true, label: 2, ball: {radius: 1}}, knob: {label: 3, ball: {radius: 0.3}}}"
    (tmp_path / "robot.yaml").write_text(f"format: artrec_object/1\nname: robot\n{parts}\n")
    target = Target("robot", load_object(tmp_path / "robot.yaml", {}), 1)
    marked = {"bbox": [5, 5, 45, 30], "keypoints": [30, 20, 2, 33, 24, 2, 12, 12, 2, 15, 12, 2]}
    for points, ignored in ((marked["keypoints"], 0), ([*marked["keypoints"][:9], 0, 0, 0], 1)):
        path = coco(tmp_path, {**marked, "keypoints": points}, categories=("robot",))
        content = json.loads(path.read_text())
        content["categories"][0]["keypoints"] = ["knob.centre", "knob.edge", "one.centre", "one.edge"]
        path.write_text(json.dumps(content))
        (image,) = load_marked_objects([path], [target], NAMES)
        assert len(image.ignored) == ignored
