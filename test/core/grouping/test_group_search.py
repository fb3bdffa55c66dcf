"""The heaviest groups of each seed, against every choice there is."""

import itertools

import numpy as np
import pytest
from cranes import CONFIG

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.grouping import group_kernels as group_search
from artrec_ros.core.grouping import group_search as grouping
from artrec_ros.core.grouping.group_search import GroupSearch

pytestmark = pytest.mark.uncompiled


def random_pool(rng, n, components, instances):
    """Candidates of random weights and pairs; the first is the only one of component 0."""
    component = np.concatenate([[0], rng.integers(1, components, n - 1)])
    forbidden = rng.random((n, n)) < 0.2
    forbidden |= forbidden.T | (component[:, None] == component)
    checked, violation = rng.random((n, n)) < 0.8, np.maximum(rng.normal(-0.2, 0.5, (n, n)), 0)
    checked, violation = np.triu(checked) | np.triu(checked).T, np.triu(violation) + np.triu(violation, 1).T
    checked &= ~forbidden
    weight, share, score = rng.uniform(10, 90, n), rng.uniform(0.5, 1, n), rng.uniform(0.5, 1, n)
    match = np.concatenate([[0], rng.integers(1, instances, n - 1)])
    return group_search.Pool(
        component, match, weight, share, score, np.full(n, 2.0), forbidden, checked, np.where(checked, violation, 0.0)
    )


def all_groups(pool, rules, banned):
    """(weight, members, score, satisfied, checked) of every choice that is an object."""
    fits = [i for i in range(1, len(pool.weight)) if not (
        pool.forbidden[0, i] or pool.violation[0, i] > 0 or banned[pool.match[i]]
    )]  # fmt: skip
    count = len(rules.absent_m)
    for choice in itertools.product(*([None, *(i for i in fits if pool.component[i] == c)] for c in range(1, count))):
        members = [0, *(i for i in choice if i is not None)]
        pairs = list(itertools.combinations(members, 2))
        if any(pool.forbidden[a, b] for a, b in pairs):
            continue
        good = {(a, b): pool.checked[a, b] and pool.violation[a, b] <= 0 for a, b in pairs}
        checked, satisfied = sum(pool.checked[a, b] for a, b in pairs), sum(good.values())
        tied = all(any(good[p] for p in pairs if m in p) for m in members) if pairs else True
        least = rules.min_group_match if satisfied else rules.min_alone_match
        if not tied or len(members) < min(rules.least_components, count) or np.mean(pool.share[members]) < least:
            continue
        if satisfied < rules.min_satisfied * checked:
            continue
        value = pool.weight[members].sum()
        value -= sum(rules.absent_m[c] * pool.scale[0] for c in set(range(count)) - set(pool.component[members]))
        for a, b in pairs:
            if pool.violation[a, b] > 0:
                value -= min(pool.weight[a], pool.weight[b])
        held = satisfied / checked if checked else 1.0
        score = np.mean(pool.score[members]) * held * (0.5 + 0.5 * len(members) / count)
        yield max(value, 0.05 * pool.weight[members].sum()), sorted(members), score, satisfied, checked


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("least_components, satisfied, nodes", [(2, 0.8, 10**6), (1, 0.4, 10**6), (2, 0.8, 3)])
def test_groups_are_the_heaviest_of_all(seed, least_components, satisfied, nodes):
    rng = np.random.default_rng(seed)
    pool = random_pool(rng, 12, 4, 8)
    rules = group_search.Rules(rng.uniform(0, 10, 4), 0, 12, 4, nodes, least_components, satisfied, 0.6, 0.7, 0.05)
    banned = rng.random(8) < 0.15
    expected = sorted(all_groups(pool, rules, banned), key=lambda g: -g[0])[:4]
    held, members, weight, score, good, checked, exact = group_search.best_groups(pool, 0, rules, banned)
    assert exact == (nodes > 3)
    got = [sorted(members[i, : held[i]].tolist()) for i in range(len(held))]
    assert all(row[0] == 0 for row in members[: len(held)])
    if not exact:
        assert len(got) <= len(expected)
        return
    np.testing.assert_allclose(weight, [g[0] for g in expected], atol=1e-6)
    for i, (_, mine, *judged) in enumerate(expected):
        assert got[i] == mine
        np.testing.assert_allclose([score[i], good[i], checked[i]], judged)


def test_groups_of_several_seeds_are_those_of_each(matches, candidates, monkeypatch):
    whole = GroupSearch(candidates, matches, CONFIG, Deadline())
    together = whole.best_groups_of_all()
    monkeypatch.setattr(grouping, "_SEEDS_BETWEEN_LOOKS", 1)
    assert [(g.members, g.weight) for g in whole.best_groups_of_all()] == [(g.members, g.weight) for g in together]
    cases = [(g.members[0], frozenset(g.matches[1:])) for g in together]
    one_by_one = [whole.best_without([case]) for case in cases]
    assert [g.members for g in whole.best_without(cases)] == [g.members for found in one_by_one for g in found]
    for (seed, banned), found in zip(cases, one_by_one, strict=True):
        assert all(g.members[0] == seed and not banned & set(g.matches) for g in found) and len(found) <= 1
    assert sum(map(len, one_by_one)) > 0
    assert together and GroupSearch(candidates, matches, CONFIG, Deadline(0)).best_groups_of_all() == []


def test_groups_that_share_pixels_conflict():
    rng = np.random.default_rng(0)
    counts = rng.integers(1, 4, 9)
    members = np.where(np.arange(3) < counts[:, None], rng.integers(0, 12, (9, 3)), 0)
    shared = rng.random((12, 12)) < 0.1
    shared |= shared.T | np.eye(12, dtype=bool)
    got = group_search.conflicts(members, counts, shared)
    for g, h in itertools.product(range(9), range(9)):
        assert got[g, h] == any(shared[a, b] for a in members[g, : counts[g]] for b in members[h, : counts[h]])
    assert not got.all()
