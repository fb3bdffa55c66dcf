"""`artrec evaluate` from files, with each kind of truth, and against the independent scorer where that is at hand."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evaluation.makers import CAMERA, SUMMARY, found_thing, pixel, pose_at, record, true_thing, write_run, write_truth

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.results.results import FrameRecord
from artrec_ros.io.truth.records import load_truth
from artrec_ros.tools import evaluate as command
from artrec_ros.tools.evaluate import evaluate
from artrec_ros.tools.main import main

SHARED = Path(os.environ.get("ARTREC_SHARED", Path(__file__).parents[3] / "shared"))
TWO = {"red": {"label": 3, "required": "torso"}, "blue": {"label": 2, "required": "torso"}}


@pytest.fixture
def truth(tmp_path):
    """Three frames: one thing at the left, one in the middle, one at the right."""
    things = {10: [true_thing(-0.2)], 20: [true_thing()], 30: [true_thing(0.2, z=2)]}
    return write_truth(tmp_path / "truth.jsonl", things)


@pytest.fixture
def found(tmp_path):
    """Two of them found, one without its arm, and one false."""
    records = [
        record(10, found_thing(-0.2)),
        record(20, found_thing(arm=False), found_thing(0.3, score=0.7)),
        record(30),
    ]
    return write_run(tmp_path / "run", records)


def metrics_of(folder: Path) -> dict:
    return json.loads((folder / "metrics.json").read_text())


def test_the_command_prints_a_table_and_writes_metrics(truth, found, capsys):
    assert main(["evaluate", str(found), "--truth", str(truth), "--no-page"]) == 0
    printed = capsys.readouterr().out
    assert "3 frames, 3 objects in view, 2 found, 1 false" in printed
    assert "recognition rate" in printed and "0.667 (0.208 to 0.939)" in printed
    assert "component precision, of objects found" in printed and "component recall, of objects found" in printed
    content = metrics_of(found)
    assert content["format"] == "artrec_metrics/1" and content["all"]["counts"]["right"] == 1
    assert content["all"]["precision"]["value"] == pytest.approx(2 / 3, abs=1e-4)
    assert content["all"]["recall"] == content["all"]["recognition_rate"]
    assert content["objects"]["thing"]["joint_error_deg_median"]["value"] == pytest.approx(np.degrees(0.05), abs=1e-3)
    assert content["all"]["latency_ms_median"]["value"] == 10 and content["latency"]["pose_ms_median"]["value"] == 5
    assert [(b["name"], b["counts"]["objects"], b["counts"]["recognised"]) for b in content["by_range"]][-1][1:] == (
        1,
        0,
    )
    assert sum(b["counts"]["objects"] for b in content["by_range"]) == 3
    assert content["calibration"]["bins"][0]["precision"]["value"] == 0  # the false one, of score 0.7
    assert content["parameters"]["recognizer.min_probability"] == 0.6 and "numpy" in content["versions"]["evaluate"]
    assert not (found / "report.html").exists()


def test_the_file_of_detections_names_its_folder(truth, found, capsys):
    assert main(["evaluate", str(found / "detections.jsonl"), "--truth", str(truth), "--no-page"]) == 0
    assert metrics_of(found)["all"]["counts"]["right"] == 1 and "2 found, 1 false" in capsys.readouterr().out


def test_truth_from_poses_in_a_bag(tmp_path, found, capsys):
    with BagWriter(tmp_path / "bag", "mcap") as bag:
        bag.write_camera("/camera_info", 5, CAMERA)
        for stamp, x in ((10, -0.2), (20, 0.0), (30, 0.2)):
            bag.write_poses("/ground_truth/thing/poses", stamp, "camera", [pose_at(x)])
            bag.write_poses("/thing/poses", stamp, "camera", [])  # the node's own, recorded beside
    assert main(["evaluate", str(found), "--truth", str(tmp_path / "bag"), "--no-page"]) == 0
    counts = metrics_of(found)["all"]["counts"]
    assert (counts["objects"], counts["recognised"], counts["false"], counts["judged"]) == (3, 2, 1, 0)
    assert metrics_of(found)["all"]["position_error_m_median"]["value"] == pytest.approx(0, abs=1e-6)
    capsys.readouterr()
    assert main(["evaluate", str(found), "--truth", str(tmp_path / "bag"), "--truth-topic", "/nope/poses"]) == 1
    assert "no PoseArray topic '/nope/poses' (/ground_truth/thing/poses, /thing/poses)" in capsys.readouterr().err


def test_truth_from_coco_keypoints(tmp_path):
    records = [record(i, *d, name=f"{i}.png") for i, d in enumerate([[found_thing(-0.2)], [], [found_thing()]])]
    folder = write_run(tmp_path / "run", records)
    names = ["base/plate.tail", "base/plate.head", "arm/stripe.tail", "arm/stripe.head"]

    def annotation(i: int, image: int, x: float, arm: bool) -> dict:
        u = pixel(x)
        points = [u - 20, 59.5, 2, u + 20, 59.5, 2] + ([u + 8, 59.5, 2, u + 32, 59.5, 2] if arm else [0] * 6)
        return {"id": i, "image_id": image, "category_id": 1, "keypoints": points}

    images = [{"id": i, "file_name": f"images/{i}.png"} for i in range(3)]
    categories = [{"id": 1, "name": "thing", "keypoints": names}]
    coco = {"images": images, "categories": categories,
            "annotations": [annotation(0, 0, -0.2, True), annotation(1, 1, 0.0, False)]}  # fmt: skip
    (tmp_path / "coco.json").write_text(json.dumps(coco))
    assert main(["evaluate", str(folder), "--truth", str(tmp_path / "coco.json"), "--no-page"]) == 0
    counts = metrics_of(folder)["all"]["counts"]
    assert (counts["frames"], counts["objects"], counts["recognised"], counts["right"], counts["false"]) == (
        3,
        2,
        1,
        1,
        1,
    )
    assert metrics_of(folder)["all"]["position_error_median"]["value"] is None


def test_runs_side_by_side(tmp_path, truth, found, capsys):
    better = write_run(tmp_path / "better", [record(t, found_thing(x, z), ms=7)
                                             for t, x, z in ((10, -0.2, 1), (20, 0, 1), (30, 0.2, 2))])  # fmt: skip
    out = tmp_path / "out"
    assert main(["evaluate", str(found), str(better), "--truth", str(truth), "-o", str(out), "--no-page"]) == 0
    content = json.loads((out / "comparison.json").read_text())
    change = content["changes"][0]
    assert change["recognition_rate"]["gained"] == 1 and change["recognition_rate"]["lost"] == 0
    assert change["right_rate"]["difference"]["value"] == pytest.approx(2 / 3, abs=1e-4)
    assert change["false_per_frame"]["difference"]["value"] == pytest.approx(-1 / 3, abs=1e-4)
    assert change["latency_ms_median"]["difference"]["value"] == -3
    assert [r["all"]["counts"]["recognised"] for r in content["runs"]] == [2, 3]
    assert metrics_of(found)["all"]["counts"]["recognised"] == 2 and metrics_of(better)["all"]["counts"]["right"] == 3
    assert "better against run, same objects" in capsys.readouterr().out


def test_frames_without_result_count_as_missed_unless_only_common_ones_are_scored(tmp_path, truth, capsys):
    folder = write_run(tmp_path / "part", [record(10, found_thing(-0.2))])
    assert main(["evaluate", str(folder), "--truth", str(truth), "--no-page"]) == 0
    assert "2 of 3 frames of the truth have no result" in capsys.readouterr().out
    assert metrics_of(folder)["all"]["recognition_rate"]["value"] == pytest.approx(1 / 3, abs=1e-4)
    assert main(["evaluate", str(folder), "--truth", str(truth), "--no-page", "--common"]) == 0
    assert metrics_of(folder)["all"]["recognition_rate"]["value"] == 1


def test_what_is_in_view_without_its_required_component_is_told(tmp_path, capsys):
    """It does not count, and nobody shall take the rate for one of all that is in view."""
    away = {"base": replace(true_thing().components["base"], visible_px=0.0)}
    turned = replace(true_thing(), components=true_thing().components | away)
    hidden = replace(turned, components=turned.components | {"arm": replace(turned.components["arm"], visible_px=3.0)})
    truth = write_truth(tmp_path / "truth.jsonl", {10: [true_thing(-0.2)], 20: [turned], 30: [hidden], 40: [turned]})
    run = write_run(
        tmp_path / "run", [record(10, found_thing(-0.2)), record(20, found_thing()), record(30), record(40)]
    )
    assert main(["evaluate", str(run), "--truth", str(truth), "--no-page"]) == 0
    printed = capsys.readouterr().out
    assert "4 frames, 1 objects in view, 1 found, 0 false" in printed
    assert (
        "note: 2 more of the truth's 'thing' show other components, but too little of the required one, 'base'"
        in printed
    )
    assert "1 of them are found" in printed


def test_names_of_the_truth_that_the_object_lacks_are_told(tmp_path, truth, capsys):
    folder = write_run(tmp_path / "r", [record(10, found_thing(-0.2))])
    text = truth.read_text()
    truth.write_text(text.replace('"arm"', '"amr"'))
    assert text != truth.read_text()
    assert main(["evaluate", str(folder), "--truth", str(truth), "--no-page"]) == 0
    assert "the truth's component 'amr' is none of 'thing'; did you mean 'arm'?" in capsys.readouterr().out
    truth.write_text(text)
    assert main(["evaluate", str(folder), "--truth", str(truth), "--no-page"]) == 0
    assert "is none of 'thing'" not in capsys.readouterr().out


def test_results_without_truth_are_counted(tmp_path, truth, capsys):
    folder = write_run(tmp_path / "r", [record(10, found_thing(-0.2)), record(15), record(17), record(20)])
    assert main(["evaluate", str(folder), "--truth", str(truth), "--no-page"]) == 0
    assert "2 of 4 results are of frames that the truth does not have: not judged" in capsys.readouterr().out


def test_truth_of_another_recording_says_how_far_off_it_is(tmp_path, truth, capsys):
    folder = write_run(tmp_path / "r", [record(5 * 10**9 + 30)])
    assert main(["evaluate", str(folder), "--truth", str(truth)]) == 1
    said = capsys.readouterr().err
    assert "truth (3 frames from 10)" in said and "results' (1 frames from 5000000030)" in said and " 5 s apart" in said
    assert not (folder / "metrics.json").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["--names", "green=1"], 1, "'green' is no object"),
        (["--names", "thing=5"], 1, "the truth has no objects '5'"),
        (["--names", "thing"], 2, "NAME=TRUTH"),
        (["--names", "=3"], 2, "NAME=TRUTH"),
        (["--max-gap", "-1"], 2, "'-1' is no number of seconds"),
        (["--max-gap", "nan"], 2, "'nan' is no number of seconds"),
        (["--pictures", "few"], 2, "'few' is no number of pictures"),
        (["--truth-topic", "/a"], 1, "is no bag"),
    ],
)
def test_wrong_options(truth, found, capsys, arguments, code, said):
    assert main(["evaluate", str(found), "--truth", str(truth), *arguments]) == code
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("nothing.jsonl", None, "there is no such file"),
        ("t.jsonl", '{"stamp_ns": 1, "objects": []}\n{}\n', "line 2: stamp_ns: this key is missing"),
        (
            "t.jsonl",
            '{"stamp_ns": 1, "objects": [{"team": 1, "components": {}, "position": [0, 0, 1], '
            '"rotation": [[2, 0, 0], [0, 2, 0], [0, 0, 2]]}]}',
            "line 1: objects[0].rotation: is none",
        ),
        ("t.jsonl", '{"stamp_ns": 1, "objects": []}\n{"stamp_ns": 1, "objects": []}\n', "the stamp 1 is there twice"),
        ("t.jsonl", "", "holds no frame"),
        ("t.csv", "x", "truth is read from a bag"),
        ("t.json", "{}", "images: this key is missing"),
        ("t.json", '{"images": [], "annotations": [], "categories": []}', "holds no image"),
        ("t.mcap", "x", "t.mcap"),
    ],
)  # fmt: skip
def test_truth_that_cannot_be_read(tmp_path, found, capsys, name, content, said):
    if content is not None:
        (tmp_path / name).write_text(content)
    assert main(["evaluate", str(found), "--truth", str(tmp_path / name)]) == 1
    assert said in (line := capsys.readouterr().err) and len(line.splitlines()) == 1


def test_without_the_extra_there_are_figures_and_one_line_how_to_get_the_page(truth, found, capsys, monkeypatch):
    monkeypatch.setattr(command, "find_spec", lambda module: None)
    assert main(["evaluate", str(found), "--truth", str(truth)]) == 0
    printed = capsys.readouterr().out
    assert printed.count("pip install artrec_ros[report]") == 1 and "recognition rate" in printed
    assert metrics_of(found) and not (found / "report.html").exists()


def test_a_plain_installation_imports_no_extra():
    """In a process where the extra's libraries cannot be imported."""
    program = """
import sys
for name in ("matplotlib", "jinja2"):
    sys.modules[name] = None
from artrec_ros.tools.main import main
sys.exit(main(["evaluate", "--help"]))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "artrec_ros[report]" in done.stdout, done.stderr


def test_a_full_disk_leaves_earlier_metrics_whole(truth, found, capsys, monkeypatch):
    earlier = '{"format": "artrec_metrics/1"}'
    (found / "metrics.json").write_text(earlier)

    def full(self, *_, **__):
        self.touch()
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    assert main(["evaluate", str(found), "--truth", str(truth)]) == 1
    assert "metrics.json: cannot be written: No space left" in capsys.readouterr().err
    assert (found / "metrics.json").read_text() == earlier and not (found / "metrics.json.part").exists()


@pytest.mark.skipif(
    not (SHARED / "tools" / "score.py").exists(), reason="the independent scorer is not on this machine"
)
@pytest.mark.parametrize("name", ["aibo_lowres", "aibo_vga"])
def test_figures_equal_the_independent_scorers(tmp_path, name):
    truth_file = SHARED / "data" / name / "truth.jsonl"
    folder = two_teams(tmp_path / "r", _disturbed(load_truth(truth_file), np.random.default_rng(8)))
    ((result,), _) = evaluate([folder], truth_file)
    ours = {key: estimate.value for key, estimate in result.overall.items()}
    counts = result.evaluation.counts()
    scorer = [sys.executable, str(SHARED / "tools" / "score.py"), str(truth_file), str(folder / "detections.jsonl")]
    theirs = json.loads(subprocess.run(scorer, capture_output=True, check=True, text=True).stdout)
    assert 0 < theirs["right_rate"] < theirs["recognition_rate"] < 1 and theirs["false_per_frame"] > 0
    assert counts.frames_without_result == theirs["frames_without_result"] and counts.objects == theirs["objects"]
    for key in ("recognition_rate", "right_rate", "false_per_frame", "position_error_median"):
        assert ours[key] == pytest.approx(theirs[key], abs=6e-5), key
    assert ours["component_precision"] == pytest.approx(theirs["leg_precision"], abs=6e-5)
    assert ours["component_recall"] == pytest.approx(theirs["leg_recall"], abs=6e-5)
    assert ours["rotation_error_deg_median"] == pytest.approx(theirs["rotation_error_deg_median"], abs=2e-3)


def two_teams(folder: Path, frames: dict[int, list[Detection]]) -> Path:
    folder.mkdir()
    (folder / "summary.json").write_text(json.dumps(SUMMARY | {"looked_for": TWO}))
    lines = [FrameRecord.of(t, "/c", FrameResult((208, 160), tuple(d))).to_json() + "\n" for t, d in frames.items()]
    (folder / "detections.jsonl").write_text("".join(lines))
    return folder


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


def test_each_name_and_all_together(tmp_path):
    def labelled(label: int):
        return true_thing(name=None, label=label)

    truth = write_truth(tmp_path / "t.jsonl", {10: [labelled(3)], 20: [labelled(3)], 30: [labelled(2)]})
    folder = write_run(
        tmp_path / "r", [record(10, found_thing(object="red")), record(20), record(30, found_thing(object="blue"))]
    )
    summary = {n: {"label": label, "required": "base"} for n, label in (("red", 3), ("blue", 2))}
    (folder / "summary.json").write_text(json.dumps(SUMMARY | {"looked_for": summary}))
    ((result,), _) = evaluate([folder], truth)
    assert result.figures["red"]["recognition_rate"].value == 0.5 and result.figures["blue"]["f1"].value == 1
    assert result.overall["recognition_rate"].value == pytest.approx(2 / 3)
    assert result.evaluation.counts().frames == 3 and replace(result.evaluation.counts(), frames=0).objects == 3
