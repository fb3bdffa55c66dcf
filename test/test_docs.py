"""The examples in the documentation work."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from tutorial import PICTURES, Command, SaveFile, alternatives, steps

from artrec_ros.core.model.found import ClassFit, ConstraintFailure, Rejection
from artrec_ros.io.parameters import load_parameters
from artrec_ros.io.results import FrameRecord, read_results
from artrec_ros.io.truth import load_truth
from artrec_ros.tools.main import main

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    """A folder in which the tutorial was followed, with fewer frames."""
    pytest.importorskip("svgelements")
    folder = tmp_path_factory.mktemp("tutorial")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for step in steps():
            if isinstance(step, SaveFile):
                step.save(folder)
            else:
                run(step)
    return folder


def run(step: Command):
    program, *arguments = step.arguments
    assert program == "artrec"
    if "--frames" in arguments:
        arguments[arguments.index("--frames") + 1] = "4"
    assert main(arguments) == 0, step


def test_the_tutorial_leads_to_poses(followed):
    truth = load_truth(followed / "simulated/truth.jsonl")
    records = [r for r in read_results(followed / "result/detections.jsonl") if r.complete]  # the first may compile
    assert len(records) >= 3
    for record in records:
        (true,), (found,) = truth[record.stamp_ns], record.detections
        assert np.linalg.norm(found.pose.position - true.pose.position) < 0.02 * np.linalg.norm(true.pose.position)
    joints = {name for record in records for d in record.detections for name in d.joints}
    assert joints == {"tilt", "lift"}


def test_the_tutorials_pictures_are_made_by_its_commands(followed):
    page = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
    for name, made in PICTURES.items():
        assert len(list(followed.glob(made))) == 1 and (ROOT / "docs/images" / name).is_file()
        assert f"images/{name}" in page


def test_the_tutorials_other_parameters_are_valid(followed):
    (colour,) = alternatives()
    parameters = yaml.safe_load((followed / "forklift_params.yaml").read_text())
    parameters["/**"]["ros__parameters"] |= yaml.safe_load(colour)
    path = followed / "colour_params.yaml"
    path.write_text(yaml.safe_dump(parameters))
    setup = load_parameters(path)
    assert setup.image.kind == "colour" and setup.targets[0].label == 3


@pytest.mark.parametrize("page", ["README.md", *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("*.md"))])
def test_links_lead_somewhere(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    links = [t.split("#")[0] for t in re.findall(r"\]\(([^)]+)\)", text) if "://" not in t]
    missing = [link for link in links if link and not ((ROOT / page).parent / link).exists()]
    assert not missing


def test_the_format_of_detections_is_told():
    """Every key that a replay may write stands in the section, and its example is a line of a replay."""
    section = (ROOT / "docs/replay.md").read_text(encoding="utf-8").partition("## detections.jsonl")[2]
    section = section.partition("\n## ")[0]
    example, rejection = re.findall(r"```json\n(.*?)```", section, re.DOTALL)
    record = FrameRecord.from_json(example.replace("\n", ""))
    assert json.loads(record.to_json()) == json.loads(example)
    failed = ConstraintFailure("a/b", "c/d", "turn_rad", 1.0, 0.0, 0.5, 0.5)
    everything = replace(
        record,
        source=1,
        error="why",
        detections=(replace(record.detections[0], class_fit=ClassFit(None, 0.1, "b", 0.2, "why"), margin=0.5),),
        rejected=(Rejection("red", "why", 0.5, 1.0, 2.0, failed),),
    )
    told = set(re.findall(r"`(\w+)`", section))
    named = {name for d in record.detections for name in d.joints}
    assert keys_of(json.loads(everything.to_json())) - named <= told
    assert keys_of(json.loads(rejection)) <= told


def keys_of(content) -> set[str]:
    if isinstance(content, list):
        return set().union(*map(keys_of, content)) if content else set()
    if not isinstance(content, dict):
        return set()
    return set(content).union(*map(keys_of, content.values()))
