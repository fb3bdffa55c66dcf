"""`artrec replay` with a recogniser of the test's own: what is written, and what happens when things go wrong."""

from __future__ import annotations

import json
import os
import shutil
import signal
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from artrec_ros.core.base.errors import ImageError
from artrec_ros.core.drawing import class_picture
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.model.found import Detection, FrameResult, ImagePose, Instance, Rejection
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.images.cameras import camera_yaml
from artrec_ros.io.parameters.parameter_file import Setup
from artrec_ros.io.results.results import FrameRecord, read_results
from artrec_ros.tools.main import main
from artrec_ros.tools.replaying.summary import Summary

CONFIG = Path(__file__).parents[2] / "config"
OBJECT = """
format: artrec_object/1
name: arm
markers: {patch: {outline: [[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]], axis: [[0, 0.05], [0.2, 0.05]]}}
components: {base: {required: true, markers: {patch: {}}}}
"""
PARAMETERS = {"objects": ["arm"], "arm": {"object_file": "arm.yaml", "label": 3}, "image": {"kind": "labels"}}


class Recogniser:
    """Finds an object at the place that the image's first pixel tells; refuses images that start with 9."""

    def __init__(self, at_frame=None) -> None:
        self.at_frame, self.seen, self.cameras = at_frame or {}, 0, []

    def follow(self, image, camera, stamp_ns, memory) -> tuple[FrameResult, None]:
        self.seen += 1
        self.cameras.append(camera)
        if self.seen in self.at_frame:
            self.at_frame[self.seen]()
        if image[0, 0] == 9:
            raise ImageError("a nine")
        x = float(image[0, 0])
        parts = (Instance("base", "patch", 0.9, x, 5, 0, 100),)
        detections = (Detection("arm", 0, 0.9, ImagePose(x, 5, 0, 100), parts),) if x else ()
        return FrameResult((image.shape[1], image.shape[0]), detections, timing_ms={"total": 2.0}), None


@pytest.fixture
def params(tmp_path):
    (tmp_path / "arm.yaml").write_text(OBJECT)
    return params_of(tmp_path / "params.yaml", **PARAMETERS)


@pytest.fixture
def recogniser(monkeypatch):
    made = Recogniser()
    monkeypatch.setattr(Setup, "build", lambda self, **how: made)
    return made


def bag(path: Path, firsts) -> Path:
    with BagWriter(path) as writer:
        for i, first in enumerate(firsts):
            image = np.full((24, 32), first, np.uint8)
            writer.write_camera(
                "/cam/camera_info", i * 10**8 + 1, Camera(np.diag([9.0, 9, 1]), np.zeros(5), (32, 24), "o")
            )
            writer.write_image("/cam/labels", i * 10**8 + 1, "o", image)
            writer.write_jpeg("/cam/colour/compressed", i * 10**8 + 1, "o", np.dstack([image] * 3))
    return path


def folder_of(path: Path, firsts) -> Path:
    """Pictures 0.png, 1.png, ..., each filled with one number."""
    path.mkdir()
    for n, first in enumerate(firsts):
        cv2.imwrite(str(path / f"{n}.png"), np.full((24, 32), first, np.uint8))
    return path


def params_of(path: Path, **sections) -> Path:
    path.write_text(yaml.safe_dump({"/**": {"ros__parameters": sections}}))
    return path


def summary_of(output: Path) -> dict:
    return json.loads((output / "summary.json").read_text())


def run(params, source, output, *more) -> int:
    return main(["replay", str(source), "--params-file", str(params), "-o", str(output), *more])


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


def test_a_replay_goes_on_however_its_paths_are_spelled(tmp_path, params, recogniser, capsys):
    source, link, around = bag(tmp_path / "bag", [1, 2]), tmp_path / "link", tmp_path / "frames" / ".."
    (tmp_path / "frames").mkdir()
    link.symlink_to(source)
    assert run(params, source, tmp_path / "out") == 0
    for spelled in (link, around / "bag"):
        assert run(around / params.name, spelled, tmp_path / "out") == 0, capsys.readouterr().err
    assert recogniser.seen == 2


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


