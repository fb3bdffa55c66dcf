import numpy as np
import pytest

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.grouping.margins import runner_up_margins


def conflicts(count, *pairs):
    table = np.eye(count, dtype=bool)
    for a, b in pairs:
        table[a, b] = table[b, a] = True
    return table


def test_what_nothing_rivals_is_clear_and_a_rival_takes_its_share():
    weight = np.array([10.0, 4.0, 6.0])
    margins = runner_up_margins(weight, conflicts(3, (0, 2)), [0, 1], ["a", "b", "c"], 1000, Deadline())
    assert margins == pytest.approx([0.4, 1.0])


def test_another_reading_of_the_same_choice_is_no_rival():
    weight = np.array([10.0, 10.0, 7.0])
    table = conflicts(3, (0, 1), (0, 2), (1, 2))
    assert runner_up_margins(weight, table, [0], ["a", "a", "b"], 1000, Deadline()) == pytest.approx([0.3])
    assert runner_up_margins(weight, table, [0], ["a", "b", "c"], 1000, Deadline()) == pytest.approx([0.0])


def test_two_lighter_ones_together_may_be_the_runner_up():
    weight = np.array([10.0, 5.0, 4.0])
    assert runner_up_margins(weight, conflicts(3, (0, 1), (0, 2)), [0], "abc", 1000, Deadline()) == pytest.approx([0.1])


def test_what_is_not_proven_is_not_told():
    rng = np.random.default_rng(0)
    table = rng.random((30, 30)) < 0.2
    table = table | table.T | np.eye(30, dtype=bool)
    assert runner_up_margins(rng.random(30) + 1, table, [0], list(range(30)), 2, Deadline()) == [None]
