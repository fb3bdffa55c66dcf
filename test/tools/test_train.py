"""`artrec train` as users call it: what it writes, prints and refuses."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artrec_ros.io.constraints import load_constraints
from artrec_ros.io.objects import load_object
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


@pytest.mark.skipif(not (SHARED / "data" / "aibo_vga_train").is_dir(), reason="the shared data are not here")
def test_the_shipped_constraints_are_what_training_gives(tmp_path: Path) -> None:
    sets = [str(SHARED / "data" / f"aibo_{size}_train" / "annotations.json") for size in ("lowres", "vga")]
    quadruped = str(ROOT / "config" / "objects" / "quadruped.yaml")
    assert main(["train", "--object", quadruped, "--annotations", *sets, "-o", str(tmp_path / "c.yaml")]) == 0
    assert (tmp_path / "c.yaml").read_text() == (ROOT / "config" / "constraints" / "quadruped.yaml").read_text()
