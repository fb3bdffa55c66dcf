"""What a plane is to a camera that objects face: depths by its scale, whatever took the image."""

from __future__ import annotations

import fields
import numpy as np
import pytest

from artrec_ros.core.base.config import PlaneConfig, SceneConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.scene import Scene

FACED = Camera.facing(fields.SIZE)


def lying(slant=0.0, tolerance=0.1):
    plane = fields.plane(fields.camera(), slant, scale_tolerance=tolerance)
    scene = Scene.of(SceneConfig(plane=plane)).faced(FACED)
    assert scene.lying is not None and scene.plane is not None
    return scene.lying, scene.plane


def at(pixels, scale):
    """(n, 3) places that are seen at pixels (n, 2) at so many pixels per metre (n,)."""
    rays = np.column_stack([(pixels - FACED.matrix[:2, 2]) / FACED.focal_px, np.ones(len(pixels))])
    return rays * (FACED.focal_px / scale)[:, None]


@pytest.mark.parametrize("slant", [0.0, 8.0])  # seen at more of a slant it is looked at from above
def test_what_lies_on_it_is_of_its_scale(slant):
    known, plane = lying(slant)
    pixels = np.random.default_rng(1).uniform((0, 0), np.array(fields.SIZE) - 1, (50, 2))
    heights = at(pixels, plane.scales(pixels)) @ known.up - known.standing_at_m
    assert np.abs(heights / known.standing_at_m).max() < 0.01
    assert known.odds_against(at(pixels, plane.scales(pixels))).max() < 0.05


@pytest.mark.parametrize("tolerance", [0.05, 0.4])
def test_its_scale_is_as_sure_as_that_of_what_is_anywhere_within_the_tolerance(tolerance):
    known, plane = lying(tolerance=tolerance)
    pixels = np.tile((np.array(fields.SIZE) - 1) / 2, (20_000, 1))
    logs = np.random.default_rng(2).uniform(-1, 1, len(pixels)) * np.log1p(tolerance)
    off = at(pixels, plane.scales(pixels) * np.exp(logs)) @ known.up - known.standing_at_m
    assert np.std(off) == pytest.approx(known.height_sigma_m, rel=0.1)


def test_an_objects_place_may_lie_behind_its_markers():
    known, plane = lying()
    (place,) = at(np.array([[100.0, 50.0]]), plane.scales(np.array([[100.0, 50.0]])))
    behind = place + (0, 0, 0.05)
    assert known.nearer(0.05).odds_against(behind[None])[0] < 1e-3 < known.odds_against(behind[None])[0]


def test_nothing_is_known_where_no_plane_is_seen():
    assert Scene().faced(FACED).lying is None
    below = np.array([(100.0, 700.0), (500.0, 700.0), (1100 / 3, 600.0), (700 / 3, 600.0)])  # its horizon: y = 550
    plane = PlaneConfig(tuple(below.ravel()), (0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0))
    scene = Scene.of(SceneConfig(plane=plane)).faced(FACED)
    assert scene.plane is not None and scene.lying is None
    assert scene.odds_against(np.eye(3)[None], np.array([[0.0, 0.0, 1.0]])) == [0.0]
