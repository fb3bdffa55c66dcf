import numpy as np
import pytest

from artrec_ros.core.constraints.intervals import Interval, expected_coverage, margin_for_coverage


def test_angles_are_held_by_the_complement_of_the_largest_gap():
    interval = Interval.around_angles(np.array([3.0, -3.0, 3.1]))
    assert interval.width == pytest.approx(2 * np.pi - 6.0)
    assert interval.excess([3.05, np.pi, -3.05]).max() == pytest.approx(0, abs=1e-12)
    assert interval.excess(2.9) == pytest.approx(0.1)
    assert interval.excess(-2.9) == pytest.approx(0.1)


@pytest.mark.parametrize("turn", np.linspace(-4, 4, 9))
def test_angle_intervals_turn_with_their_examples(turn):
    values = np.array([-0.3, 0.1, 0.5])
    moved = Interval.around_angles(values + turn)
    assert moved.width == pytest.approx(0.8)
    np.testing.assert_allclose(moved.excess(np.array([-0.4, 0.0, 0.7]) + turn), [0.1, 0, 0.2], atol=1e-12)


def test_angles_modulo_a_period():
    interval = Interval.around_angles([0.1, 0.1 + np.pi / 2, 0.2 - np.pi / 2], np.pi / 2)
    assert interval.width == pytest.approx(0.1)
    assert interval.excess(0.15 + np.pi) == pytest.approx(0, abs=1e-12)
    assert interval.excess(0.3) == pytest.approx(0.1)


@pytest.mark.parametrize("examples", [3, 10, 40])
@pytest.mark.parametrize("margin", [0.0, 0.2])
def test_expected_coverage_is_what_even_examples_show(examples, margin):
    rng = np.random.default_rng(examples)
    draws = rng.random((20000, examples + 1))
    low, high = draws[:, :-1].min(axis=1), draws[:, :-1].max(axis=1)
    reach = margin * (high - low)
    new = draws[:, -1]
    inside = np.mean((new >= low - reach) & (new <= high + reach))
    assert inside == pytest.approx(expected_coverage(examples, margin), abs=0.01)


@pytest.mark.parametrize("coverage", [0.5, 0.9, 0.99])
def test_margin_reaches_its_coverage(coverage):
    assert expected_coverage(20, margin_for_coverage(20, coverage)) >= coverage - 1e-9


def test_few_examples_cover_nothing_for_sure():
    assert expected_coverage(1) == 0
    assert margin_for_coverage(1, 0.9) == margin_for_coverage(2, 1.0) == 2.0
