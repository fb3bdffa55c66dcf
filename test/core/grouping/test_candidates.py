"""Instances in all their roles, and the table of which go together."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from cranes import BLANK, BLUE, CONFIG, CRANE, MARKERS, RED, SHAPE_OF
from scene import crane, disc

from artrec_ros.core.alignment.matching import find_matches
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.constraints.intervals import Interval
from artrec_ros.core.constraints.pair_boxes import reach_m
from artrec_ros.core.geometry.range_limits import scale_limits
from artrec_ros.core.grouping import pair_table
from artrec_ros.core.grouping.candidates import Roles, candidates_of
from artrec_ros.core.grouping.group_search import GroupSearch
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.verdict.explain import violations

pytestmark = pytest.mark.uncompiled


def test_candidates_are_instances_in_every_role_and_direction(matches, candidates):
    number = {c.name: n for n, c in enumerate(crane().components)}
    for k in range(len(matches)):
        mine = np.flatnonzero(candidates.match == k)
        keys = sorted(candidates.key(n) for n in mine)
        s = matches.placed.shape[k]
        roles = [key for key, of in SHAPE_OF.items() if of == s]
        order = matches.shapes[s].symmetry.order(matches.placed.scale[k], CONFIG.alignment.symmetry_px)
        assert keys == sorted(roles * max(order, 1))
        for n in mine:
            assert number[candidates.key(n)[0]] == candidates.component[n]
            pose = candidates.poses.at(n)
            radius = matches.shapes[s].rms_radius_m * pose.scale
            place = np.hypot(CONFIG.constraints.contour_noise_px, CONFIG.constraints.model_noise * radius)
            assert (pose.x + 1j * pose.y, pose.scale) == (matches.placed.t[k], pytest.approx(matches.placed.scale[k]))
            assert (pose.place_noise_px, pose.scale_noise) == (pytest.approx(place), pytest.approx(place / radius))
            assert pose.theta_noise == pytest.approx(place / radius if order else np.pi)
            axis = np.exp(1j * MARKERS[s].axis_angle)
            turn = pose.theta - np.angle(matches.placed.z[k] * axis + matches.placed.w[k] * np.conj(axis))
            assert np.exp(1j * turn * max(order, 1)) == pytest.approx(1)
            in_view_px = matches.evidence.visible[k] * matches.perimeter_px[k]
            assert candidates.weight[n] == pytest.approx(matches.placed.score[k] * in_view_px)
        for role in roles:
            thetas = [candidates.poses.theta[n] for n in mine if candidates.key(n) == role]
            assert len({round(float(theta), 6) for theta in thetas}) == max(order, 1)
    assert len(candidates) > len(matches) > 3


def test_of_a_disc_no_direction_is_known(scene):
    scales = scale_limits(CONFIG, None)
    found = find_matches(scene.blobs, scene.cmap, scene.shapes, {(3, BLUE)}, CONFIG, Deadline(), BLANK, scales)
    model = ObjectModel("dot", (Component("dot", (disc("d", 0.3),), required=True),))
    dots = candidates_of(Roles.of(Target("dot", model, BLUE), {("dot", "d"): 3}), found, CONFIG)
    assert dots.match.tolist() == list(range(len(found))) and len(found) > 0
    assert (dots.poses.theta_noise == np.pi).all()


def test_pairs_are_forbidden_or_checked_as_their_explanation_says(matches, candidates):
    c, constraints = candidates, CRANE
    table = pair_table.pair_table(c, matches.overlap, CONFIG)
    for a, b in itertools.product(range(len(c)), range(len(c))):
        ratio = np.exp(abs(np.log(c.poses.scale[a] / c.poses.scale[b])))
        shared = matches.overlap[c.match[a], c.match[b]] > CONFIG.grouping.max_group_overlap
        forbidden = c.component[a] == c.component[b] or ratio > CONFIG.grouping.max_scale_ratio or shared
        first, second = (a, b) if constraints.pair(c.key(a), c.key(b)) else (b, a)
        pair = constraints.pair(c.key(first), c.key(second))
        assert table.forbidden[a, b] == forbidden
        assert table.checked[a, b] == (pair is not None and not forbidden)
        worst = 0.0
        if table.checked[a, b]:
            outside = violations(pair, *(c.poses.at(np.array([n])) for n in (first, second)))
            worst = max(v[0] / reach_m(pair) if d.endswith("_m") else v[0] for d, v in outside.items())
        assert table.violation[a, b] == pytest.approx(worst, abs=1e-9)
    assert (table.violation[table.checked] == 0).any() and (table.violation > 0).any()


@pytest.mark.parametrize("most, fit", [(500, True), (3, True), (500, False)])
def test_candidates_that_matter_to_a_seed_are_kept(matches, candidates, most, fit):
    """Those that go with one, or miss it by the least."""
    config = replace(CONFIG, grouping=replace(CONFIG.grouping, max_partners=most))
    if not fit:
        pairs = tuple(replace(p, allowed={"distance_m": Interval(2.0, 2.1)}) for p in CRANE.pairs)
        target = Target("crane", crane(), RED, replace(CRANE, pairs=pairs))
        candidates = candidates_of(Roles.of(target, SHAPE_OF), matches, CONFIG)
    whole = pair_table.pair_table(candidates, matches.overlap, CONFIG)
    seeds = np.flatnonzero(candidates.component == 0)
    partners = set()
    for s in seeds:
        for component in (1, 2):
            mine = np.flatnonzero(candidates.component == component)
            partners |= {int(n) for n in mine if not whole.forbidden[s, n] and whole.violation[s, n] <= 0}
            miss = np.where(whole.checked[s, mine], whole.violation[s, mine], np.inf)
            partners.add(int(mine[miss.argmin()]))
    kept = sorted(sorted(partners, key=lambda n: (-candidates.weight[n], n))[:most])
    search = GroupSearch(candidates, matches, config, Deadline())
    index = np.concatenate([seeds, kept]).astype(int)
    assert search.seeds.tolist() == list(range(len(seeds)))
    np.testing.assert_array_equal(search.candidates.poses.arrays, candidates.take(index).poses.arrays)
    np.testing.assert_array_equal(search.candidates.role, candidates.role[index])
    for name in ("forbidden", "checked", "violation"):
        np.testing.assert_allclose(getattr(search.table, name), getattr(whole, name)[np.ix_(index, index)], atol=1e-9)
    assert 0 < len(seeds) < len(index)
