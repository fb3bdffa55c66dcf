"""A floor from where the camera is: heights and leaning of poses, and which do not stand on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.base.config import FloorConfig, SceneConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.floor import Floor
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rpy

OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # to x ahead, y left, z up


def camera_in_room(pitch_deg: float, roll_deg: float, height: float) -> Pose:
    """T_room_camera: looks down by a pitch, then is turned clockwise about its line of sight by a roll."""
    level = rotation_from_rpy(np.radians([roll_deg, pitch_deg, 0.0]))  # about x ahead, and y left
    return Pose(level @ OPTICAL, np.array([0.0, 0.0, height]))


@pytest.mark.parametrize(("pitch", "roll"), [(0, 0), (30, 0), (0, 20), (25, -15), (90, 0)])
def test_heights_and_leaning_are_those_in_the_room(pitch: float, roll: float) -> None:
    rng = np.random.default_rng(2)
    T = camera_in_room(pitch, roll, 1.3)
    room_t, rpy = rng.normal(size=(20, 3)), rng.uniform(-0.8, 0.8, (20, 3))
    room_R = np.array([rotation_from_rpy(r) for r in rpy])
    R, t = T.rotation.T @ room_R, T.inverse().apply(room_t)
    floor = Floor.of(FloorConfig(camera_height_m=1.3, camera_pitch_deg=pitch, camera_roll_deg=roll))
    np.testing.assert_allclose(floor.heights(t), room_t[:, 2], atol=1e-12)
    np.testing.assert_allclose(np.cos(np.radians(floor.tilts_deg(R))), room_R[:, 2, 2], atol=1e-9)


def test_what_does_not_stand_is_told_why() -> None:
    config = FloorConfig(camera_height_m=1.0, object_height_m=0.2, height_tolerance_m=0.1, max_tilt_deg=20.0)
    floor = Floor.of(config)
    upright, leaning = rotation_from_rpy([np.pi / 2, 0, 0]), rotation_from_rpy([np.pi / 2 + np.radians(29.9), 0, 0])
    R = np.array([upright, upright, leaning])
    t = np.array([[0.3, 0.8, 2.0], [0.3, 0.4, 2.0], [0.3, 0.8, 2.0]])  # y is down
    stands, high, leans = floor.reasons(R, t)
    assert stands is None and high is not None and leans is not None
    assert "0.60 m above the floor, not 0.2 m" in high and "leans by 30 deg" in leans
    assert floor.standing(R, t).tolist() == [True, False, False]
    assert floor.may_stand(R, t, slack=1.6).tolist() == [True, False, True]
    strict = Floor.of(replace(config, max_tilt_deg=3.0))  # guesses lean by as much whatever objects may
    assert strict.may_stand(R[2:], t[2:], slack=1.0).all() and not strict.standing(R[2:], t[2:]).any()
    exact = Floor.of(replace(config, height_tolerance_m=0.001))  # and are as far off as their size is
    near, far = (t[:1] * share for share in (0.95, 0.85))
    assert exact.may_stand(R[:1], near, slack=1.0).all() and not exact.may_stand(R[:1], far, slack=1.0).any()
    assert not exact.standing(R[:1], near).any()


def test_what_stands_at_its_height_is_the_likeliest() -> None:
    floor = Floor.of(FloorConfig(camera_height_m=1.0, height_tolerance_m=0.3, max_tilt_deg=20.0))
    upright, leaning = rotation_from_rpy([np.pi / 2, 0, 0]), rotation_from_rpy([np.pi / 2 + np.radians(20), 0, 0])
    t = np.array([[0.3, 1.0, 2.0], [0.1, 0.7, 1.0], [0.3, 1.0, 1.5]])
    against = floor.odds_against(np.array([upright, upright, leaning]), t)
    np.testing.assert_allclose(against, [0.0, 1.5, 2.0], atol=1e-9)  # at the limits: of a range, and of a disc
    assert not Scene().odds_against(upright[None], t[:1]).any()


def test_nothing_is_known_of_a_floor_without_a_height() -> None:
    assert Scene.of(SceneConfig()).floor is None
    assert Scene.of(SceneConfig(floor=FloorConfig(camera_height_m=0.5))).floor is not None
    with pytest.raises(ConfigError, match=r"scene\.floor\.camera_pitch_deg: 100"):
        FloorConfig(camera_pitch_deg=100)


def test_what_may_lie_any_way_round_is_as_likely_upright_as_upside_down() -> None:
    floor = Floor.of(FloorConfig(camera_height_m=1.0, max_tilt_deg=180.0))
    R = rotation_from_rpy([np.pi / 2, 0, 0]), rotation_from_rpy([-np.pi / 2, 0, 0])
    np.testing.assert_allclose(floor.tilts_deg(np.array(R)), [0.0, 180.0], atol=1e-6)
    assert not floor.odds_against(np.array(R), np.array([[0.0, 1.0, 2.0]] * 2)).any()


@pytest.mark.parametrize("pitch", [20, 60, 90])
def test_how_much_farther_the_farthest_place_is_than_the_nearest_is_known_of_all_lines_of_sight(pitch: float) -> None:
    config = FloorConfig(
        camera_height_m=1.5, camera_pitch_deg=pitch, object_height_m=0.3, height_tolerance_m=0.2, max_tilt_deg=20.0
    )
    floor = Floor.of(config)
    ways = np.random.default_rng(3).normal(0, 0.2, (20, 3)) + (0, 0, 1)
    ways = ways[ways @ floor.up < -0.05]
    far = 0.01 * np.exp(np.linspace(0, 9, 40001))
    for way in ways:
        heights = floor.heights(far[:, None] * way)
        stand = far[np.abs(heights - 0.3) <= 0.2]
        assert floor.log_depths == pytest.approx(np.log(stand[-1] / stand[0]), abs=2e-3)
    assert Floor.of(replace(config, object_height_m=1.4)).log_depths == np.inf  # one may stand anywhere on one
