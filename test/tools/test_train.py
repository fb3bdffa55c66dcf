"""`artrec train` as users call it: what it writes, prints and refuses."""

from __future__ import annotations

import copy
import json
import os
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from artrec_ros.io.learned.constraints import load_constraints
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.tools.main import main

ROOT = Path(__file__).resolve().parents[2]
SHARED = Path(os.environ.get("ARTREC_SHARED", ROOT.parent / "shared"))
OBJECT = """
format: artrec_object/1
name: toy
markers:
  flag: {outline: [[0, 0], [0.4, 0], [0.3, 0.1], [0.4, 0.2], [0, 0.2]], axis: [[0, 0.1], [0.3, 0.1]]}
components:
  base: {required: true, markers: {flag: {}}}
  arm: {markers: {flag: {}}}
"""
ARM_LENGTH_M = 0.5


def _coco(examples: int, spread_rad: float, squeeze_last: float = 1.0) -> dict[str, Any]:
    """An arm that turns about the base's centroid by angles known to the test; axes are 30 px long at 100 px/m."""
    rows = []
    for n, turn in enumerate(np.linspace(-spread_rad, spread_rad, examples)):
        length = 30 * (squeeze_last if n == examples - 1 else 1.0)
        along = np.array([np.cos(turn), np.sin(turn)])
        arm = np.array([100.0, 80.0]) + 100 * ARM_LENGTH_M * along
        points = [np.array([100.0, 80.0]), np.array([130.0, 80.0]), arm, arm + length * along]
        rows.append({"image_id": n, "category_id": 1, "keypoints": [v for p in points for v in (*p, 2)]})
    return {
        "images": [{"id": n, "file_name": f"{n}.png"} for n in range(examples)],
        "annotations": rows,
        "categories": [
            {"id": 1, "name": "toy", "keypoints": [f"{c}/flag.{e}" for c in ("base", "arm") for e in ("tail", "head")]}
        ],
    }


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "toy.yaml").write_text(OBJECT)
    return tmp_path


def _train(folder: Path, coco: dict[str, Any], *more: str) -> int:
    (folder / "coco.json").write_text(json.dumps(coco))
    files = ["--object", str(folder / "toy.yaml"), "--annotations", str(folder / "coco.json")]
    return main(["train", *files, "--output", str(folder / "out.yaml"), *more])


