"""How near and how far objects are looked for."""

import numpy as np
import pytest
from settings import DEFAULTS, settings

from artrec_ros.core.pose.reach import Reach


def test_by_default_everything_is_in_reach():
    reach = Reach.of(DEFAULTS)
    assert not reach.is_limited
    assert reach.near(np.array([[0, 0, 1e-9], [0, 0, -1.0], [1e6, 0, 1e6]]), 300.0, 0.0).all()
    assert reach.reason(1e-9, 1e9) is None and reach.reason(1e9, 1e-9) is None


@pytest.mark.parametrize("limits", [{"min_range_m": 1.0}, {"max_range_m": 2.0}, {"min_scale": 150}, {"max_scale": 300}])
def test_places_are_left_out_where_a_reason_would_be_given_however_they_are_moved(limits):
    """A place off by a share of no more than the slack stays."""
    reach, rng, focal, slack = Reach.of(settings(**limits)), np.random.default_rng(0), 300.0, 0.25
    assert reach.is_limited
    t = rng.uniform((-0.5, -0.5, 0.3), (0.5, 0.5, 4.0), (500, 3))

    def fits(places):
        ranges, scales = np.linalg.norm(places, axis=1).tolist(), (focal / places[:, 2]).tolist()
        return np.array([reach.reason(r, s) is None for r, s in zip(ranges, scales, strict=True)])

    assert 20 < fits(t).sum() < 480
    np.testing.assert_array_equal(reach.near(t, focal, 0.0), fits(t))
    np.testing.assert_array_equal(reach.near(t, focal, slack), fits(t) | fits(t * (1 + slack)) | fits(t / (1 + slack)))


def test_a_reason_names_the_limit_and_what_was_found():
    reach = Reach(min_range_m=0.5, max_range_m=2.5, min_scale=100.0, max_scale=800.0)
    assert reach.reason(2.9, 200.0) == "2.9 m away, beyond max_range_m 2.5"
    assert reach.reason(0.4, 200.0) == "0.4 m away, nearer than min_range_m 0.5"
    assert reach.reason(2.0, 90.0) == "90 px/m, below min_scale 100"
    assert reach.reason(2.0, 900.0) == "900 px/m, above max_scale 800"
    assert reach.reason(2.0, 200.0) is None
