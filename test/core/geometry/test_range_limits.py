"""Limits of distance and of scale are one thing where the camera is known."""

import math

import numpy as np
import pytest
from settings import settings

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.range_limits import range_limits, scale_limits

CAMERA = Camera(np.diag([300.0, 300.0, 1.0]), np.zeros(0), (320, 240))


@pytest.mark.parametrize(
    ("values", "near_m", "far_m"),
    [
        ({}, 0.0, math.inf),
        ({"min_range_m": 0.5, "max_range_m": 2.0}, 0.5, 2.0),
        ({"min_scale": 100.0, "max_scale": 600.0}, 0.5, 3.0),
        ({"min_range_m": 0.2, "max_scale": 600.0, "max_range_m": 2.0, "min_scale": 100.0}, 0.5, 2.0),
        ({"min_range_m": 0.7, "max_scale": 600.0}, 0.7, math.inf),
        ({"min_range_m": 1.0, "max_range_m": 1.0}, 1.0, 1.0),
    ],
)
def test_the_narrower_of_both_holds(values, near_m, far_m):
    assert range_limits(settings(**values), CAMERA) == pytest.approx((near_m, far_m))


@pytest.mark.parametrize("values", [{}, {"min_range_m": 0.5}, {"max_range_m": 2.0, "max_scale": 900.0}])
def test_scales_are_the_focal_length_over_the_distances(values):
    near_m, far_m = range_limits(settings(**values), CAMERA)
    least, greatest = scale_limits(settings(**values), CAMERA)
    assert least == pytest.approx(300.0 / far_m)
    assert greatest == pytest.approx(300.0 / near_m if near_m else math.inf)


def test_without_a_camera_distances_say_nothing_of_scales():
    assert scale_limits(settings(min_range_m=1.0, max_range_m=2.0), None) == (0.0, math.inf)
    assert scale_limits(settings(min_scale=3.0, max_scale=5.0, min_range_m=1.0), None) == (3.0, 5.0)


def test_limits_that_leave_nothing_are_named_with_what_they_come_to():
    with pytest.raises(ConfigError, match=r"max_range_m 0.5.*max_scale 400.*300 px.*0.75 m or more, and 0.5 m or less"):
        range_limits(settings(max_range_m=0.5, max_scale=400.0), CAMERA)
