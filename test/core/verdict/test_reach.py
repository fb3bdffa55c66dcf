"""Objects nearer or farther than is looked for."""

import math

import pytest
from settings import DEFAULTS, settings
from solids import camera_of

from artrec_ros.core.geometry.range_limits import range_limits
from artrec_ros.core.verdict.reach import Reach


def test_by_default_everything_is_in_reach():
    assert all(Reach.of(DEFAULTS).reason(*numbers) is None for numbers in ((1e-9, 1e9), (1e9, 1e-9), (math.nan,) * 2))


@pytest.mark.parametrize("limits", [{"min_range_m": 1.0}, {"max_range_m": 2.0}, {"min_scale": 150}, {"max_scale": 300}])
def test_a_reason_is_given_beyond_the_limits_that_a_search_has(limits):
    camera, config = camera_of(), settings(**limits)
    near_m, far_m = range_limits(config, camera)
    for depth_m in (0.3, 0.9, 0.99, 1.01, 1.9, 2.1, 2.5, 9.0):
        reason = Reach.of(config).reason(depth_m, camera.focal_px / depth_m)
        assert (reason is None) == (near_m <= depth_m <= far_m)


def test_a_reason_names_the_limit_and_what_was_found():
    reach = Reach(min_range_m=0.5, max_range_m=2.5, min_scale=100.0, max_scale=800.0)
    assert reach.reason(2.9, 200.0) == "its required component is 2.9 m away, beyond max_range_m 2.5"
    assert reach.reason(0.4, 200.0) == "its required component is 0.4 m away, nearer than min_range_m 0.5"
    assert reach.reason(2.0, 90.0) == "90 px/m, below min_scale 100"
    assert reach.reason(2.0, 900.0) == "900 px/m, above max_scale 800"
    assert reach.reason(2.0, 200.0) is None
