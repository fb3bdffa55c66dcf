"""`artrec evaluate` from files, and against the independent scorer where that is at hand."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from artrec_ros.core.datatypes import Detection, FrameResult, ImagePose, Instance
from artrec_ros.core.errors import SourceError
from artrec_ros.core.transforms import Pose
from artrec_ros.io.results import FrameRecord
from artrec_ros.io.truth import load_truth
from artrec_ros.tools.evaluate import evaluate, table
from artrec_ros.tools.main import main

SHARED = Path(os.environ.get("ARTREC_SHARED", Path(__file__).parents[3] / "shared"))
LOOKED_FOR = {"red": {"label": 3, "required": "torso"}, "blue": {"label": 2, "required": "torso"}}


def truth_line(stamp_ns: int, x: float, team: int = 3) -> str:
    leg = {"full_px": 100, "visible_px": 100, "centre": [x, 80]}
    components = {"torso_left": {"full_px": 400, "visible_px": 400, "centre": [x, 50]}, "leg@front": leg}
    o = {"team": team, "position": [0, 0, 2], "rotation": np.eye(3).tolist(), "components": components}
    return json.dumps({"stamp_ns": stamp_ns, "objects": [o | {"centre_px": [x, 50], "joints": {}}]})


def detection(x: float, name: str = "red") -> Detection:
    parts = (Instance("torso", "m", 1, x, 50, 0, 1), Instance("leg", "m", 1, x, 80, 0, 1))
    return Detection(name, 0, 1.0, ImagePose(x, 50, 0, 1), parts, Pose.from_xyz_rpy([0, 0, 2]))


def results(folder: Path, frames: dict[int, list[Detection]]) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "summary.json").write_text(json.dumps({"looked_for": LOOKED_FOR}))
    lines = [FrameRecord.of(t, "/c", FrameResult((208, 160), tuple(d))).to_json() + "\n" for t, d in frames.items()]
    (folder / "detections.jsonl").write_text("".join(lines))
    return folder


@pytest.fixture
def truth(tmp_path):
    path = tmp_path / "truth.jsonl"
    path.write_text("\n".join([truth_line(10, 100), truth_line(20, 120), truth_line(30, 60, team=2)]) + "\n")
    return path


def test_each_name_and_all_together(tmp_path, truth):
    folder = results(tmp_path / "r", {10: [detection(100)], 20: [detection(20)], 30: [detection(60, "blue")]})
    metrics = evaluate(folder, truth)
    assert metrics["red"]["recognition_rate"] == 0.5 and metrics["blue"]["recognition_rate"] == 1.0
    assert metrics["all"]["objects"] == 3 and metrics["all"]["recognised"] == 2
    assert metrics["all"]["frames"] == 3 and metrics["all"]["false_per_frame"] == pytest.approx(1 / 3, abs=1e-4)


def test_the_command_prints_a_table_and_writes_metrics(tmp_path, truth, capsys):
    folder = results(tmp_path / "r", {10: [detection(100)]})
    assert main(["evaluate", str(folder), "--truth", str(truth), "--names", "red=3"]) == 0
    printed = capsys.readouterr().out
    assert "recognition_rate" in printed and "0.5" in printed and "blue" not in printed
    assert json.loads((folder / "metrics.json").read_text())["all"]["frames_without_result"] == 2


def test_truth_of_another_recording_says_how_far_off_it_is(tmp_path, truth):
    folder = results(tmp_path / "r", {5 * 10**9 + 30: [detection(100)]})
    with pytest.raises(SourceError, match=r"truth \(3 frames.*results' \(1 frames.* 5 s apart"):
        evaluate(folder, truth)


@pytest.mark.parametrize(
    ("names", "code", "said"),
    [("green=1", 1, "'green' is no object"), ("red", 2, "NAME=LABEL"), ("red=x", 2, "NAME=LABEL")],
)
def test_wrong_names(tmp_path, truth, capsys, names, code, said):
    folder = results(tmp_path / "r", {10: []})
    assert main(["evaluate", str(folder), "--truth", str(truth), "--names", names]) == code
    assert said in capsys.readouterr().err


def test_files_that_are_missing_or_broken_are_named(tmp_path, truth):
    with pytest.raises(SourceError, match="summary.json: cannot be read"):
        evaluate(tmp_path, truth)
    folder = results(tmp_path / "r", {10: []})
    with pytest.raises(SourceError, match="nothing.jsonl: cannot be read"):
        evaluate(folder, tmp_path / "nothing.jsonl")
    truth.write_text(truth_line(1, 1) + "\n{}\n")
    with pytest.raises(SourceError, match="line 2"):
        evaluate(folder, truth)


@pytest.mark.skipif(
    not (SHARED / "tools" / "score.py").exists(), reason="the independent scorer is not on this machine"
)
@pytest.mark.parametrize("name", ["aibo_lowres", "aibo_vga"])
def test_figures_equal_the_independent_scorers(tmp_path, name):
    truth_file = SHARED / "data" / name / "truth.jsonl"
    folder = results(tmp_path / "r", _disturbed(load_truth(truth_file), np.random.default_rng(8)))
    ours = evaluate(folder, truth_file)["all"]
    command = [sys.executable, str(SHARED / "tools" / "score.py"), str(truth_file), str(folder / "detections.jsonl")]
    theirs = json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)
    assert 0 < theirs["right_rate"] < theirs["recognition_rate"] < 1 and theirs["false_per_frame"] > 0
    for key in ("frames_without_result", "objects", "recognition_rate", "right_rate", "false_per_frame"):
        assert ours[key] == theirs[key], key
    assert ours["component_precision"] == theirs["leg_precision"]
    assert ours["component_recall"] == theirs["leg_recall"]
    assert ours["position_error_median"] == theirs["position_error_median"]
    assert ours["rotation_error_deg_median"] == pytest.approx(theirs["rotation_error_deg_median"], abs=2e-3)


def _disturbed(truth, rng) -> dict[int, list[Detection]]:
    """The truth as detections, some displaced, some without a component, some twice, some frames missing."""
    found: dict[int, list[Detection]] = {}
    for stamp_ns, objects in truth.items():
        if rng.random() < 0.05:
            continue
        found[stamp_ns] = []
        for o in objects:
            parts = tuple(
                Instance(n.partition("@")[0].partition("_")[0] if n.startswith("torso") else n.partition("@")[0],
                         "m", 1, *(c.centre + rng.normal(0, 2, 2)), 0, 1)
                for n, c in o.components.items() if c.centre is not None and rng.random() < 0.9
            )  # fmt: skip
            x, y = (o.centre_px if rng.random() < 0.7 else o.centre_px + rng.normal(0, 30, 2)).tolist()
            pose = Pose(o.pose.rotation @ Pose.from_xyz_rpy([0, 0, 0], [0.1, 0, 0]).rotation, 1.02 * o.pose.position)
            d = Detection("red" if o.label == 3 else "blue", 0, 1.0, ImagePose(x, y, 0, 1), parts, pose)
            found[stamp_ns] += [d] * (1 + (rng.random() < 0.1))
    return found


def test_the_table_has_a_row_a_figure_and_a_column_a_name():
    lines = list(table({"red": {"a": 1, "b": None}, "all": {"a": 2, "b": 0.5}}))
    assert [line.split() for line in lines] == [["red", "all"], ["a", "1", "2"], ["b", "-", "0.5"]]
