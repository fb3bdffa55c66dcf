"""Margins: what they promise of new examples, whatever the distribution."""

import numpy as np
import pytest

from artrec_ros.core.constraints.intervals import Interval
from artrec_ros.core.learning.conformal import conformal_margin, examples_wanted, left_out_scores, unwrapped, widened


def dependent(rng, count):
    common = rng.normal(size=(count, 1))
    return np.hstack([common, common + 0.1 * rng.normal(size=(count, 1)), rng.normal(size=(count, 2))])


DISTRIBUTIONS = {
    "even": lambda rng, n: rng.uniform(-1, 1, (n, 3)),
    "normal": lambda rng, n: rng.normal(size=(n, 4)),
    "heavy tails": lambda rng, n: rng.standard_t(3, size=(n, 2)),
    "dependent": dependent,
    "two modes": lambda rng, n: rng.choice([-1.0, 1.0], (n, 1)) + 0.1 * rng.normal(size=(n, 1)),
}


@pytest.mark.parametrize("name", DISTRIBUTIONS)
@pytest.mark.parametrize(("count", "coverage"), [(25, 0.9), (60, 0.95)])
def test_a_widened_box_holds_the_promised_share_of_new_examples(name, count, coverage):
    rng = np.random.default_rng(5)
    least, inside = None, []
    for _ in range(150):
        values, new = DISTRIBUTIONS[name](rng, count), DISTRIBUTIONS[name](rng, 100)
        least = np.full(values.shape[1], 1e-6)
        margin = conformal_margin(left_out_scores(values, least), coverage, values.shape[1])
        boxes = [widened(Interval.around(v), margin, 1e-6) for v in values.T]
        inside.append(np.mean([all(b.excess(x) == 0 for b, x in zip(boxes, row, strict=True)) for row in new]))
    assert coverage - 0.03 < np.mean(inside) < coverage + 0.06


def test_scores_are_what_each_example_exceeds_the_box_of_the_others_by():
    scores = left_out_scores(np.array([[0.0], [1.0], [4.0], [2.0]]), np.array([0.1]))
    np.testing.assert_allclose(scores, [1 / 3, 0, 1.0, 0])


def test_dimensions_that_an_example_lacks_do_not_count():
    values = np.array([[0.0, np.nan], [1.0, 5.0], [2.0, 5.0], [3.0, 5.5]])
    np.testing.assert_allclose(left_out_scores(values, np.array([0.1, 0.1])), [0.5, 0, 0, 5.0])
    lone = np.array([[0.0, np.nan], [1.0, 9.0], [2.0, np.nan]])
    assert left_out_scores(lone, np.array([0.1, 0.1]))[1] == 0


def test_too_few_examples_get_a_margin_at_least_as_wide_as_any_score():
    scores = np.array([0.0, 0.1, 1.4, 0.2])
    assert conformal_margin(scores, 0.95, 2) >= 1.4
    assert conformal_margin(scores, 0.0, 2) == 0.0
    assert examples_wanted(0.95) == 19 and examples_wanted(0.9) == 9


def test_angles_are_seen_from_the_middle_and_widened_to_a_full_turn_at_most():
    interval = Interval.around_angles([3.0, -3.0])
    half = interval.width / 2
    np.testing.assert_allclose(np.sort(unwrapped(np.array([3.0, -3.0]), interval)), [-half, half])
    assert widened(interval, 1e6, 0.1).width == pytest.approx(2 * np.pi)
