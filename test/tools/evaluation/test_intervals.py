"""Intervals against published values, by coverage, and where there is nothing to measure."""

import numpy as np
import pytest

from artrec_ros.tools.evaluation.intervals import (
    Estimate,
    bootstrapped_rows,
    exact_sign_test,
    f1,
    mean,
    median,
    per_frame,
    quantile,
    rate,
    rate_difference,
)


def test_wilsons_interval_of_a_rate():
    """Newcombe 1998, table I, method 3: 81 of 263, and none of 20."""
    e = rate(81, 263)
    assert (e.value, e.n) == (pytest.approx(0.30798, abs=1e-5), 263)
    assert (e.low, e.high) == (pytest.approx(0.2553, abs=1e-4), pytest.approx(0.3662, abs=1e-4))
    none = rate(0, 20)
    assert (none.low, none.high) == (pytest.approx(0, abs=1e-9), pytest.approx(0.1611, abs=1e-4))


def test_the_exact_interval_of_a_poisson_count():
    """Garwood's table: 0 events: 0 to 3.69; 10 events: 4.80 to 18.39."""
    assert per_frame(0, 1).high == pytest.approx(3.689, abs=1e-3) and per_frame(0, 1).low == 0
    e = per_frame(10, 100)
    assert (e.value, e.low, e.high) == (0.1, pytest.approx(0.04795, abs=1e-5), pytest.approx(0.18390, abs=1e-5))


def test_a_difference_of_rates_is_not_sure_where_nothing_changed():
    e = rate_difference(0, 0, 16)
    assert (e.value, e.n) == (0, 16) and e.high == -e.low == pytest.approx(0.109, abs=1e-3)
    assert rate_difference(0, 0, 160).high < 0.02 and rate_difference(3, 0, 3).high == 1
    assert rate_difference(0, 0, 0) == Estimate()


def test_a_difference_of_rates_is_covered_as_often_as_it_says():
    rng, covered = np.random.default_rng(7), 0
    for _ in range(1000):  # of 40 cases each is found by the second alone with .15, by the first alone with .05
        gained, lost, _ = rng.multinomial(40, [0.15, 0.05, 0.8])
        e = rate_difference(gained, lost, 40)
        covered += e.low <= 0.1 <= e.high
    assert 930 <= covered <= 980


def test_f1_is_the_harmonic_mean_and_its_interval_that_of_the_ratio_it_grows_with():
    e = f1(8, 2, 4)
    assert e.value == pytest.approx(2 / (1 / (8 / 10) + 1 / (8 / 12)))
    assert rate(8, 14).low < e.low < e.value < e.high < 1


@pytest.mark.parametrize("seed", [0, 1])
def test_bootstrapped_medians_cover_the_true_one_as_often_as_they_say(seed):
    rng = np.random.default_rng(seed)
    covered = 0
    for _ in range(60):
        e = median(rng.exponential(size=40))
        covered += e.low <= np.log(2) <= e.high
    assert 50 <= covered <= 60  # 57 of 60 are expected


def test_the_same_data_gives_the_same_interval():
    values = np.random.default_rng(3).normal(size=50)
    assert median(values) == median(values) and quantile(values, 0.95) == quantile(values, 0.95)
    assert mean(values).value == pytest.approx(values.mean())


def test_rows_stay_together():
    """Of rows (x, -x) the sum is zero in every resample; if columns were drawn apart it would not be."""
    x = np.random.default_rng(5).normal(size=30)
    e = bootstrapped_rows(np.stack([x, -x], axis=1), lambda rows: float(rows.sum()))
    assert e.low == pytest.approx(0) and e.high == pytest.approx(0)


def test_nothing_to_measure():
    assert rate(0, 0) == per_frame(0, 0) == f1(0, 0, 0) == median([]) == Estimate()
    assert bootstrapped_rows(np.zeros((0, 2)), len) == Estimate()
    assert median([3.0]) == Estimate(3.0, None, None, 1)


def test_mcnemars_exact_test():
    """b = 5, c = 15: twice the binomial tail, 0.0414."""
    assert exact_sign_test(5, 15) == pytest.approx(0.0414, abs=1e-4) == exact_sign_test(15, 5)
    assert exact_sign_test(0, 0) == 1
