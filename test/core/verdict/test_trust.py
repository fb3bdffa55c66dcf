"""Scores as probabilities."""

import numpy as np
from toy_groups import BASE_AFT, BASE_FORE, at, found, pair, solved

from artrec_ros.core.verdict.trust import evidence, probability


def best(matches, *pairs, **options):
    return solved(matches, *pairs, **options)[0].accepted[0]


def test_what_matches_better_and_is_more_complete_is_trusted_more():
    whole = best(found((0, at(0), 0.95), (1, at(1), 0.95), (1, at(2), 0.95)), BASE_FORE, BASE_AFT)
    faint = best(found((0, at(0), 0.8), (1, at(1), 0.8), (1, at(2), 0.8)), BASE_FORE, BASE_AFT)
    part = best(found((0, at(0), 0.95), (1, at(1), 0.95)), BASE_FORE, BASE_AFT)
    assert probability(whole) > probability(part) > 0
    assert probability(whole) > probability(faint)
    assert probability(whole) > 0.95


def test_a_tight_constraint_is_more_evidence_than_a_loose_one():
    matches = found((0, at(0), 0.9), (1, at(1), 0.9))
    tight, loose = (best(matches, pair(0, 1, low, high)) for low, high in ((0.98, 1.02), (0.2, 1.2)))
    assert evidence(tight) > evidence(loose) > 0


def test_no_constraint_is_no_evidence():
    group = best(found((0, at(0), 0.9)), min_components=1)
    assert evidence(group) == 0
    assert 0 < probability(group) < 0.9
    assert np.isfinite(probability(group._replace(satisfied=0)))
