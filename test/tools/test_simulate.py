import argparse
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.learned.annotations import load_coco
from artrec_ros.io.truth.records import load_truth
from artrec_ros.tools import simulate

OBJECTS = Path(__file__).parents[2] / "config" / "objects"
SMALL = ["--frames", "3", "--image-size", "160", "120", "--size", "0.5", "0.9"]


def run(*arguments):
    parser = argparse.ArgumentParser()
    simulate.add_parser(parser.add_subparsers())
    args = parser.parse_args(["simulate", *map(str, arguments)])
    return args.run(args)


@pytest.mark.parametrize("name", ["excavator", "quadruped"])
def test_what_it_writes_is_what_training_and_scoring_read(tmp_path, capsys, name):
    assert run(OBJECTS / f"{name}.yaml", "-o", tmp_path / "out", *SMALL) == 0
    assert str(tmp_path / "out") in capsys.readouterr().out
    annotations = load_coco([tmp_path / "out/annotations.json"])
    assert set(annotations.categories) == {name} and 1 <= len(annotations.objects) <= 3
    truth = load_truth(tmp_path / "out/truth.jsonl")
    assert [len(objects) for objects in truth.values()] == [1, 1, 1]
    assert {o.label for objects in truth.values() for o in objects} == {2}


def test_several_objects_bear_the_labels_given(tmp_path):
    files = [OBJECTS / "excavator.yaml", OBJECTS / "quadruped.yaml"]
    scene = ["--objects", "2", "2", "--label", "4", "7", "--size", "0.2", "0.3", "--frames", "8"]
    run(*files, "-o", tmp_path / "out", *SMALL, *scene)
    lines = (tmp_path / "out/truth.jsonl").read_text().splitlines()
    teams = {(o["object"], o["team"]) for line in lines for o in json.loads(line)["objects"]}
    assert teams == {("excavator", 4), ("quadruped", 7)}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "one of the two"),
        ([OBJECTS / "excavator.yaml", "--label", "2", "3"], "--label: 2 given for 1"),
        ([OBJECTS / "excavator.yaml", OBJECTS / "excavator.yaml"], "same name"),
        ([OBJECTS / "excavator.yaml", "--frames", "0"], "--frames: 0"),
        ([OBJECTS / "excavator.yaml", "--noise", "nan"], "--noise: nan is not within 0 .. 1000"),
        ([OBJECTS / "excavator.yaml", "--noise", "1e300"], "--noise: 1e.300 is not within 0 .. 1000"),
        ([OBJECTS / "excavator.yaml", "--image-size", "1", "1"], "--image-size: 1 1"),
        ([OBJECTS / "excavator.yaml", "--view-angle", "180"], "--view-angle: 180"),
        ([OBJECTS / "excavator.yaml", "--size", "0.9", "0.2"], "scene.size"),
        ([OBJECTS / "excavator.yaml", "--spots", "-1"], "sensor.spots"),
        ([OBJECTS / "excavator.yaml", "--speed", "1"], "--speed goes with --motion"),
        ([OBJECTS / "excavator.yaml", "--floor-label", "6"], "--floor-label: 6 is a label of 'excavator'"),
    ],
)
def test_wrong_usage_is_told_and_writes_nothing(tmp_path, arguments, message):
    with pytest.raises(ConfigError, match=message):
        run(*arguments, "-o", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_floor_has_a_class_of_its_own(tmp_path):
    """Of an object whose label is that of floors it is another one."""
    run(OBJECTS / "quadruped.yaml", "-o", tmp_path / "out", *SMALL, "--label", "1", "--frames", "2")
    assert {o["team"] for objects in truth_of(tmp_path / "out") for o in objects} == {1}
    codes = np.unique(cv2.imread(str(next((tmp_path / "out/images").glob("*.png"))), cv2.IMREAD_UNCHANGED))
    assert len(codes) > 1 and {1, 2} <= set(codes.tolist())


def truth_of(folder):
    return [json.loads(line)["objects"] for line in (folder / "truth.jsonl").read_text().splitlines()]


def test_with_motion_objects_move_and_joints_swing_smoothly(tmp_path):
    run(OBJECTS / "excavator.yaml", "-o", tmp_path / "out", *SMALL, "--motion", "--swing-hz", "1")
    frames = truth_of(tmp_path / "out")
    assert all(len(objects) == 1 for objects in frames)
    for (a,), (b,) in zip(frames, frames[1:], strict=False):
        assert 0 < sum(abs(x - y) for x, y in zip(a["position"], b["position"], strict=True)) < 0.1
        assert 0 < sum(abs(a["joints"][name] - b["joints"][name]) for name in a["joints"]) < 1


def test_each_disturbance_can_be_set(tmp_path):
    for name, more in (("clean", []), ("spotted", ["--spots", "40"]), ("again", ["--spots", "40"])):
        run(OBJECTS / "excavator.yaml", "-o", tmp_path / name, *SMALL, "--noise", "0", *more)
    images = {name: (tmp_path / name / "images/0000.png").read_bytes() for name in ("clean", "spotted", "again")}
    assert images["spotted"] == images["again"] != images["clean"]
    assert truth_of(tmp_path / "clean")[0][0]["position"] == truth_of(tmp_path / "spotted")[0][0]["position"]
