"""What `artrec inspect` tells of annotations."""

import json

import cv2
import numpy as np
import pytest
import yaml
from inspections import inspect


def test_annotations_must_be_of_the_object_and_their_images_there(tmp_path, config, capsys):
    names = ["base/side_right.tail", "base/side_right.head"]
    content = {
        "images": [{"id": 1, "file_name": "a.png"}],
        "annotations": [{"image_id": 1, "category_id": 1, "keypoints": [1, 1, 2, 9, 9, 2]}],
        "categories": [{"id": 1, "name": "digger", "keypoints": names}],
    }
    (tmp_path / "coco.json").write_text(json.dumps(content))
    code, _, problems = inspect(capsys, tmp_path / "coco.json", config / "objects/excavator.yaml")
    assert code == 1 and len(problems) == 1 and "a.png" in problems[0]
    (tmp_path / "elsewhere").mkdir()
    cv2.imwrite(str(tmp_path / "elsewhere/a.png"), np.zeros((30, 40), np.uint8))
    assert inspect(capsys, tmp_path / "coco.json", "--images", tmp_path / "elsewhere")[0] == 0
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((30, 40), np.uint8))
    assert inspect(capsys, tmp_path / "coco.json", config / "objects/excavator.yaml")[0] == 0
    code, _, problems = inspect(capsys, tmp_path / "coco.json", config / "objects/vss.yaml")
    assert code == 1 and "category 'digger' is of none of the objects: keypoint 'base/side_right.tail'" in problems[0]


@pytest.mark.parametrize(
    ("category", "attributes", "said"),
    [
        ("yellow", {"identity": "gr"}, ()),
        ("yellow_gr", {}, ()),
        ("yellow", {"left": "g", "right": "r"}, ()),
        ("yellow", {"identity": "gg"}, ("object 'mirosot' has no identity 'gg'",)),
        ("yellow", {}, ("is not told which one it is, of 1 of 1", "gr, gv, rg, vg, vr")),
    ],
)
def test_annotations_tell_which_one_of_several_like_objects_it_is(tmp_path, config, capsys, category, attributes, said):
    names = [f"{part}/{part}.{end}" for part in ("team", "left", "right") for end in ("tail", "head")]
    points = [v for n in range(6) for v in (10.0 + 7 * n, 12.0 + n * n, 2)]
    one = {"image_id": 1, "id": 1, "category_id": 1, "keypoints": points, "attributes": attributes}
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((60, 80), np.uint8))
    content = {
        "images": [{"id": 1, "file_name": "a.png", "width": 80, "height": 60}],
        "categories": [{"id": 1, "name": category, "keypoints": names}],
        "annotations": [one],
    }
    (tmp_path / "coco.json").write_text(json.dumps(content))
    code, _, problems = inspect(capsys, tmp_path / "coco.json", config / "objects/mirosot.yaml")
    assert (code != 0) == bool(said) == bool(problems), problems
    assert all(any(words in line for line in problems) for words in said)


def test_a_category_is_of_the_object_that_it_names_though_others_have_its_keypoints(tmp_path, config, capsys):
    text = (config / "objects/mirosot.yaml").read_text()
    (tmp_path / "one.yaml").write_text(text)
    (tmp_path / "two.yaml").write_text(text.replace("  gr: {", "  first: {"))
    objects = {"objects": ["blue", "pink"], "blue": {"object_file": "one.yaml", "label": 1}}
    objects |= {"pink": {"object_file": "two.yaml", "label": 2}}
    colours = {name: {"label": label} for label, name in enumerate(("green", "red", "violet"), 3)}
    objects["image"] = {"kind": "labels", "classes": list(colours), **colours}
    for team in ("blue", "pink"):
        names = [f"{part}/{part}.{end}" for part in ("team", "left", "right") for end in ("tail", "head")]
        points = [v for n in range(6) for v in (10.0 + 7 * n, 12.0 + n * n, 2)]
        one = {"image_id": 1, "id": 1, "category_id": 1, "keypoints": points}
        one["attributes"] = {"identity": "gr" if team == "blue" else "first"}
        cv2.imwrite(str(tmp_path / "a.png"), np.zeros((60, 80), np.uint8))
        content = {
            "images": [{"id": 1, "file_name": "a.png"}],
            "categories": [{"id": 1, "name": team, "keypoints": names}],
            "annotations": [one],
        }
        (tmp_path / "coco.json").write_text(json.dumps(content))
        (tmp_path / "robots.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": objects}}))
        _, printed, problems = inspect(capsys, tmp_path / "robots.yaml", tmp_path / "coco.json")
        assert "told below" not in printed
        assert not [line for line in problems if "identity" in line or "none of the objects" in line], problems


def test_other_objects_in_the_same_file_are_no_problem(tmp_path, config, capsys):
    """Of two teams' robots, and a ball, in one file of annotations the file of one team knows its own."""
    names = [f"{part}/{part}.{end}" for part in ("team", "left", "right") for end in ("tail", "head")]
    categories = [("blue_gr", names), ("yellow_first", names), ("ball", ["ball/ball.centre", "ball/ball.edge"])]
    points = [[v for n in range(len(keys)) for v in (10.0 + 7 * n, 12.0 + n * n, 2)] for _, keys in categories]
    content = {
        "images": [{"id": 1, "file_name": "a.png"}],
        "categories": [{"id": n, "name": name, "keypoints": keys} for n, (name, keys) in enumerate(categories)],
        "annotations": [{"image_id": 1, "id": n, "category_id": n, "keypoints": own} for n, own in enumerate(points)],
    }
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((60, 80), np.uint8))
    (tmp_path / "coco.json").write_text(json.dumps(content))
    assert inspect(capsys, config / "objects/mirosot.yaml", tmp_path / "coco.json")[2] == []
    content["categories"] = content["categories"][2:]
    content["annotations"] = content["annotations"][2:]
    (tmp_path / "coco.json").write_text(json.dumps(content))
    (problem,) = inspect(capsys, config / "objects/mirosot.yaml", tmp_path / "coco.json")[2]
    assert "category 'ball' is of none of the objects" in problem


def test_regions_are_told_beside_objects_and_are_no_problem_alone(tmp_path, capsys):
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((60, 80, 3), np.uint8))
    content = {
        "images": [{"id": 1, "file_name": "a.png"}],
        "categories": [{"id": n, "name": name} for n, name in enumerate(("wheel", "shadow", "cable"))],
        "annotations": [{"image_id": 1, "category_id": c, "bbox": [1, 2, 8, 8]} for c in (0, 1, 0)],
    }
    (tmp_path / "regions.json").write_text(json.dumps(content))
    code, printed, problems = inspect(capsys, tmp_path / "regions.json")
    assert (code, problems) == (0, [])
    assert "  regions, of categories without keypoints: wheel: 2, shadow: 1, cable: 0\n" in printed