def test_the_limits_that_cut_frames_short_are_told_apart():
    time, nodes = "recognizer.time_budget_ms", "expert.grouping.search_nodes"
    summary = Summary()
    for t, ended_by in enumerate(((), (nodes,), (nodes,), (time, nodes))):
        summary.add(FrameRecord(t, "/c", (8, 6), ended_by=ended_by))
    assert summary.to_dict()["frames_cut_short_by"] == {nodes: 3, time: 1}
    told = [line for line in summary.lines() if "cut short" in line]
    assert told == [f"{count} frame(s) were cut short by {limit}" for limit, count in ((nodes, 3), (time, 1))]


def test_where_nothing_is_found_the_first_reason_is_told():
    summary = Summary()
    summary.add(FrameRecord(0, "/c", (8, 6)))
    for reason in ("too small", "too far"):
        summary.add(FrameRecord(1, "/c", (8, 6), rejected=(Rejection("red", reason),)))
    assert "the first reason why not, red: too small (all of them: detections.jsonl)" in list(summary.lines())


def test_objects_keep_their_ids(tmp_path, params, recogniser):
    source = bag(tmp_path / "bag", [4, 5, 0, 6])
    assert main(["replay", str(source), str(source), "--params-file", str(params), "-o", str(tmp_path / "out")]) == 0
    assert ids(tmp_path / "out") == [[0], [0], [], [0]] * 2  # never two at once


def test_tracking_can_be_switched_off(tmp_path, params, recogniser):
    params_of(params, **PARAMETERS, tracking={"enabled": False})
    assert run(params, bag(tmp_path / "bag", [4, 30, 0, 6]), tmp_path / "out") == 0
    assert ids(tmp_path / "out") == [[0], [0], [], [0]]


def test_unusable_frames_are_recorded_counted_and_told(tmp_path, params, recogniser, capsys):
    folder = folder_of(tmp_path / "images", [1, 1, 9, 2, 9, 9, 9, 9])
    (folder / "1.png").write_bytes(bytes(30))
    (folder / "8.png").mkdir()
    assert run(params, folder, tmp_path / "out") == 0
    records = list(read_results(tmp_path / "out" / "detections.jsonl"))
    assert [r.frame for r in records] == [f"{n}.png" for n in range(9)]
    assert [r.error is None for r in records] == [True, False, False, True] + 5 * [False]
    assert records[1].detections == () and records[2].error == "a nine"
    assert summary_of(tmp_path / "out")["frames_with_error"] == 7
    said = capsys.readouterr().err
    assert "5 frame(s) could not be used: a nine (2.png, 4.png, 5.png, ...)\n" in said
    assert "1 frame(s) could not be used: is a folder; a file is wanted here (8.png)\n" in said
    assert len(list((tmp_path / "out" / "frames").iterdir())) == 9


def test_where_nothing_is_found_who_tells_why_is_named(tmp_path, params, recogniser, capsys):
    out = tmp_path / "out"
    assert run(params, folder_of(tmp_path / "images", [0]), out, "--images", "none", "--no-video") == 0
    assert (
        f"nothing was found: 'rejected' in {out / 'detections.jsonl'} may tell why, or artrec inspect {params}"
        in capsys.readouterr().err
    )


def test_where_no_image_can_be_used_nothing_is_said_of_objects(tmp_path, params, recogniser, capsys):
    assert run(params, folder_of(tmp_path / "images", [9, 9]), tmp_path / "out") == 1
    printed = capsys.readouterr().out
    assert "frames 2, no image could be used" in printed and f"why is told in {tmp_path / 'out'}" in printed
    assert "without any" not in printed and "results in" not in printed


def test_label_images_as_jpeg_are_told(tmp_path, params, recogniser, capsys):
    for name in ("a.jpg", "b.png"):
        (tmp_path / name[0]).mkdir()
        cv2.imwrite(str(tmp_path / name[0] / name), np.full((24, 32), 1, np.uint8))
        assert run(params, tmp_path / name[0], tmp_path / f"out_{name[0]}") == 0
        assert ("JPEG blurs class numbers" in capsys.readouterr().err) == (name[0] == "a")
        main(["inspect", str(params), str(tmp_path / name[0])])
        assert ("JPEG blurs class numbers" in capsys.readouterr().out) == (name[0] == "a")


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--images", "none"], "--images was all, now none;"),
        (["--no-video"], "--no-video was not given;"),
        (["--no-timing"], "--no-timing was not given;"),
        (["--labels"], "--labels was not given;"),
        (["--output-bag"], "--output-bag was not given, now mcap;"),
        (["--playback-duration", "3"], "--playback-duration was not given, now 3.0;"),
    ],
)
def test_what_differs_from_an_earlier_run_is_told_in_words_of_the_command(
    tmp_path, params, recogniser, capsys, more, said
):
    source = bag(tmp_path / "bag", [1])
    assert run(params, source, tmp_path / "out") == 0
    assert run(params, source, tmp_path / "out", *more) == 1
    assert said in capsys.readouterr().err