def test_crowds_that_are_left_out_are_counted(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    coco = _coco(9, 0.3)
    coco["annotations"][4]["iscrowd"] = 1
    assert _train(folder, coco) == 0
    assert "1 annotations of crowds (iscrowd: 1) were left out." in capsys.readouterr().out
    for row in coco["annotations"]:
        row["iscrowd"] = 1
    assert _train(folder, coco) == 1
    assert "of 0 annotations (9 of crowds, iscrowd: 1, not counted), 0 show" in capsys.readouterr().err


def test_the_box_holds_what_the_examples_show(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert _train(folder, _coco(9, 0.3)) == 0
    model = load_object(folder / "toy.yaml")
    (pair,) = load_constraints(folder / "out.yaml", model).pairs
    assert pair.examples == 9
    assert (pair.seen["turn_rad"].low, pair.seen["turn_rad"].high) == pytest.approx((-0.3, 0.3), abs=1e-5)
    assert pair.seen["scale_ratio"].low == pytest.approx(1, abs=1e-5)
    assert pair.allowed["turn_rad"].low < -0.3 and pair.allowed["turn_rad"].high > 0.3
    printed = capsys.readouterr().out
    (row,) = [line for line in printed.splitlines() if line.startswith("base/flag - arm/flag  ")]
    assert row.split()[3] == "9" and "turn -17.2..17.2 deg" in row
    assert f"{0.8 ** len(pair.allowed):.2f} ->" in row  # nine examples: (9 - 1)/(9 + 1) a dimension
    assert "1 pairs want more examples" in printed and "(9 seen)" in printed


def test_coverage_0_is_the_bare_box(folder: Path) -> None:
    assert _train(folder, _coco(9, 0.3), "--coverage", "0") == 0
    (pair,) = load_constraints(folder / "out.yaml", load_object(folder / "toy.yaml")).pairs
    for name, interval in pair.allowed.items():
        assert (interval.low, interval.high) == (pair.seen[name].low, pair.seen[name].high)


def test_oblique_markers_are_left_out_and_counted(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert _train(folder, _coco(9, 0.3, squeeze_last=0.4)) == 0
    (pair,) = load_constraints(folder / "out.yaml", load_object(folder / "toy.yaml")).pairs
    assert pair.examples == 8 and "1 markers are seen too obliquely" in capsys.readouterr().out
    assert _train(folder, _coco(9, 0.3, squeeze_last=0.4), "--max-scale-ratio", "3") == 0
    (pair,) = load_constraints(folder / "out.yaml", load_object(folder / "toy.yaml")).pairs
    assert pair.examples == 9


@pytest.mark.parametrize(
    ("more", "reason"),
    [
        (("--category", "tyo"), "'toy'"),
        (("--coverage", "1.5"), "--coverage"),
        (("--coverage", "nan"), "--coverage"),
        (("--max-scale-ratio", "0.5"), "--max-scale-ratio"),
    ],
)
def test_mistakes_are_one_line_and_code_1(
    folder: Path, capsys: pytest.CaptureFixture[str], more: tuple[str, ...], reason: str
) -> None:
    assert _train(folder, _coco(5, 0.3), *more) == 1
    captured = capsys.readouterr().err
    assert captured.count("\n") == 1 and captured.startswith("artrec: ") and reason in captured
    assert not (folder / "out.yaml").exists()


def test_examples_without_a_pair_teach_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    coco = _coco(5, 0.3)
    for row in coco["annotations"]:
        row["keypoints"][6:] = [0] * 6
    assert _train(folder, coco) == 1
    assert "no pair of its components is seen together" in capsys.readouterr().err


def _classes() -> dict[str, Any]:
    """The arm turns about -0.6 in one category, about +0.6 in the other."""
    coco = _coco(12, 0.1)
    both = copy.deepcopy(coco)
    both["categories"].append({**coco["categories"][0], "id": 2, "name": "bent"})
    for row in _coco(12, 0.1)["annotations"]:
        points = np.array(row["keypoints"], float).reshape(-1, 3)
        turn = np.array([[np.cos(1.2), np.sin(1.2)], [-np.sin(1.2), np.cos(1.2)]])
        points[2:, :2] = (points[2:, :2] - points[0, :2]) @ turn + points[0, :2]
        both["annotations"].append({**row, "category_id": 2, "keypoints": points.ravel().tolist()})
    return both


def test_several_categories_become_classes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert _train(folder, _classes(), "--category", "toy", "bent") == 0
    learned = load_constraints(folder / "out.yaml", load_object(folder / "toy.yaml"))
    assert [c.name for c in learned.classes] == ["toy", "bent"]
    straight, bent = (c.pairs[0].seen["turn_rad"] for c in learned.classes)
    assert (straight.low, straight.high) == pytest.approx((-0.1, 0.1), abs=1e-4)
    assert (bent.low, bent.high) == pytest.approx((1.1, 1.3), abs=1e-4)
    general = learned.pairs[0].seen["turn_rad"]
    assert (general.low, general.high) == pytest.approx((-0.1, 1.3), abs=1e-4)
    printed = capsys.readouterr().out
    assert "class 'bent': 12 examples" in printed and "7 more examples are wanted" in printed
    assert _train(folder, _classes(), "--category", "bent") == 0
    assert load_constraints(folder / "out.yaml", load_object(folder / "toy.yaml")).classes == ()


def test_a_class_without_pairs_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    coco = _classes()
    for row in coco["annotations"][12:]:
        row["keypoints"][6:] = [0] * 6
    assert _train(folder, coco, "--category", "toy", "bent") == 1
    assert "category 'bent'" in capsys.readouterr().err


def _askew_images(folder: Path, count: int, askew_rad: float) -> dict[str, Any]:
    """Pictures of the toy, its arm's axis annotated as turned by `askew_rad`."""
    coco, rng = _coco(count, 0.3), np.random.default_rng(0)
    outline = np.array([[0, 0], [0.4, 0], [0.3, 0.1], [0.4, 0.2], [0, 0.2]]) - [0, 0.1]
    for row, turn in zip(coco["annotations"], np.linspace(-0.3, 0.3, count), strict=True):
        labels, points = np.zeros((240, 320), np.uint8), []
        heading = rng.uniform(-np.pi, np.pi)
        for n, angle in enumerate((heading, heading + turn)):
            along = np.array([np.cos(angle), np.sin(angle)])
            tail = np.array([150.0, 120.0]) + n * 70 * np.array([np.cos(heading), np.sin(heading)])
            across = np.array([along[1], -along[0]])  # the marker's y is up
            corners = tail + 100 * (outline[:, :1] * along + outline[:, 1:] * across)
            cv2.fillPoly(labels, [np.round(corners * 16).astype(np.int32)], 2, shift=4)
            shown = angle + n * askew_rad
            points += [tail, tail + 30 * np.array([np.cos(shown), np.sin(shown)])]
        row["keypoints"] = [float(v) for p in points for v in (*p, 2)]
        (folder / "pictures").mkdir(exist_ok=True)
        cv2.imwrite(str(folder / "pictures" / f"{row['image_id']}.png"), labels)
    return coco


def test_axes_that_are_annotated_askew_are_learned_from_the_images(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    coco = _askew_images(folder, 24, askew_rad=0.08)
    parameters = {"objects": ["it"], "it": {"object_file": "toy.yaml", "constraint_file": "out.yaml", "label": 2}}
    (folder / "node.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
    more_parameters = {"image": {"kind": "labels"}, "recognizer": {"min_match": 0.5}}  # as learned colours are given
    (folder / "more.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": more_parameters}}))
    given = [str(folder / name) for name in ("node.yaml", "more.yaml")]
    more = ("--params-file", given[0], "--params-file", given[1], "--images", str(folder / "pictures"))
    assert _train(folder, coco, *more) == 0
    printed = capsys.readouterr().out
    assert "24 of 24 annotated objects" in printed and "axis of arm/flag" in printed
    learned = load_constraints(folder / "out.yaml", load_object(folder / "toy.yaml"))
    (axis,) = learned.axes
    assert axis.key == ("arm", "flag") and axis.after_deg < 0.5 < axis.before_deg
    assert axis.turn_rad == pytest.approx(0.08, abs=0.01)


def test_few_found_for_outlines_that_are_off_is_told_with_the_way_out(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A segmenter gives each marker a pixel more all around."""
    coco = _askew_images(folder, 20, askew_rad=0.0)
    for path in (folder / "pictures").glob("*.png"):
        cv2.imwrite(str(path), cv2.dilate(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), np.ones((3, 3), np.uint8)))
    parameters = {"objects": ["it"], "it": {"object_file": "toy.yaml", "label": 2}}
    params = folder / "node.yaml"
    params.write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
    more = ("--params-file", str(params), "--images", str(folder / "pictures"))
    assert _train(folder, coco, *more) == 0
    printed = capsys.readouterr().out
    found = re.search(r"found (\d+) of 20 annotated objects, with (\d+) of 40 markers", printed)
    told = re.search(r"expert.constraints.contour_noise_px: ([\d.]+) it finds (\d+) of 20", printed)
    assert found and told and int(found[2]) < 20 and int(told[2]) >= 19, printed
    parameters |= {"expert": {"constraints": {"contour_noise_px": float(told[1])}}}
    params.write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
    assert _train(folder, coco, *more) == 0
    printed = capsys.readouterr().out
    assert f"found {told[2]} of 20" in printed and "contour_noise_px" not in printed


def test_images_that_are_not_there_are_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parameters = {"objects": ["it"], "it": {"object_file": "toy.yaml", "label": 2}}
    (folder / "node.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
    assert _train(folder, _coco(9, 0.3), "--params-file", str(folder / "node.yaml")) == 1
    error = capsys.readouterr().err
    assert "0.png" in error and "--images" in error and error.count("\n") == 1


@pytest.mark.skipif(not (SHARED / "data" / "aibo_vga_train").is_dir(), reason="the shared data are not here")
def test_the_shipped_constraints_are_what_training_gives(tmp_path: Path) -> None:
    sets = [str(SHARED / "data" / f"aibo_{size}_train" / "annotations.json") for size in ("lowres", "vga")]
    quadruped = str(ROOT / "config" / "objects" / "quadruped.yaml")
    assert main(["train", "--object", quadruped, "--annotations", *sets, "-o", str(tmp_path / "c.yaml")]) == 0
    assert (tmp_path / "c.yaml").read_text() == (ROOT / "config" / "constraints" / "quadruped.yaml").read_text()


def test_marks_that_cannot_be_of_their_images_are_warned_of(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    coco = _coco(9, 0.3)
    for image in coco["images"]:
        image.update(width=300, height=200)
    cv2.imwrite(str(folder / "3.png"), np.zeros((200, 300), np.uint8))
    assert _train(folder, coco) == 0 and "warning" not in capsys.readouterr().out
    cv2.imwrite(str(folder / "3.png"), np.zeros((100, 150), np.uint8))
    coco["annotations"][5]["keypoints"][0] = -5000
    assert _train(folder, coco) == 0
    far, wrong = [line for line in capsys.readouterr().out.splitlines() if line.startswith("warning")]
    assert "annotations[5] (5.png): marks lie far outside its image of 300x200, and so in 1 of 9 annotations" in far
    assert f"{folder / '3.png'}: has 150x100 pixels; its COCO file says 300x200, and so of 1 of 9 images" in wrong
