"""benchmarks/beside_tags.py: tags are drawn where they are said to be, and each rival tells poses in the same frame."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from artrec_ros.core.geometry.projection import project
from artrec_ros.simulation.config import SensorConfig
from artrec_ros.simulation.render import Renderer

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "benchmarks"))
import beside_tags  # noqa: E402  (lies beside the package)

NEEDS = {"apriltag": "pupil_apriltags", "stag": "stag"}


def check(name: str) -> None:
    """Each tag is found, with its number, at its pose."""
    rival, offsets, renderer = getattr(beside_tags, name)(), [], Renderer(beside_tags.CAMERA)
    rngs = [np.random.default_rng(seed) for seed in range(6)]
    for pose, rng in zip(beside_tags.places(0.5, 20.0, rngs), rngs, strict=True):
        image = beside_tags.picture(rival, pose, renderer, SensorConfig().scaled(0), rng)
        (seen,) = rival.detect(image)
        assert seen.number == rival.number
        assert np.arccos((np.trace(seen.pose.rotation.T @ pose.rotation) - 1) / 2) < np.radians(3)
        at = project(beside_tags.CAMERA, np.array([seen.pose.position, pose.position]))
        offsets.append(at[0] - at[1])
    assert np.abs(np.mean(offsets, axis=0)).max() < 0.05, "pixels are counted from their centres"
    print("found", flush=True)


@pytest.mark.parametrize("name", ["aruco", "apriltag", "stag"])
def test_a_tag_is_found_where_it_is(name):
    """In a process of its own: pupil-apriltags may abort the one that it is in, some time after its work."""
    if name in NEEDS and importlib.util.find_spec(NEEDS[name]) is None:
        pytest.skip(f"{NEEDS[name]} is not installed")
    program = f"import test_beside_tags; test_beside_tags.check({name!r})"
    path = os.pathsep.join([str(ROOT), str(ROOT / "test")])
    environment = {**os.environ, "PYTHONPATH": path}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300, env=environment)
    assert "found" in done.stdout, done.stderr


def test_both_kinds_of_marker_have_one_area():
    (marker,) = beside_tags.target().model.required.markers
    assert marker.area == pytest.approx(beside_tags.SIDE_M**2)
    tag = beside_tags.aruco()
    assert tag.bitmap is not None and tag.bitmap[[0, -1]].all() and tag.bitmap[:, [0, -1]].all(), "black to its edge"