def test_no_usable_frame_at_all_is_a_failure(tmp_path, params, recogniser, capsys):
    assert run(params, bag(tmp_path / "bag", [9, 9]), tmp_path / "out") == 1
    said = capsys.readouterr().err
    assert "2 frame(s) could not be used: a nine\n" in said and "artrec: none of 2 frames could be used\n" in said


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_replay_leaves_what_it_has(tmp_path, params, recogniser, capsys, number):
    recogniser.at_frame[3] = lambda: os.kill(os.getpid(), number)
    before = signal.getsignal(signal.SIGTERM)
    assert run(params, bag(tmp_path / "bag", [1] * 6), tmp_path / "out") == 130
    assert len(list(read_results(tmp_path / "out" / "detections.jsonl"))) == 3  # the frame at hand is finished
    assert summary_of(tmp_path / "out")["interrupted"] is True
    assert "interrupted" in capsys.readouterr().out
    assert signal.getsignal(signal.SIGTERM) is before


def test_results_are_on_disk_frame_by_frame(tmp_path, params, recogniser):
    seen = []
    path = tmp_path / "out" / "detections.jsonl"
    recogniser.at_frame[3] = lambda: seen.extend(read_results(path))
    run(params, bag(tmp_path / "bag", [1] * 4), tmp_path / "out")
    assert len(seen) == 2


def test_existing_results_are_kept_unless_overwritten(tmp_path, params, recogniser, capsys):
    source, out = bag(tmp_path / "bag", [1, 1]), tmp_path / "out"
    assert run(params, source, out) == 0
    (out / "mine.txt").write_text("kept")
    assert run(params, source, out, "--images", "1", "--no-video") == 1
    said = capsys.readouterr().err
    assert "--images was all, now 1" in said and "--overwrite" in said
    assert len(list((out / "frames").iterdir())) == 2 and (out / "video.mp4").exists()
    assert run(params, source, out, "--overwrite", "--images", "1", "--no-video") == 0
    assert len(list((out / "frames").iterdir())) == 1 and not (out / "video.mp4").exists()
    assert (out / "mine.txt").exists()


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("detections.jsonl", "results already"),
        *((name, name) for name in ("video.mp4", "summary.json", "parameters.yaml", "bag_0")),
    ],
)
def test_files_of_nobody_knows_whom_are_kept(tmp_path, params, recogniser, capsys, name, told):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).write_text("mine")
    assert run(params, bag(tmp_path / "bag", [1]), tmp_path / "out") == 1
    said = capsys.readouterr().err
    assert f"holds {told}" in said and "--overwrite" in said
    assert (tmp_path / "out" / name).read_text() == "mine"
    assert [p.name for p in (tmp_path / "out").iterdir() if p.name != "frames"] == [name]


def test_a_journal_with_a_bad_line_is_gone_on_with_from_there(tmp_path, params, recogniser, capsys):
    source, out = bag(tmp_path / "bag", [1, 2, 3, 4]), tmp_path / "out"
    recogniser.at_frame[3] = lambda: os.kill(os.getpid(), signal.SIGINT)
    run(params, source, out)
    journal = out / "journal.jsonl"
    done = len(journal.read_text().splitlines())
    assert 1 < done < 4
    with journal.open("a") as stream:
        stream.write('{"bad": tru\n')
    seen, recogniser.at_frame = recogniser.seen, {}
    assert run(params, source, out) == 0
    assert recogniser.seen - seen == 4 - done
    assert f"journal.jsonl: line {done + 1} is no frame" in capsys.readouterr().err
    assert len(list(read_results(out / "detections.jsonl"))) == 4


