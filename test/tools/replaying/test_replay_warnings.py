"""What a replay tells of images that cannot be used, of what is not found, and why."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from arm_replays import bag, folder_of, params_of, run, summary_of

from artrec_ros.core.base.config import PlaneConfig, SceneConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.model.frame_result import Rejection
from artrec_ros.io.images.cameras import camera_yaml
from artrec_ros.io.results.results import FrameRecord, read_results
from artrec_ros.io.sources.frames import SourceOptions
from artrec_ros.io.sources.opening import open_sources
from artrec_ros.tools.main import main
from artrec_ros.tools.replaying.summary import Summary

CONFIG = Path(__file__).parents[3] / "config"


def test_the_limits_that_cut_frames_short_are_told_apart():
    time, nodes = "recognizer.time_budget_ms", "expert.grouping.search_nodes"
    summary = Summary()
    for t, ended_by in enumerate(((), (nodes,), (nodes,), (time, nodes))):
        summary.add(FrameRecord(t, "/c", (8, 6), ended_by=ended_by))
    assert summary.to_dict()["frames_cut_short_by"] == {nodes: 3, time: 1}
    told = [line for line in summary.lines() if "cut short" in line]
    assert told == [f"{count} frame(s) were cut short by {limit}" for limit, count in ((nodes, 3), (time, 1))]


def test_why_frames_have_no_object_is_told_by_the_reason_that_most_have():
    """Of each frame the one of what came nearest; reasons that differ by numbers alone are one."""
    summary = Summary()
    summary.add(FrameRecord(0, "/c", (8, 6)))
    assert not [line for line in summary.lines() if line.startswith("why not")]
    near, far = (Rejection("red", f"its outline fits by {n}", n) for n in (0.2, 0.3))
    for t, rejected in enumerate([(Rejection("red", "too far", 0.5),), (near, Rejection("red", "too far")), (far,)], 1):
        summary.add(FrameRecord(t, "/c", (8, 6), rejected=rejected))
    told = [line for line in summary.lines() if line.startswith("why not")]
    assert told == ["why not, most often (in 2 of these; all reasons: detections.jsonl): red: its outline fits by 0.2"]


def test_how_far_off_the_planes_scale_things_are_is_told_where_many_are_turned_down_for_it():
    plane = PlaneConfig((0, 0, 100, 0, 100, 100, 0, 100), (0, 0, 1, 0, 1, -1, 0, -1), scale_tolerance=0.1)
    scene, at = Scene.of(SceneConfig(plane=plane)), np.full((1, 2), 50.0)
    (reason,), (other,), (within,) = (scene.reasons(at, np.array([scale])) for scale in (140.0, 135.0, 100.0))
    assert within is None
    few, many = Summary(), Summary()
    chance, alike, clutter = Rejection("red", reason, 0.9), Rejection("red", other, 0.8), Rejection("red", reason, 0.1)
    few.add(FrameRecord(0, "/c", (8, 6), rejected=(chance, alike, clutter, clutter)))
    assert not [line for line in few.lines() if "scene.plane" in line and "why not" not in line]
    many.add(FrameRecord(0, "/c", (8, 6), rejected=(chance, alike, chance, chance, clutter)))
    (told,) = (line for line in many.lines() if "but their scale" in line)
    assert told.startswith("4 candidates beside 0 objects") and "1.40 times that of scene.plane" in told
    assert told.endswith("scene.plane.scale_tolerance 0.40 would keep nine in ten")


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


def test_no_usable_frame_at_all_is_a_failure(tmp_path, params, recogniser, capsys):
    assert run(params, bag(tmp_path / "bag", [9, 9]), tmp_path / "out") == 1
    said = capsys.readouterr().err
    assert "2 frame(s) could not be used: a nine\n" in said and "artrec: none of 2 frames could be used\n" in said


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


def damaged_bag(path: Path) -> Path:
    path.write_bytes(b"no bag" * 99)
    return path


def test_a_damaged_source_is_a_problem_and_the_others_are_replayed(tmp_path, params, recogniser, capsys):
    bad, out = damaged_bag(tmp_path / "bad.mcap"), tmp_path / "out"
    images = [str(folder_of(tmp_path / name, [1, 0])) for name in ("a", "b")]
    assert run(params, images[0], out, "--no-video", "--images", "none") == 0
    alone = list(read_results(out / "detections.jsonl"))
    command = ["replay", images[0], str(bad), images[1], "--params-file", str(params), "-o", str(tmp_path / "several")]
    for _ in range(2):  # done, and done before
        assert main([*command, "--no-video", "--images", "none", "--no-timing"]) == 0
        said = capsys.readouterr().err
        assert f"{bad}: it starts like no bag (mcap, sqlite3, ROS 1); nothing could be read\n" in said
    summary, records = summary_of(tmp_path / "several"), list(read_results(tmp_path / "several" / "detections.jsonl"))
    assert [s["frames"] for s in summary["per_source"]] == [2, 0, 2] and str(bad) in summary["problems"][0]
    assert [r.source for r in records] == [0, 0, 2, 2]
    assert [r.detections for r in records[:2]] == [r.detections for r in alone]


def test_where_all_sources_are_damaged_or_one_is_none_nothing_is_replayed(tmp_path, params, recogniser, capsys):
    bad = [str(damaged_bag(tmp_path / name)) for name in ("a.mcap", "b.mcap")]
    images = str(folder_of(tmp_path / "images", [1]))
    for sources, told in ((bad, "a.mcap: it starts like no bag"), ([images, str(tmp_path / "imags2")], "no such file")):
        assert main(["replay", *sources, "--params-file", str(params), "-o", str(tmp_path / "out")]) == 1
        assert told in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_damaged_sources_say_nothing_of_calibrations(tmp_path):
    with open_sources([bag(tmp_path / "bag", [1]), damaged_bag(tmp_path / "bad.mcap")],
                      SourceOptions(topic="/cam/labels"), keep_going=True) as sources:  # fmt: skip
        assert sources.calibrated == {True} and sources.starts_calibrated() and len(list(sources)) == 1
