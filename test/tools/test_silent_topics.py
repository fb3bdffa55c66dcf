"""What `artrec inspect` says of topics is what becomes of them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from artrec_ros.io.messages import node_topics as topics
from artrec_ros.io.messages.detection_messages import header
from artrec_ros.io.messages.object_messages import OBJECT_MAKERS
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.sources.opening import open_sources
from artrec_ros.tools.inspecting.silent_topics import silent_topics
from artrec_ros.tools.main import main

CONFIG = Path(__file__).parents[2] / "config"
FILLED = ("poses", "transforms", "joint_names", "name", "status", "pose")  # fields that hold what is told


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenes") / "simulated"
    model = CONFIG / "objects" / "excavator.yaml"
    options = ["--frames", "4", "--seed", "2", "--size", "0.6", "0.9", "--noise", "0"]
    assert main(["simulate", str(model), "-o", str(folder), *options]) == 0
    return folder / "bag"


def told_empty(setup, calibrated):
    """Topics that are said to stay empty."""
    lines = list(silent_topics(setup, calibrated))
    silent = [line for line in lines if re.search(r" stays? empty: ", line)]
    return {
        t.name
        for t in topics.OBJECT_OUTPUTS
        for line in silent
        if f"{t.of('<object>')} " in f"{line.replace(',', ' ')} "
    }


def filled(setup, bag, calibrated):
    """Topics of which a message held something."""
    recognizer, found = setup.build(), set()
    with open_sources([bag]) as sources:
        for frame in sources.parts[0]:
            detections = recognizer.recognize(frame.image, frame.camera if calibrated else None).detections
            for topic, make in OBJECT_MAKERS.items():
                for message in make(detections, "eye", lambda frame_id: header(0, frame_id)):
                    if any(message.fields.get(field) for field in FILLED):
                        found.add(topic.name)
    return found


@pytest.mark.parametrize("calibrated", [True, False])
@pytest.mark.parametrize("more", ["", "{whole_object: false}", "{profile: paper, min_match: 0.5}"])
def test_topics_that_stay_empty_are_empty_and_the_others_are_not(tmp_path, scenes, more, calibrated):
    (tmp_path / "more.yaml").write_text(f"/**: {{ros__parameters: {{recognizer: {more or '{}'}}}}}")
    setup = load_parameters(CONFIG / "excavator.yaml", tmp_path / "more.yaml")
    assert {t.name for t in topics.OBJECT_OUTPUTS} - filled(setup, scenes, calibrated) == told_empty(setup, calibrated)


def lines(name, calibrated, tmp_path, more="{}"):
    (tmp_path / "more.yaml").write_text(f"/**: {{ros__parameters: {more}}}")
    return list(silent_topics(load_parameters(CONFIG / name, tmp_path / "more.yaml"), calibrated))


def test_reasons(tmp_path):
    assert any(
        "<object>/poses, <object>/robots, <object>/pose of yellow, blue stay empty: the images have no calibration"
        in line
        for line in lines("vss.yaml", False, tmp_path)
    )
    without_images = lines("vss.yaml", None, tmp_path)
    assert any("of yellow, blue stay empty where images come without calibration" in line for line in without_images)
    assert any("their tilt is not known" in line for line in lines("vss.yaml", True, tmp_path))
    assert any("declare no moving joint" in line for line in without_images)
    in_space = lines("aibo.yaml", True, tmp_path)
    assert not any("poses" in line or "joint_states" in line for line in in_space)
    assert any("joint_states of red, blue stays empty where" in line for line in lines("aibo.yaml", None, tmp_path))
    assert any("found as a whole, and they are not" in line for line in lines("aibo.yaml", False, tmp_path))
    assert any(
        "profile 'paper'" in line for line in lines("aibo.yaml", True, tmp_path, "{recognizer: {profile: paper}}")
    )


def test_joints_of_what_is_flat_need_no_calibration(tmp_path):
    robot = {
        "format": "artrec_object/1",
        "name": "robot",
        "markers": {"plate": {"rectangle": {"width": 0.1, "height": 0.06}}},
        "components": {
            "base": {"required": True, "markers": {"plate": {"pose": {"xyz": [0, 0, 0]}}}},
            "arm": {
                "markers": {"plate": {"pose": {"xyz": [0.1, 0, 0]}}},
                "label": 4,
                "joint": {"parent": "base", "axis": [0, 0, 1], "limits": [-1, 1]},
            },
        },
    }
    (tmp_path / "robot.yaml").write_text(json.dumps(robot))
    (tmp_path / "p.yaml").write_text(
        "/**: {ros__parameters: {objects: [robot], robot: {object_file: robot.yaml, label: 3}}}"
    )
    told = list(silent_topics(load_parameters(tmp_path / "p.yaml"), None))
    assert told and not any("joint_states" in line for line in told)


def test_tf_is_told(tmp_path):
    assert "/tf stays empty: publish_tf is false" in lines("aibo.yaml", True, tmp_path)
    assert not any("/tf" in line for line in lines("aibo.yaml", True, tmp_path, "{publish_tf: true}"))
    (line,) = (line for line in lines("aibo.yaml", False, tmp_path, "{publish_tf: true}") if "/tf" in line)
    assert line == "/tf stays empty: no pose in space is told"


def test_inspect_says_it_of_the_parameters_beside_their_images(tmp_path, scenes, capsys):
    params = CONFIG / "excavator.yaml"
    assert main(["inspect", str(params)]) == 0
    assert "  <object>/joint_states of excavator stays empty where images come without" in capsys.readouterr().out
    assert main(["inspect", str(params), str(scenes)]) == 0
    assert "joint_states" not in capsys.readouterr().out.replace("/ground_truth/excavator/joint_states", "")
