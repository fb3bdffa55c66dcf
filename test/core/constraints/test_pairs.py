"""The background model of a pair's constraint."""

import numpy as np
import pytest

from artrec_ros.core.constraints.intervals import Interval
from artrec_ros.core.constraints.pairs import PairConstraint


def pair(**allowed):
    return PairConstraint(("a", "m"), ("b", "m"), 20, allowed, allowed)


@pytest.mark.parametrize(
    "allowed",
    [
        {"distance_m": (0.2, 0.5), "bearing_rad": (0.5, 2.5), "turn_rad": (-1.0, 1.5), "scale_ratio": (0.8, 1.3)},
        {"distance_m": (0.0, 0.4), "scale_ratio": (0.9, 1.1)},
        {"offset_x_m": (-0.3, 0.2), "offset_y_m": (-0.2, 0.3), "turn_rad": (2.0, 4.0)},
    ],
)
def test_chance_is_the_share_of_unrelated_markers_that_pass(allowed):
    period = 2 * np.pi
    box = {d: Interval(*ends, period if d.endswith("_rad") else 0.0) for d, ends in allowed.items()}
    rng, n, reach = np.random.default_rng(0), 200_000, 0.8
    rho, bearing = reach * np.sqrt(rng.random(n)), rng.uniform(-np.pi, np.pi, n)
    values = {
        "distance_m": rho,
        "bearing_rad": bearing,
        "offset_x_m": rho * np.cos(bearing),
        "offset_y_m": rho * np.sin(bearing),
        "turn_rad": rng.uniform(-np.pi, np.pi, n),
        "scale_ratio": np.exp(rng.uniform(-np.log(2), np.log(2), n)),
    }
    passed = np.mean(np.all([i.excess(values[d]) == 0 for d, i in box.items()], axis=0))
    assert pair(**box).chance(reach) == pytest.approx(passed, rel=0.08)


def test_reach_is_the_farthest_that_is_allowed():
    assert pair(distance_m=Interval(0.1, 0.7)).reach_m == 0.7
    assert pair(offset_x_m=Interval(-0.3, 0.1), offset_y_m=Interval(0.0, 0.4)).reach_m == pytest.approx(0.5)
