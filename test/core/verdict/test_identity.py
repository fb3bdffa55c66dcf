"""Which one of several like objects each is: from what tells for each name to names."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from squares import COLOURS, ROBOT, robot

from artrec_ros.core.model.found import SURE, Detection, IdentityFit, ImagePose
from artrec_ros.core.model.identities import identities_of
from artrec_ros.core.verdict.identity import doubted, named, one_of_these, surplus

NAMES = ("a", "b", "c", "d", "e")


def told(evidence, unique=True, least=0.8):
    evidence = np.array(evidence, float)
    return named(evidence, NAMES[: evidence.shape[1]], unique, least)


def names(fits):
    return [fit.name for fit in fits]


def test_each_is_what_it_looks_like_most():
    fits = told([[0, -9, -9], [-9, 0, -9]])
    assert names(fits) == ["a", "b"] and all(fit.unique for fit in fits)
    assert fits[0].probability == pytest.approx(1 / (1 + np.exp(-9)), rel=1e-6)
    assert fits[0].evidence == {"a": 0.0, "b": -9.0, "c": -9.0}
    assert fits[0].runner_up == "c"  # for b is taken


def test_where_names_occur_once_all_are_named_together():
    """The second alone would be an a; but the first is one more clearly."""
    evidence = [[0, -20, -20], [0, -4, -8]]
    assert names(told(evidence)) == ["a", "b"]
    assert names(told(evidence, unique=False)) == ["a", "a"]


def test_a_swap_is_found_and_counts_as_the_rival():
    evidence = [[0, -1, -30], [-1, 0, -30], [-30, -30, 0]]
    fits = told(evidence)
    assert [fit.runner_up for fit in fits[:2]] == ["b", "a"]  # who would be the other's had both been swapped
    assert fits[0].probability == pytest.approx(1 / (1 + np.exp(-2)), rel=1e-6)
    assert names(fits) == ["a", "b", "c"]


def test_of_two_names_alike_none_is_told_but_the_runner_up():
    fits = told([[0, -0.1, -30], [-30, -30, 0]])
    assert names(fits) == [None, "c"]
    assert 0.5 < fits[0].probability < 0.55 and fits[0].runner_up == "b"
    for least, name in ((0.5, "a"), (0.53, None)):
        assert told([[0, -0.1, -30]], least=least)[0].name == name


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.booleans())
def test_a_name_is_as_probable_as_the_best_naming_against_the_best_without_it(seed, count, unique):
    """Against all namings, one by one."""
    evidence = np.random.default_rng(seed).normal(0, 3, (count, 4))
    ways = [w for w in np.ndindex(*[4] * count) if not unique or len(set(w)) == count]
    value = {w: sum(evidence[i, n] for i, n in enumerate(w)) for w in ways}
    best = max(value, key=value.get)
    for i, fit in enumerate(told(evidence, unique, least=0.5)):
        assert fit.name == NAMES[best[i]]
        rival = max((w for w in ways if w[i] != best[i]), key=value.get)
        assert fit.runner_up == NAMES[rival[i]]
        assert fit.probability == pytest.approx(1 / (1 + np.exp(value[rival] - value[best])))


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_the_order_of_objects_does_not_matter(order):
    evidence = np.random.default_rng(5).normal(0, 5, (3, 4))
    fits = told(evidence, least=0.5)
    assert told(evidence[list(order)], least=0.5) == [fits[i] for i in order]


def test_beyond_all_names_the_one_that_tells_least_has_none():
    """Three objects of two names: a false one, small and like neither, takes nobody's name however little it says."""
    fits = told([[-3.0, -23.0], [-0.5, -0.6], [-30.0, -5.0]])
    assert names(fits) == ["a", None, "b"]
    assert (fits[1].probability, fits[1].runner_up) == (0.0, None)


@pytest.mark.parametrize(
    ("evidence", "odds", "none"),
    [
        ([[0, -9], [-9, 0], [-4, -4.1]], [2, 2, 2], 2),  # it looks like nobody
        ([[0, -9], [-9, 0], [-1, -30]], [2, 2, -3], 2),  # it looks like the first, and is hardly there
        ([[0, -9], [-9, 0], [-1, -30]], [-3, 2, 2], 0),  # the first is
        ([[0, -9], [-9, 0], [-9, 0]], [2, -9, 3], 1),
        ([[0, -9], [-9, 0], [-50, -80]], [2, 2, -1], 2),  # how little it says of any name is all the same
        ([[0, -9], [0, -12], [0, 0]], [4, 4, -0.3], 2),  # one of two that look alike was misread: both are there
    ],
)
def test_of_more_objects_than_names_those_go_that_are_least_likely_there(evidence, odds, none):
    gone, instead = surplus(np.array(evidence, float), np.array(odds, float), 0.2)
    assert np.flatnonzero(gone).tolist() == [none]
    assert (
        (instead[~gone, none] < 0).all() and (instead[gone] == -np.inf).all() and (instead[:, ~gone] == -np.inf).all()
    )


