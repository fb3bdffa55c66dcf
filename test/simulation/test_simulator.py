import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import PERIOD_NS, pinhole_camera, simulate

from .conftest import square


def frames(target, camera, count, seed=7, noise=1.0):
    return list(simulate([target], camera, SceneConfig(objects=(1, 2)), SensorConfig().scaled(noise), seed, count))


def test_the_same_seed_gives_the_same_frames_however_many_follow(target, camera):
    few, many = frames(target, camera, 2), frames(target, camera, 4)
    for a, b in zip(few, many, strict=False):
        assert np.array_equal(a.labels, b.labels) and np.array_equal(a.colour, b.colour)
        assert a.stamp_ns == b.stamp_ns


def test_another_seed_gives_other_frames(target, camera):
    assert not np.array_equal(frames(target, camera, 1)[0].labels, frames(target, camera, 1, seed=8)[0].labels)


def test_frames_follow_one_another_in_time(target, camera):
    a, b, c = frames(target, camera, 3)
    assert b.stamp_ns - a.stamp_ns == c.stamp_ns - b.stamp_ns == PERIOD_NS
    assert not np.array_equal(a.labels, b.labels)


def test_ideal_labels_agree_with_the_truth(target, camera):
    """As many pixels of the arm's class as the truth says are visible of it."""
    for frame in frames(target, camera, 6, noise=0.0):
        if frame.scene.distractors:
            continue
        arms = [m.visible_px for t in frame.truths for m in t.markers if m.component == "arm"]
        assert np.sum(frame.labels == 7) == pytest.approx(sum(arms), abs=6 + 0.2 * sum(arms))


def test_a_model_without_places_is_refused(camera):
    loose = ObjectModel("loose", (Component("base", (square(0.1),), required=True),))
    with pytest.raises(ConfigError, match="has no pose"):
        next(simulate([Target("loose", loose, 2)], camera, SceneConfig(), SensorConfig(), 0, 1))


def test_the_view_angle_spans_the_images_width():
    camera = pinhole_camera((200, 100), 90)
    left = np.linalg.inv(camera.matrix) @ (-0.5, 49.5, 1)
    assert left[0] == pytest.approx(-1)
