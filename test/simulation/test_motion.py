import itertools

import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.motion import MotionConfig, moving_scenes, simulate_motion
from artrec_ros.simulation.scene import sample_scene
from artrec_ros.simulation.simulator import PERIOD_NS

MOTION = MotionConfig(speed=0.4, reach=0.2, turn=0.7, swing_hz=0.5)


@pytest.fixture
def scenes(target, camera):
    rng = np.random.default_rng(3)
    start = sample_scene([target], camera, SceneConfig(objects=(2, 2)), rng)
    return start, list(itertools.islice(moving_scenes(start, MOTION, rng), 300))


def test_it_begins_where_the_scene_put_them(scenes):
    start, moving = scenes
    for before, after in zip(start.objects, moving[0].objects, strict=True):
        np.testing.assert_allclose(after.T_camera_object.position, before.T_camera_object.position, atol=1e-12)
        np.testing.assert_allclose(after.T_camera_object.rotation, before.T_camera_object.rotation, atol=1e-12)
        assert after.joints == pytest.approx(before.joints)


def test_speed_reach_turn_and_joints_stay_within_what_was_asked_for(scenes):
    start, moving = scenes
    for n, placed in enumerate(start.objects):
        to_start = placed.T_camera_object.inverse()
        seen = [to_start @ s.objects[n].T_camera_object for s in moving]
        place = np.array([T.position for T in seen])
        assert np.abs(place[:, :2]).max() <= MOTION.reach + 1e-9 and np.abs(place[:, 2]).max() < 1e-9  # on its floor
        speed = np.abs(np.diff(place, axis=0)) / (PERIOD_NS * 1e-9)
        assert 0.2 < speed.max() <= MOTION.speed + 1e-9
        heading = np.array([np.arctan2(T.rotation[1, 0], T.rotation[0, 0]) for T in seen])
        assert 0.1 < np.abs(heading).max() <= MOTION.turn + 1e-9
        arm = np.array([s.objects[n].joints["arm"] for s in moving])
        assert arm.min() >= -0.5 - 1e-9 and arm.max() <= 1.0 + 1e-9 and np.ptp(arm) == pytest.approx(1.5, abs=0.01)


def test_two_objects_move_each_in_its_own_way(scenes):
    start, moving = scenes
    a, b = ([s.objects[n].T_camera_object.position for s in moving] for n in (0, 1))
    assert np.ptp(np.array(a) - np.array(b), axis=0).max() > 0.05


def test_frames_are_those_of_the_scenes_and_repeatable(target, camera):
    def run():
        return list(simulate_motion([target], camera, SceneConfig(), MOTION, SensorConfig(), 5, 3))

    first, again = run(), run()
    assert [f.stamp_ns for f in first] == [f.stamp_ns for f in again]
    assert all(np.array_equal(f.labels, g.labels) for f, g in zip(first, again, strict=True))
    moved = [f.truths[0].placed.T_camera_object.position for f in first]
    assert 0 < np.linalg.norm(moved[1] - moved[0]) < 0.6 * PERIOD_NS * 1e-9


def test_bad_values_are_refused():
    with pytest.raises(ConfigError, match="motion.reach"):
        MotionConfig(reach=0)
