"""The way that scripts/demo goes, on fewer frames, and the script's care for what it did not make."""

import importlib.util
import json
import shutil
import subprocess
from pathlib import Path

import pytest

from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.tools.main import main

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    config = folder / "config"
    (config / "objects").mkdir(parents=True)
    (config / "constraints").mkdir()
    shutil.copy(ROOT / "config/excavator.yaml", config)
    model = shutil.copy(ROOT / "config/objects/excavator.yaml", config / "objects")
    size = ["--size", "0.4", "0.9"]
    examples = [folder / "train", "--frames", 60, "--seed", 1, *size]
    steps = [
        ["simulate", model, "-o", *examples],
        ["train", "--object", model, "--annotations", folder / "train/annotations.json"]
        + ["--output", config / "constraints/excavator.yaml"],
        ["simulate", model, "-o", folder / "test", "--frames", 10, "--seed", 2, "--objects", 1, 2, *size],
        ["replay", folder / "test/bag", "--params-file", config / "excavator.yaml", "-o", folder / "replay"],
        ["evaluate", folder / "replay", "--truth", folder / "test/truth.jsonl"],
    ]
    for step in steps:
        assert main([str(word) for word in step]) == 0, step
    return folder


def test_most_excavators_are_found_and_few_invented(demo):
    metrics = json.loads((demo / "replay/metrics.json").read_text())["all"]
    assert metrics["counts"]["frames"] == 10 and metrics["counts"]["frames_without_result"] == 0
    assert metrics["recognition_rate"]["value"] >= 0.6  # some are turned away and show a single marker
    assert metrics["right_rate"]["value"] >= 0.35
    assert metrics["false_per_frame"]["value"] <= 0.2
    assert metrics["component_precision"]["value"] >= 0.95
    assert metrics["component_recall"]["value"] >= 0.7


def test_they_are_found_in_space(demo):
    lines = (demo / "replay/detections.jsonl").read_text().splitlines()
    found = [d for line in lines for d in json.loads(line)["objects"]]
    assert found and all(d["pose"] for d in found)
    assert all(d["joints"] for d in found if len(d["components"]) > 1)  # the joints of what is in view
    metrics = json.loads((demo / "replay/metrics.json").read_text())["objects"]["excavator"]
    assert metrics["position_error_median"]["value"] <= 0.03  # of the distance
    assert metrics["rotation_error_deg_median"]["value"] <= 6


def test_each_frame_has_its_picture(demo):
    assert len(list((demo / "replay/frames").iterdir())) == 10


def test_the_documentations_pictures_are_made_of_it(demo, monkeypatch):
    """docs/images/demo.py: overlays of the demo, and the same object without places in space."""
    spec = importlib.util.spec_from_file_location("demo_pictures", ROOT / "docs/images/demo.py")
    assert spec is not None and spec.loader is not None
    pictures = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pictures)
    monkeypatch.setattr(pictures, "FRAMES", (0, 3, 5, 9))
    width, height = pictures.PICTURE
    assert pictures.demo_picture(demo / "replay").shape == (2 * height, 2 * width, 3)
    (flat,) = load_parameters(pictures.without_space(demo)).targets
    (whole,) = load_parameters(demo / "config/excavator.yaml").targets
    assert whole.model.is_spatial and not flat.model.is_spatial
    assert [c.name for c in flat.model.components] == [c.name for c in whole.model.components]


def test_the_script_leaves_folders_alone_that_it_did_not_make(tmp_path):
    (tmp_path / "precious").write_text("mine")
    done = subprocess.run(["sh", str(ROOT / "scripts/demo"), str(tmp_path)], capture_output=True, text=True, timeout=20)
    assert done.returncode == 1 and "not an earlier demo's" in done.stderr
    assert (tmp_path / "precious").read_text() == "mine"
