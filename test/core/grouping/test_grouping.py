"""Groups and their choice, from instances given without any image."""

import numpy as np
import pytest
from scene import Placed
from toy_groups import BAR, BASE_AFT, BASE_FORE, FLAG, at, found, names, pair, solved

from artrec_ros.core.learning.pair_learning import learn
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.verdict.report import rejections_of


@pytest.mark.parametrize("groups_per_seed", [1, 4])
def test_what_two_bases_claim_goes_where_nothing_else_can(groups_per_seed):
    # the clear bar fits both bases, the faint one only the left
    matches = found((0, at(0), 0.9), (0, at(2), 0.9), (1, at(1), 0.95), (1, at(0, 1), 0.7))
    solution, _, _ = solved(matches, BASE_FORE, groups_per_seed=groups_per_seed)
    assert sorted(tuple(sorted(names(g).items())) for g in solution.accepted) == [
        (("base", 0), ("fore", 3)), (("base", 1), ("fore", 2)),
    ]  # fmt: skip
    assert not solution.out_of_nodes


def test_a_component_that_no_constraint_ties_is_left_out():
    matches = found((0, at(0), 0.9), (1, at(1), 0.9), (1, at(2), 0.9))
    solution, _, _ = solved(matches, BASE_FORE)
    assert names(solution.accepted[0]) == {"base": 0, "fore": 1}
    solution, _, _ = solved(matches, BASE_FORE, BASE_AFT)
    assert names(solution.accepted[0]) == {"base": 0, "fore": 1, "aft": 2}


def test_a_chain_of_constraints_is_enough():
    matches = found((0, at(0), 0.9), (1, at(1), 0.9), (1, at(2), 0.9))
    solution, _, _ = solved(matches, BASE_FORE, pair(1, 2, 0.9, 1.1))
    assert names(solution.accepted[0]) == {"base": 0, "fore": 1, "aft": 2}


def test_enough_of_the_checked_constraints_must_hold():
    matches = found((0, at(0), 0.9), (1, at(1), 0.9), (1, at(2), 0.9))
    pairs = (BASE_FORE, BASE_AFT, pair(1, 2, 1.25, 1.4))  # the bars are 1.0 apart
    strict, lenient = (solved(matches, *pairs, min_satisfied=share)[0].accepted[0] for share in (0.8, 0.6))
    assert len(strict.members) == 2
    assert len(lenient.members) == 3
    assert (lenient.satisfied, lenient.checked) == (2, 3)
    assert lenient.score < 0.9 * 2 / 3 + 1e-9


def test_an_instance_that_agrees_with_all_goes_before_a_slightly_clearer_one():
    matches = found((0, at(0), 0.9), (1, at(1), 0.9), (1, at(-2), 0.92), (1, at(2), 0.9))
    pairs = (BASE_FORE, BASE_AFT, pair(1, 2, 0.9, 1.1))
    solution, _, _ = solved(matches, *pairs, min_satisfied=0.5)
    assert names(solution.accepted[0]) == {"base": 0, "fore": 1, "aft": 3}


def test_scales_must_agree():
    far_smaller = Placed(600, 500, 0.0, 60.0)
    solution, search, config = solved(found((0, at(0), 0.9), (1, far_smaller, 0.9)), BASE_FORE)
    assert solution.accepted == []
    assert solved(found((0, at(0), 0.9), (1, far_smaller, 0.9)), pair(0, 1, 0.9, 1.6), max_scale_ratio=2.0)[0].accepted


def test_one_instance_serves_one_component():
    both = (BASE_FORE, pair(0, 2, 0.9, 1.1))
    solution, _, _ = solved(found((0, at(0), 0.9), (1, at(1), 0.9)), *both)
    assert len(solution.accepted[0].members) == 2
    twice = found((0, at(0), 0.9), (1, at(1), 0.9), (1, at(1.02), 0.9))  # the same pixels explained again
    assert len(solved(twice, *both)[0].accepted[0].members) == 2


