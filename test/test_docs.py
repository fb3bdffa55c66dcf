"""The examples in the documentation work."""

import re
from pathlib import Path

import pytest
import yaml

from artrec_ros.core.datatypes import Target
from artrec_ros.io.objects import load_object
from artrec_ros.io.parameters import setup_from_flat
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import pinhole_camera, simulate

ROOT = Path(__file__).parents[1]
BLOCKS = re.findall(r"```yaml\n(.*?)```", (ROOT / "docs/tutorial.md").read_text(encoding="utf-8"), re.DOTALL)


@pytest.fixture
def lamp(tmp_path):
    path = tmp_path / "lamp.yaml"
    path.write_text(BLOCKS[0], encoding="utf-8")
    return path


def test_the_tutorials_object_renders(lamp):
    model = load_object(lamp, {})
    frames = simulate([Target("lamp", model, 2)], pinhole_camera((160, 120), 60), SceneConfig(), SensorConfig(), 0, 4)
    shown = {m.marker for frame in frames for truth in frame.truths for m in truth.markers if m.visible_px > 0}
    assert shown == {"house", "ribbon"}


def test_the_tutorials_parameters_are_valid(lamp):
    labels = yaml.safe_load(BLOCKS[1])["/**"]["ros__parameters"]
    del labels["lamp"]["constraint_file"]  # made by the tutorial's training step
    colour = labels | yaml.safe_load(BLOCKS[2])
    for parameters, kind in ((labels, "labels"), (colour, "colour")):
        setup = setup_from_flat(_flat(parameters), lamp.parent, lamp)
        assert setup.image.kind == kind and setup.targets[0].label == 2


@pytest.mark.parametrize("page", ["README.md", *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("*.md"))])
def test_links_lead_somewhere(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    links = [t.split("#")[0] for t in re.findall(r"\]\(([^)]+)\)", text) if "://" not in t]
    missing = [link for link in links if link and not ((ROOT / page).parent / link).exists()]
    assert not missing


def _flat(values, prefix=""):
    out = {}
    for key, value in values.items():
        out |= _flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {prefix + key: value}
    return out
