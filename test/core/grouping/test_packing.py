import itertools

import numpy as np
import pytest

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.grouping import packing
from artrec_ros.core.grouping.packing import connected_parts, pack

pytestmark = pytest.mark.uncompiled


def random_problem(rng, size):
    conflict = rng.random((size, size)) < 0.35
    conflict |= conflict.T
    np.fill_diagonal(conflict, True)
    return rng.uniform(0.1, 5, size), conflict


def best_by_trying_all(weight, conflict):
    best = 0.0
    for n in range(len(weight) + 1):
        for chosen in itertools.combinations(range(len(weight)), n):
            if not any(conflict[a, b] for a, b in itertools.combinations(chosen, 2)):
                best = max(best, weight[list(chosen)].sum())
    return best


@pytest.mark.parametrize("seed", range(15))
def test_the_best_choice_is_found(seed):
    weight, conflict = random_problem(np.random.default_rng(seed), 11)
    chosen, exact, out_of_nodes = pack(weight, conflict, 100000, Deadline())
    assert exact and not out_of_nodes
    assert not any(conflict[a, b] for a, b in itertools.combinations(chosen, 2))
    assert weight[chosen].sum() == pytest.approx(best_by_trying_all(weight, conflict))


def test_greedy_would_be_wrong():
    # the heaviest conflicts with two that together are heavier
    conflict = np.array([[1, 1, 1], [1, 1, 0], [1, 0, 1]], bool)
    assert pack(np.array([3.0, 2.0, 2.0]), conflict, 100, Deadline()).chosen == [1, 2]


@pytest.mark.parametrize(
    "by_nodes, cut",
    [(True, {"node_limit": 1, "deadline": Deadline()}), (False, {"node_limit": 10**6, "deadline": Deadline(0)})],
)
def test_cut_short_it_is_no_worse_than_greedy_and_says_by_what(by_nodes, cut):
    weight, conflict = random_problem(np.random.default_rng(0), 120)
    chosen, exact, out_of_nodes = pack(weight, conflict, **cut)
    assert not exact and out_of_nodes == by_nodes
    assert chosen and not any(conflict[a, b] for a, b in itertools.combinations(chosen, 2))
    assert weight[chosen].sum() >= weight.max()


def test_connected_parts():
    adjacency = np.eye(5, dtype=bool)
    adjacency[0, 3] = adjacency[3, 0] = adjacency[3, 4] = adjacency[4, 3] = True
    assert sorted(sorted(p) for p in connected_parts(adjacency)) == [[0, 3, 4], [1], [2]]
    assert connected_parts(np.zeros((0, 0), bool)) == []


def test_nothing_to_choose_from():
    assert pack(np.zeros(0), np.zeros((0, 0), bool), 10, Deadline()) == ([], True, False)


def test_of_groups_that_rule_out_the_same_others_the_heaviest_is_left():
    weight, conflict = random_problem(np.random.default_rng(1), 9)
    like = np.concatenate([np.arange(9), np.arange(9)])  # each group twice, the second one lighter
    weights, conflicts = np.concatenate([weight, 0.9 * weight]), conflict[np.ix_(like, like)]
    assert pack(weights, conflicts, 10**5, Deadline()) == pack(weight, conflict, 10**5, Deadline())
    apart = np.zeros((3, 3), bool)
    assert pack(np.ones(3), apart, 100, Deadline()) == ([0, 1, 2], True, False)


def test_of_many_groups_few_nodes_are_gone_through_between_looks_at_the_clock(monkeypatch):
    between, search = [], packing.compiled.search

    def noted(weight, conflict, state, most_nodes):
        between.append(most_nodes)
        return search(weight, conflict, state, most_nodes)

    monkeypatch.setattr(packing.compiled, "search", noted)
    monkeypatch.setattr(packing, "_PAIRS_BETWEEN_LOOKS", 2000)
    rng = np.random.default_rng(1)
    conflict = rng.uniform(size=(30, 30)) < 0.3
    conflict |= conflict.T | np.eye(30, dtype=bool)
    pack(rng.uniform(1, 2, 30), conflict, 500, Deadline())
    assert len(between) > 1 and max(between) <= 2
