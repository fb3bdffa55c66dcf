"""benchmarks/beside_tags.py: tags are drawn where they are said to be, and each rival tells poses in the same frame."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from artrec_ros.core.geometry.projection import project
from artrec_ros.simulation.config import SensorConfig
from artrec_ros.simulation.render import Renderer

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
import beside_tags

NEEDS = {"apriltag": "pupil_apriltags", "stag": "stag"}


@pytest.fixture(scope="module")
def renderer():
    return Renderer(beside_tags.CAMERA)


@pytest.mark.parametrize("name", ["aruco", "apriltag", "stag"])
def test_a_tag_is_found_where_it_is(name, renderer):
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason=f"{NEEDS[name]} is not installed")
    rival, offsets = getattr(beside_tags, name)(), []
    rngs = [np.random.default_rng(seed) for seed in range(6)]
    for pose, rng in zip(beside_tags.places(0.5, 20.0, rngs), rngs, strict=True):
        image = beside_tags.picture(rival, pose, renderer, SensorConfig().scaled(0), rng)
        (seen,) = rival.detect(image)
        assert seen.number == rival.number
        assert np.arccos((np.trace(seen.pose.rotation.T @ pose.rotation) - 1) / 2) < np.radians(3)
        at = project(beside_tags.CAMERA, np.array([seen.pose.position, pose.position]))
        offsets.append(at[0] - at[1])
    assert np.abs(np.mean(offsets, axis=0)).max() < 0.05, "pixels are counted from their centres"


def test_both_kinds_of_marker_have_one_area():
    (marker,) = beside_tags.target().model.required.markers
    assert marker.area == pytest.approx(beside_tags.SIDE_M**2)
    tag = beside_tags.aruco()
    assert tag.bitmap is not None and tag.bitmap[[0, -1]].all() and tag.bitmap[:, [0, -1]].all(), "black to its edge"
