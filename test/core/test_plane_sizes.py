"""How large objects look on the scene's plane, and what all of them together say of it."""

from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.model.found import Detection, ImagePose
from artrec_ros.core.plane_sizes import PlaneSizes

PLACES = np.random.default_rng(2).uniform((0, 0), (640, 480), (40, 2))


def line_of(scale, score=0.95, places=PLACES, noise=0.01, seed=3):
    """:param scale: of places (n, 2) how many times as large what is there looks."""
    sizes = PlaneSizes()
    noise = np.random.default_rng(seed).normal(0, noise, len(places))
    for (x, y), large in zip(places.tolist(), (scale(places) * np.exp(noise)).tolist(), strict=True):
        sizes.add([Detection("robot", 0, score, ImagePose(x, y, 0.0, 400.0), (), plane_scale=large)])
    return sizes.line()


def test_what_is_as_large_as_it_should_be_says_nothing():
    assert line_of(lambda at: np.ones(len(at))) is None
    assert line_of(lambda at: np.full(len(at), 1.05)) is None


def test_few_small_ones_that_scatter_say_nothing():
    lines = [line_of(lambda at: np.full(len(at), 1.05), places=PLACES[:12], noise=0.06, seed=n) for n in range(40)]
    assert sum(line is not None for line in lines) <= 2
    assert line_of(lambda at: np.full(len(at), 1.25), places=PLACES[:12], noise=0.06) is not None


@pytest.mark.parametrize(("scale", "told"), [(1.2, "20 % larger"), (0.8, "20 % smaller")])
def test_a_plane_of_another_size_is_told(scale, told):
    line = line_of(lambda at: np.full(len(at), scale))
    assert told in line and "scene.plane" in line and "40 of them" in line


def test_a_tilted_plane_is_told_by_where_objects_are():
    line = line_of(lambda at: np.exp(0.2 * (at[:, 1] - 240) / 240))
    assert line.startswith("objects look between 1") and "smaller and" in line


def test_few_doubtful_or_predicted_ones_say_nothing():
    assert line_of(lambda at: np.full(len(at), 1.2), places=PLACES[:9]) is None
    assert line_of(lambda at: np.full(len(at), 1.2), score=0.6) is None
    sizes, one = PlaneSizes(), Detection("robot", 0, 0.9, ImagePose(1.0, 2.0, 0.0, 400.0), (), plane_scale=1.2)
    sizes.add([replace(one, predicted=True)] * 20 + [replace(one, plane_scale=None)] * 20)
    assert sizes.line() is None


def test_only_the_latest_count():
    sizes, one = PlaneSizes(latest=20), Detection("robot", 0, 0.9, ImagePose(1.0, 2.0, 0.0, 400.0), (), plane_scale=1.3)
    sizes.add([one] * 40)
    assert sizes.line() is not None
    sizes.add([replace(one, plane_scale=1.0)] * 20)
    assert sizes.line() is None
