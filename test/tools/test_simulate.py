import argparse
import json
from pathlib import Path

import pytest

from artrec_ros.core.errors import ConfigError
from artrec_ros.io.annotations import load_coco
from artrec_ros.io.truth import load_truth
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
        ([OBJECTS / "excavator.yaml", "--image-size", "1", "1"], "--image-size: 1 1"),
        ([OBJECTS / "excavator.yaml", "--view-angle", "180"], "--view-angle: 180"),
        ([OBJECTS / "excavator.yaml", "--size", "0.9", "0.2"], "scene.size"),
    ],
)
def test_wrong_usage_is_told_and_writes_nothing(tmp_path, arguments, message):
    with pytest.raises(ConfigError, match=message):
        run(*arguments, "-o", tmp_path / "out")
    assert not (tmp_path / "out").exists()
