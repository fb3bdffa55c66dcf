"""`artrec replay` with a recogniser of the test's own: what is written."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from arm_replays import PARAMETERS, Recogniser, bag, params_of, run, summary_of

from artrec_ros.core.drawing import class_picture
from artrec_ros.io.parameters.parameter_file import Setup
from artrec_ros.io.results.results import read_results
from artrec_ros.tools.main import main


def test_everything_promised_is_written(tmp_path, params, recogniser, capsys):
    out = tmp_path / "out"
    assert run(params, bag(tmp_path / "bag", [1, 0, 2]), out) == 0
    records = list(read_results(out / "detections.jsonl"))
    assert [r.stamp_ns for r in records] == [1, 10**8 + 1, 2 * 10**8 + 1]
    assert [[d.image.x for d in r.detections] for r in records] == [[1.0], [], [2.0]]
    assert [r.frame for r in records] == ["/cam/labels"] * 3  # of two topics the one that fits labels
    assert all(c is not None and c.frame_id == "o" for c in recogniser.cameras)
    summary = summary_of(out)
    assert summary["frames"] == 3 and summary["objects"] == {"arm": 2} and summary["frames_without_objects"] == 1
    assert summary["looked_for"] == {"arm": {"label": 3, "required": "base"}} and not summary["interrupted"]
    assert [p.name for p in sorted((out / "frames").iterdir())] == [
        "000000_1.png", "000001_100000001.png", "000002_200000001.png",
    ]  # fmt: skip
    assert cv2.VideoCapture(str(out / "video.mp4")).get(cv2.CAP_PROP_FRAME_COUNT) == 3
    assert "3" in capsys.readouterr().out


def test_an_output_folder_may_have_any_name(tmp_path, params, recogniser, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(params, bag(tmp_path / "bag", [1, 2]), "http:x/out") == 0
    assert cv2.VideoCapture(str(tmp_path / "http:x/out/video.mp4")).get(cv2.CAP_PROP_FRAME_COUNT) == 2


def test_overlays_are_named_after_their_frames_in_order_and_each_once(tmp_path, params, recogniser):
    folders = [tmp_path / "a", tmp_path / "b"]
    names = ["x_2.png", "x_10.jpg", "x_10.png", f"{'y' * 240}.png"]
    for folder in folders:
        folder.mkdir()
        for name in names:
            cv2.imwrite(str(folder / name), np.ones((24, 32), np.uint8))
    assert main(["replay", *map(str, folders), "--params-file", str(params), "-o", str(tmp_path / "out")]) == 0
    written = [p.stem for p in sorted((tmp_path / "out" / "frames").iterdir())]
    records = list(read_results(tmp_path / "out" / "detections.jsonl"))
    assert [r.frame for r in records] == names * 2
    assert written == [f"{i:06d}_{Path(r.frame).stem[:200]}" for i, r in enumerate(records)]


def test_overlays_can_stand_beside_the_class_images(tmp_path, params, recogniser):
    source = bag(tmp_path / "bag", [1, 0, 2])
    assert run(params, source, tmp_path / "out", "--labels") == 0
    for path in sorted((tmp_path / "out" / "frames").iterdir()):
        overlay, classes = np.hsplit(cv2.imread(str(path)), 2)
        assert (classes == classes[0, 0]).all() and classes.shape == overlay.shape
    assert (classes[0, 0] == class_picture(np.array([[2]]))[0, 0]).all(), "the last image is all of class 2"
    assert run(params, source, tmp_path / "out") == 1, "other pictures are other results"


def test_the_saved_parameters_give_the_same_replay(tmp_path, params, recogniser):
    source = bag(tmp_path / "bag", [1])
    assert run(params, source, tmp_path / "a") == 0
    assert run(tmp_path / "a" / "parameters.yaml", source, tmp_path / "b") == 0
    assert (tmp_path / "a" / "detections.jsonl").read_text() == (tmp_path / "b" / "detections.jsonl").read_text()


def ids(folder):
    return [[d.id for d in r.detections] for r in read_results(folder / "detections.jsonl")]


def test_objects_keep_their_ids(tmp_path, params, recogniser):
    source = bag(tmp_path / "bag", [4, 5, 0, 6])
    assert main(["replay", str(source), str(source), "--params-file", str(params), "-o", str(tmp_path / "out")]) == 0
    assert ids(tmp_path / "out") == [[0], [0], [], [0]] * 2  # never two at once


def test_tracking_can_be_switched_off(tmp_path, params, recogniser):
    params_of(params, **PARAMETERS, tracking={"enabled": False})
    assert run(params, bag(tmp_path / "bag", [4, 30, 0, 6]), tmp_path / "out") == 0
    assert ids(tmp_path / "out") == [[0], [0], [], [0]]


def test_each_source_has_its_counts_and_its_lines(tmp_path, params, recogniser):
    sources = [bag(tmp_path / "a", [1, 0, 9]), bag(tmp_path / "b", [1])]
    arguments = ["replay", *map(str, sources), "--params-file", str(params), "-o", str(tmp_path / "out")]
    assert main(arguments) == 0
    per_source = summary_of(tmp_path / "out")["per_source"]
    assert [(s["frames"], s["frames_with_error"], s["objects"]) for s in per_source] == [
        (3, 1, {"arm": 1}), (1, 0, {"arm": 1}),
    ]  # fmt: skip
    assert [r.source for r in read_results(tmp_path / "out" / "detections.jsonl")] == [0, 0, 0, 1]


def test_without_timing_there_is_none(tmp_path, params, recogniser, capsys):
    assert run(params, bag(tmp_path / "bag", [1]), tmp_path / "out", "--no-timing") == 0
    (record,) = read_results(tmp_path / "out" / "detections.jsonl")
    assert record.timing_ms == {} and summary_of(tmp_path / "out")["total_ms"] is None
    assert "ms per frame" not in capsys.readouterr().out


def test_a_wrong_source_leaves_no_folder(tmp_path, params, recogniser):
    assert run(params, tmp_path / "nothing", tmp_path / "out") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("images", "count"), [("none", 0), ("2", 2), ("all", 3)])
def test_pictures_as_many_as_asked_for(tmp_path, params, recogniser, images, count):
    assert run(params, bag(tmp_path / "bag", [1] * 3), tmp_path / "out", "--images", images) == 0
    assert len(list((tmp_path / "out" / "frames").iterdir())) == count


def test_offset_and_duration(tmp_path, params, recogniser):
    source = bag(tmp_path / "bag", [1] * 6)
    assert run(params, source, tmp_path / "out", "--start-offset", "0.2", "--playback-duration", "0.2") == 0
    assert [r.stamp_ns for r in read_results(tmp_path / "out" / "detections.jsonl")] == [2 * 10**8 + 1, 3 * 10**8 + 1]


@pytest.mark.parametrize(
    "wrong",
    [
        ["--rate", "0"],
        ["--rate", "1e-300"],
        ["--start-offset", "1e300"],
        ["-j", "99999999"],
        ["--start-offset", "-1"],
        ["--images", "some"],
        ["--images", "1.5"],
        ["-s", "ros1"],
    ],
)
def test_wrong_usage(tmp_path, params, recogniser, wrong):
    assert run(params, tmp_path, tmp_path / "out", *wrong) == 2


def test_each_run_builds_its_recogniser_anew(tmp_path, params, monkeypatch):
    """As somebody needs who changes the recogniser between two replays in one process."""
    source, built = bag(tmp_path / "bag", [1]), []
    monkeypatch.setattr(Setup, "build", lambda self, **how: built.append(1) or Recogniser())
    for name in ("a", "b"):
        assert run(params, source, tmp_path / name) == 0
    assert run(params, source, tmp_path / "b", "--overwrite") == 0
    assert len(built) == 3