def test_a_finished_replay_is_not_done_again(tmp_path, params, recogniser, capsys):
    source, out = bag(tmp_path / "bag", [1, 1, 9]), tmp_path / "out"
    assert run(params, source, out) == 0
    first, before = capsys.readouterr().out, (out / "summary.json").read_text()
    assert run(params, source, out) == 0
    assert recogniser.seen == 3 and (out / "summary.json").read_text() == before
    again = capsys.readouterr().out
    assert again.splitlines()[:-1] == first.splitlines()[:-1] and "--overwrite" in again


@pytest.mark.parametrize(
    ("content", "said"),
    [("{", "line 1: is no valid JSON"), ('{"looked_for": {}, "frames_with_error": 0}', "sources: this key is missing")],
)
def test_a_damaged_summary_is_told_with_the_way_out(tmp_path, params, recogniser, capsys, content, said):
    source, out = bag(tmp_path / "bag", [1]), tmp_path / "out"
    assert run(params, source, out) == 0
    (out / "summary.json").write_text(content)
    assert run(params, source, out) == 1
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith(f"artrec: {out / 'summary.json'}: {said}") and line.endswith("; --overwrite replays again")


@pytest.mark.parametrize("changed", ["source", "parameters", "object file"])
def test_a_replay_of_something_else_is_not_gone_on_with(tmp_path, params, recogniser, capsys, changed):
    source, out = folder_of(tmp_path / "images", [1]), tmp_path / "out"
    assert run(params, source, out) == 0
    if changed == "source":
        cv2.imwrite(str(source / "1.png"), np.ones((24, 32), np.uint8))
    elif changed == "parameters":
        params_of(params, **PARAMETERS, recognizer={"min_match": 0.5})
    else:
        (tmp_path / "arm.yaml").write_text(OBJECT.replace("0.05", "0.04"))
    assert run(params, source, out) == 1
    told = {"source": "images has changed", "parameters": "min_match was 0.55, not 0.5", "object file": "arm.yaml has"}
    assert told[changed] in capsys.readouterr().err


def test_an_interrupted_replay_goes_on_where_it_was(tmp_path, params, recogniser, monkeypatch):
    """What was interrupted and went on has the same results as what was not; no frame is recognised twice."""
    source = bag(tmp_path / "bag", [4, 5, 9, 30, 31, 0, 7, 8] * 3)
    options = ("--no-timing", "--output-bag")
    assert run(params, source, tmp_path / "whole", *options) == 0
    seen = recogniser.seen
    for stop in (2, 17, 3):
        recogniser.at_frame[recogniser.seen + stop] = lambda: os.kill(os.getpid(), signal.SIGINT)
        assert run(params, source, tmp_path / "out", *options) == 130
    assert run(params, source, tmp_path / "out", *options) == 0
    assert recogniser.seen == 2 * seen
    assert same_files(tmp_path / "whole", tmp_path / "out")


def same_files(first: Path, second: Path) -> bool:
    names = [sorted(p.relative_to(d).as_posix() for p in d.rglob("*") if p.is_file()) for d in (first, second)]
    return names[0] == names[1] and all((first / n).read_bytes() == (second / n).read_bytes() for n in names[0])


def test_no_two_replays_write_to_one_folder(tmp_path, params, recogniser, capsys):
    source, out = bag(tmp_path / "bag", [1, 1]), tmp_path / "out"
    codes = []
    recogniser.at_frame[1] = lambda: codes.append(run(params, source, out, "--overwrite"))
    assert run(params, source, out) == 0
    assert codes == [1] and "another run is writing there" in capsys.readouterr().err
    assert len(list(read_results(out / "detections.jsonl"))) == 2


@pytest.mark.parametrize("anew", [False, True])
def test_a_folder_that_is_removed_meanwhile_ends_the_replay(tmp_path, params, recogniser, capsys, anew):
    """Where another run has made it anew, nothing is written into that one, and nothing removed from it."""
    out, others = tmp_path / "out", "unfinished/video.mp4"

    def removed() -> None:
        out.rename(tmp_path / "old") if anew else shutil.rmtree(out)
        if anew:
            (out / "unfinished").mkdir(parents=True)
            (out / others).touch()

    recogniser.at_frame = {2: removed}
    assert run(params, bag(tmp_path / "bag", [1, 2, 3]), out) == 1
    assert "is gone" in (said := capsys.readouterr().err) and "make room" not in said
    assert recogniser.seen == 2
    assert [p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()] == [others] * anew


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