def test_the_reason_names_constraint_dimension_and_excess():
    matches = found((0, at(0), 0.9), (1, at(1.5), 0.9))
    solution, search, config = solved(matches, BASE_FORE)
    assert solution.accepted == []
    search.forget_table()
    (told,) = rejections_of(solution, [search], matches.overlap, config)
    assert "fore/bar at (650, 500)" in told.reason
    assert "distance_m 1.5" in told.reason and "0.9 to 1.1" in told.reason
    failed = told.failed
    assert (failed.first, failed.second, failed.dimension) == ("base/flag", "fore/bar", "distance_m")
    assert (failed.value, failed.low, failed.high) == pytest.approx((1.5, 0.9, 1.1))
    assert 0.3 < failed.outside <= 0.4  # its noise is allowed for


def test_the_reason_of_too_few_components_or_too_many_broken_constraints():
    matches = found((0, at(0), 0.9), (1, at(1), 0.9))
    solution, search, config = solved(matches, BASE_FORE, min_components=3)
    assert "2 components agree, 3 are wanted" in rejections_of(solution, [search], matches.overlap, config)[0].reason
    matches = found((0, at(0), 0.9), (1, at(1), 0.9), (1, at(2), 0.9))
    pairs = (BASE_FORE, BASE_AFT, pair(1, 2, 1.6, 1.9))
    solution, search, config = solved(matches, *pairs, min_components=3)
    search.forget_table()
    (told,) = rejections_of(solution, [search], matches.overlap, config)
    assert "2 of 3 constraints hold" in told.reason
    assert (told.failed.first, told.failed.second, told.failed.low) == ("fore/bar", "aft/bar", 1.6)


def test_faint_outlines_are_a_reason():
    matches = found((0, at(0), 0.6), (1, at(1), 0.6))
    solution, search, config = solved(matches, BASE_FORE)
    (told,) = rejections_of(solution, [search], matches.overlap, config)
    wanted = config.grouping.min_group_match
    assert "0.60 of its outline matches" in told.reason
    assert told.reason.endswith(f"{wanted:g} is wanted (expert.grouping.min_group_match)")


def test_what_an_object_lacks_is_told_with_the_constraint_that_failed():
    matches = found((0, at(0), 0.9), (1, at(1), 0.9), (1, at(2.6), 0.9))
    solution, search, config = solved(matches, BASE_FORE, BASE_AFT)
    assert len(solution.accepted) == 1
    search.forget_table()
    (told,) = rejections_of(solution, [search], matches.overlap, config)
    assert told.reason.startswith("aft: not part of the object found")
    assert (told.failed.dimension, told.failed.high) == ("distance_m", 2.1)
    assert told.x == pytest.approx(760)


def test_a_group_that_loses_its_pixels_names_its_rival():
    # both bases claim the only bar; the second base lies on pixels of its own
    matches = found((0, at(0), 0.95), (0, at(2), 0.7), (1, at(1), 0.9))
    solution, search, config = solved(matches, BASE_FORE)
    assert [g.seed for g in solution.accepted] == [0]
    search.forget_table()
    (told,) = rejections_of(solution, [search], matches.overlap, config)
    assert "loses its pixels to toy at (500, 500)" in told.reason
    assert 0 < solution.margins[0] < 1


def test_a_cut_short_search_says_so():
    rng = np.random.default_rng(0)
    bars = [(1, Placed(*(500 + 100 * np.array([np.cos(a), np.sin(a)])), a, 100.0), 0.9) for a in rng.uniform(-3, 3, 10)]
    matches = found((0, at(0), 0.9), *bars)
    pairs = (BASE_FORE, pair(0, 2, 0.9, 1.1))
    assert not solved(matches, *pairs)[0].out_of_nodes
    cut = solved(matches, *pairs, search_nodes=5)[0]
    assert cut.out_of_nodes


def test_two_markers_of_one_component_are_never_a_pair():
    model = ObjectModel("two-sided", (Component("base", (FLAG, BAR), required=True), Component("fore", (BAR,))))
    rows = [{("base", "flag"): at(0), ("base", "bar"): at(1), ("fore", "bar"): at(2)}] * 3
    pairs = {(p.first, p.second) for p in learn(model, rows).pairs}
    assert pairs == {(("base", "flag"), ("fore", "bar")), (("base", "bar"), ("fore", "bar"))}
