"""The examples in the documentation work."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from tutorial import PICTURES, Command, SaveFile, alternatives, steps

from artrec_ros.io.parameters import load_parameters
from artrec_ros.io.results import read_results
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