@pytest.mark.parametrize("folder", ["bag", "frames"])
def test_an_offset_beyond_the_end_is_told(tmp_path, params, recogniser, capsys, folder):
    bag(tmp_path / "bag", [1, 2, 3])
    folder_of(tmp_path / "frames", [1, 1])
    assert run(params, tmp_path / folder, tmp_path / "out", "--start-offset", "100") == 1
    told = capsys.readouterr().err
    assert told.count(f"{tmp_path / folder}: nothing of it is read: it lasts 0.") == 1
    assert "s, --start-offset is 100" in told and "there was no frame" in told


def test_a_truncated_bag_is_replayed_as_far_as_it_goes(tmp_path, params, recogniser, capsys):
    file = bag(tmp_path / "bag", [1] * 40) / "bag.mcap"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    assert run(params, file, tmp_path / "out", "--no-video") == 0
    assert 0 < recogniser.seen < 40
    assert f"{file}: it ends in the middle" in capsys.readouterr().err


def test_each_run_builds_its_recogniser_anew(tmp_path, params, monkeypatch):
    """As somebody needs who changes the recogniser between two replays in one process."""
    source, built = bag(tmp_path / "bag", [1]), []
    monkeypatch.setattr(Setup, "build", lambda self, **how: built.append(1) or Recogniser())
    for name in ("a", "b"):
        assert run(params, source, tmp_path / name) == 0
    assert run(params, source, tmp_path / "b", "--overwrite") == 0
    assert len(built) == 3


def test_a_calibration_for_another_size_warns_as_a_missing_one_does(tmp_path, params, recogniser, capsys, monkeypatch):
    dog = {"object_file": str(CONFIG / "objects" / "quadruped.yaml"), "label": 3}
    params_of(tmp_path / "dog.yaml", objects=["dog"], dog=dog)
    matrix = np.array([[40.0, 0, 24], [0, 40, 16], [0, 0, 1]])
    (tmp_path / "other.yaml").write_text(camera_yaml(Camera(matrix, np.zeros(5), (48, 32), "o")))
    (tmp_path / "own.yaml").write_text(camera_yaml(Camera(matrix, np.zeros(5), (32, 24), "o")))
    folder_of(tmp_path / "images", [1])
    says = "dog: will not be found: it has no constraint_file, and it is not flat"
    monkeypatch.chdir(tmp_path)  # it is told once, however the folder is called where it is read
    for name, times in (("other", 1), ("own", 0)):
        camera = "--camera-info", str(tmp_path / f"{name}.yaml")
        assert run(tmp_path / "dog.yaml", Path("images"), tmp_path / name, *camera) == 0
        said = capsys.readouterr().err
        assert said.count(says) == times and said.count("calibrated for 48x32 pixels") == times


def test_what_cannot_be_found_for_want_of_constraints_is_told_once(tmp_path, params, recogniser, capsys):
    shutil.copy(CONFIG / "objects" / "pendulum.yaml", tmp_path / "flat.yaml")
    flat = params_of(tmp_path / "flat_params.yaml", objects=["bob"], bob={"object_file": "flat.yaml", "label": 3})
    assert run(flat, bag(tmp_path / "bag", [1, 1]), tmp_path / "out") == 0
    said = capsys.readouterr().err
    assert said.count("bob: will not be found: it has no constraint_file") == 1
    assert "learn constraints with artrec train and name their file in bob.constraint_file" in said


@pytest.mark.parametrize(("objects", "told"), [("mirosot", False), ("quadruped", True)])
def test_only_what_needs_calibration_is_missed_for_want_of_it(tmp_path, recogniser, capsys, objects, told):
    shown = {"object_file": str(CONFIG / "objects" / f"{objects}.yaml"), "label": 3}
    names = {"green": 4, "red": 5, "violet": 6}
    image = {"kind": "labels", "classes": list(names), **{name: {"label": n} for name, n in names.items()}}
    params = params_of(tmp_path / "params.yaml", objects=["it"], it=shown, image=image)
    assert run(params, folder_of(tmp_path / "images", [1]), tmp_path / "out") == 0
    assert ("images have no calibration" in capsys.readouterr().err) == told
