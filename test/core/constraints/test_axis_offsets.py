"""Offsets between annotated and fitted axes: known ones come back, none is made up."""

import numpy as np
import pytest
from scene import capsule, rectangle

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.constraints.axis_offsets import AxisOffset, learn_axis_offset
from artrec_ros.core.model.found import Instance

LINK = capsule("link", 0.03, 0.22)
KEY = ("arm", "link")


def annotated(theta, shift_m=(0.0, 0.0), turn=0.0):
    along = 0.22 * np.stack([np.cos(theta), np.sin(theta)]) + np.array(shift_m)[:, None]
    return np.arctan2(along[1], along[0]) + turn


def angles(count=17, seed=0):
    return np.random.default_rng(seed).uniform(-np.pi, np.pi, count)


@pytest.mark.parametrize(("shift", "turn"), [((0.0005, -0.0045), 0.0), ((0.0, 0.0), 0.02), ((0.004, 0.002), -0.03)])
def test_a_known_offset_comes_back_and_corrects_new_directions(shift, turn):
    theta, rng = angles(40), np.random.default_rng(1)
    given = annotated(theta, shift, turn) + rng.normal(0, 0.001, 40)
    given[:3] += 0.2  # blunders
    found = learn_axis_offset(KEY, LINK, theta, given)
    np.testing.assert_allclose(found.shift_m, shift, atol=4e-4)
    assert found.turn_rad == pytest.approx(turn, abs=1.5e-3)
    assert found.after_deg < 0.15 < found.before_deg
    for new in angles(20, 9):
        instance = Instance("arm", "link", 1.0, 100.0, 50.0, float(new), 400.0)
        corrected = found.corrected(instance, LINK)
        error = np.angle(np.exp(1j * (corrected.theta - annotated(np.array([new]), shift, turn)[0])))
        assert abs(error) < 0.003
        assert (corrected.x, corrected.y, corrected.scale) == (100.0, 50.0, 400.0)


def test_noise_and_few_examples_teach_no_offset():
    for seed in range(40):
        theta = angles(17, seed)
        noisy = theta + np.random.default_rng(100 + seed).normal(0, 0.004, 17)
        assert learn_axis_offset(KEY, LINK, theta, noisy) is None
    assert learn_axis_offset(KEY, LINK, angles(6), annotated(angles(6), (0.005, 0.0))) is None


def test_directions_may_wrap_around():
    theta = np.full(20, np.pi - 0.01) + np.random.default_rng(0).normal(0, 0.002, 20)
    found = learn_axis_offset(KEY, rectangle("bar", 0.2, 0.05), theta, np.angle(np.exp(1j * (theta + 0.05))))
    assert found.shift_m == (0.0, 0.0) or found.turn_rad == 0.0
    assert found.after_deg < 0.2


@pytest.mark.parametrize("seed", range(20))
def test_directions_that_lie_near_each_other_teach_no_shift_of_many_lengths(seed):
    """There a shift and a turn that goes against it look alike, and elsewhere they are nonsense."""
    rng = np.random.default_rng(seed)
    theta = 0.6 + rng.normal(0, 0.06, 9)
    # an outline that is fitted askew the more it is turned: no shift, and no turn
    found = learn_axis_offset(KEY, LINK, theta, theta + 0.09 + 0.8 * (theta - 0.6) + rng.normal(0, 0.002, 9))
    assert found is None or np.hypot(*found.shift_m) <= 0.5 * LINK.axis_length


def test_plain_values_and_mistakes():
    axis = AxisOffset(KEY, (0.001, -0.002), 0.01, 20, 0.8, 0.1)
    assert AxisOffset.from_dict(axis.to_dict(), "axes[0]") == axis
    for change in ({"marker": "link"}, {"shift_m": [1.0]}, {"turn_rad": float("nan")}, {"examples": None}):
        with pytest.raises(ConfigError, match=r"axes\[0\]"):
            AxisOffset.from_dict({**axis.to_dict(), **change}, "axes[0]")