def test_of_what_occurs_once_odds_tell_how_probable_another_one_is():
    gone, instead = surplus(np.zeros((3, 1)), np.array([2.0, 3.0, -1.0]), 0.2)
    assert gone.tolist() == [True, False, True]
    assert instead[1].tolist() == pytest.approx([-1.0, -np.inf, -4.0])


def test_who_shows_a_name_excludes_who_shows_the_same_more_than_others():
    gone, instead = surplus(np.array([[0.0, -20.0], [-20.0, 0.0], [-20.0, 0.0]]), np.array([3.0, 3.0, 2.5]), 0.01)
    assert gone.tolist() == [False, False, True]
    assert instead[1, 2] == pytest.approx(-0.5) and instead[0, 2] < -4


@pytest.mark.parametrize(("listed", "told"), [(SURE, 0.9), (0.0, 0.9), (-np.log(9), 0.5), (-30.0, 0.0)])
def test_what_shows_none_of_its_identities_is_less_likely_to_be_there(listed, told):
    fit = IdentityFit("a", 0.9, "b", True, evidence={"a": 0.0, "b": -3.0}, listed=listed)
    assert one_of_these(0.9, fit) == pytest.approx(told, abs=1e-9)
    assert one_of_these(0.9, replace(fit, evidence={})) == 0.9 == one_of_these(0.9, None)


def test_two_that_claim_the_only_name_are_both_in_doubt():
    fits = told([[0.0, -20.0], [0.0, -20.0], [-20.0, 0.0]])
    assert names(fits) == [None, None, "b"]
    assert max(fit.probability for fit in fits[:2]) == pytest.approx(0.5)


def test_one_name_for_one_object_has_no_rival():
    (fit,) = told([[-40.0]])
    assert (fit.name, fit.probability, fit.runner_up) == ("a", 1.0, None)


@pytest.mark.parametrize("count", [1, 3, 7])
@pytest.mark.parametrize("unique", [True, False])
def test_evidence_beyond_all_measure_gives_probabilities(count, unique):
    evidence = np.random.default_rng(count).choice([-1e6, 0.0, -5e5], (count, 3))
    for fit in told(evidence, unique):
        assert 0 <= fit.probability <= 1 and np.isfinite(fit.probability)


def test_identities_are_the_declared_ones_or_all_combinations():
    assert [i.name for i in identities_of(robot())] == ["gr", "gv", "rg", "vr"]
    open_ = identities_of(robot(identities=()))
    assert [i.name for i in open_] == [f"{a}_{b}" for a in "grv" for b in "grv"]
    assert open_[1].classes == {"left": "g", "right": "r"}
    assert identities_of(ROBOT["plain"]) == ()


@pytest.mark.parametrize(
    ("fit", "name"),
    [
        (None, "red_3"),
        (IdentityFit(None, 0.6, "gr", True), "red_unknown_3"),
        (IdentityFit("gr", 0.9, "gv", True), "red_gr"),
        (IdentityFit("gr", 0.9, "gv", False), "red_gr_3"),
    ],
)
def test_an_object_is_called_by_its_identity_where_it_is_known(fit, name):
    assert Detection("red", 3, 0.9, ImagePose(0, 0, 0, 1), (), identity=fit).name == name


@pytest.mark.parametrize(
    ("evidence", "score", "name"),
    [
        ((0.0, -20.0), 0.9, "b"),  # the other one shows a plainly: this one is left over, and shows a, too
        ((0.0, -20.0), 0.9999, "b"),
        ((-0.1, 0.0), 0.5, "b"),  # it shows what it is called
        ((-3.0, -3.0), 0.5, "b"),  # it shows nothing: the name that is left
    ],
)
def test_what_is_left_over_is_a_name_as_far_as_pixels_may_be_misread(evidence, score, name):
    """One name is left; against its pixels an object has it only if it is surely there."""
    fits = told([[100.0, 0.0], evidence])
    assert names(fits) == ["a", name] and fits[1].probability > 0.9
    sure, one = doubted(fits, [0.5, score], 0.02)
    assert sure == fits[0]
    against = evidence[0] - evidence[1] > 10
    odds = score / (1 - score)
    expected = (0.02 * odds / (1 + 0.02 * odds)) / score if against else 1.0
    assert one.probability == pytest.approx(expected * fits[1].probability, rel=0.05)
    assert one.name == (name if one.probability >= 0.8 else None)
    assert one.evidence == fits[1].evidence


def test_who_has_no_name_stays_without():
    (fit,) = told([[0.0, -0.1]])
    assert doubted([fit, None], [0.9, 0.9], 0.02) == [fit, None]


def test_classes_that_no_identity_shows_are_none_of_the_components():
    model = robot(identities=[("gr", "g", "r"), ("vr", "v", "r")])
    assert list(model.component("left").classes) == ["g", "v"] and list(model.component("right").classes) == ["r"]
    assert list(model.component("left").unborne) == ["r"] and list(model.component("right").unborne) == ["g", "v"]
    assert robot(identities=[]).component("left").classes == COLOURS  # then all combinations exist
