"""Compiled code of the image plane says the same as the numpy code beside it."""

import numpy as np
import pytest
from scene import Placed, crane, crane_placed, disc, draw, flag, rectangle, render
from test_recognizer import BLUE, CRANE, RED, SIZE

from artrec_ros.core.alignment import contour_map, overlap, refinement, starts
from artrec_ros.core.alignment import placements as alignment
from artrec_ros.core.alignment.contour_map import ContourMap
from artrec_ros.core.alignment.matching import find_matches
from artrec_ros.core.alignment.overlap import overlap_matrix
from artrec_ros.core.alignment.placements import evidence
from artrec_ros.core.alignment.refinement import refine, refine_slanted, suppress
from artrec_ros.core.alignment.shapes import Shape
from artrec_ros.core.alignment.starts import find_starts
from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.base.jit import COMPILED
from artrec_ros.core.grouping import candidates, pair_table
from artrec_ros.core.grouping import group_search as grouping
from artrec_ros.core.grouping.candidates import candidates_of
from artrec_ros.core.grouping.group_search import GroupSearch
from artrec_ros.core.image import blobs
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.model.target import Target

pytestmark = pytest.mark.skipif(not COMPILED, reason="numba is not installed")
CONFIG = RecognizerConfig(max_slant_deg=30.0)
BLANK = (0, 0, 90, 60)
SHAPE_OF = {("base", "flag"): 0, ("base", "flag_mirrored"): 1, ("fore", "bar"): 2, ("aft", "bar"): 2}


@pytest.fixture(params=[0, 1, 2])
def scene(request):
    """Blobs, their contour map, shapes and what is wanted: cranes, a disc, noise."""
    rng = np.random.default_rng(request.param)
    truths = [
        crane_placed(*rng.uniform((60, 60), (360, 180)), rng.uniform(-3, 3), rng.uniform(30, 60), (0.2, -0.3))
        for _ in range(3)
    ]
    labels = render(SIZE, crane(), truths, RED)
    draw(labels, disc("disc", 0.3), Placed(*rng.uniform(60, 180, 2), 0.0, 60), BLUE)
    labels[rng.random(labels.shape) < 0.01] = RED
    shapes = [Shape.from_marker(m) for m in (flag(), flag(mirrored=True), rectangle("bar", 0.8, 0.16), disc("d", 0.3))]
    blobs = find_blobs(labels, {RED, BLUE}, CONFIG, BLANK)
    wanted = {(0, RED), (1, RED), (2, RED), (2, BLUE), (3, BLUE)}
    return blobs, ContourMap.build(blobs, SIZE), shapes, wanted


def both(monkeypatch, work):
    """What work() returns compiled and in numpy."""
    results = []
    for compiled in (True, False):
        for module in (alignment, blobs, candidates, contour_map, grouping, overlap, pair_table, refinement, starts):
            monkeypatch.setattr(module, "COMPILED", compiled)
        results.append(work())
    return results


def as_rows(placed):
    order = np.lexsort((placed.t.imag, placed.t.real, -placed.score, placed.shape, placed.blob))
    return placed.take(order)


def assert_alike(one, other):
    assert len(one) == len(other) > 0
    for name in ("t", "z", "w", "shape", "blob", "slot", "score"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-6, atol=1e-6, err_msg=name)


def starts_of(scene, config=CONFIG):
    return as_rows(find_starts(*scene, config, Deadline(), Deadline()))


@pytest.mark.parametrize("changes", [{}, {"coarse_keep": 20, "couple_spans": (1, 5)}, {"max_scale": 50.0}])
def test_hypotheses(monkeypatch, scene, changes):
    config = RecognizerConfig(**changes)
    assert_alike(*both(monkeypatch, lambda: starts_of(scene, config)))


def test_contours(monkeypatch, scene):
    labels = np.zeros((SIZE[1], SIZE[0]), np.uint8)
    labels[20:60, 40:140], labels[100:103, :], labels[0:9, 5:8] = RED, RED, BLUE
    one, other = both(monkeypatch, lambda: find_blobs(labels, {RED, BLUE}, CONFIG, BLANK))
    assert len(one) == len(other) == 3
    assert any(b.cut.any() and not b.cut.all() for b in one)
    for a, b in zip(one, other, strict=True):
        assert (a.label, a.area_px) == (b.label, b.area_px)
        for name in ("pixels", "contour", "normals", "cut"):
            np.testing.assert_allclose(getattr(a, name), getattr(b, name), atol=1e-12, err_msg=name)


@pytest.mark.parametrize("most_boxes", [64, 2])
def test_nearest_points(monkeypatch, scene, most_boxes):
    """OpenCV's transform, to the last bit, in boxes of their own and in one around all."""
    monkeypatch.setattr(contour_map, "_MOST_BOXES", most_boxes)
    one, other = both(monkeypatch, lambda: ContourMap.build(scene[0], SIZE))
    assert 0 == one.distance.min() < one.distance.max() == 255
    assert len(np.unique(one.nearest)) > 200
    np.testing.assert_array_equal(one.distance, other.distance)
    np.testing.assert_array_equal(one.nearest, other.nearest)


def test_refinement_and_evidence(monkeypatch, scene):
    _, cmap, shapes, _ = scene
    placed = starts_of(scene)
    assert_alike(*both(monkeypatch, lambda: refine(cmap, shapes, placed, CONFIG, Deadline())))
    slanted, in_numpy = both(monkeypatch, lambda: refine_slanted(cmap, shapes, placed, CONFIG, Deadline()))
    np.testing.assert_allclose(slanted.t, in_numpy.t, atol=0.01)  # some hardly determined: rounding shows
    for a, b in zip(
        *([getattr(e, f) for f in ("share", "score", "visible", "matched")] for e in both(
            monkeypatch, lambda: evidence(cmap, shapes, slanted, CONFIG, BLANK)
        )), strict=True
    ):  # fmt: skip
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_overlaps_and_pairs(monkeypatch, scene):
    blobs, cmap, shapes, wanted = scene
    matches = find_matches(blobs, cmap, shapes[:3], {w for w in wanted if w[0] < 3}, CONFIG, Deadline(), BLANK)
    assert len(matches) > 5
    np.testing.assert_allclose(
        *both(monkeypatch, lambda: overlap_matrix(shapes, matches.placed, matches.labels)), atol=1e-12
    )
    target = Target("crane", crane(), RED, CRANE)
    all_ = candidates_of(target, SHAPE_OF, matches, CONFIG)
    rows, columns = np.arange(len(all_)), np.arange(len(all_))[::2]
    one, other = both(monkeypatch, lambda: pair_table.pair_table(all_, rows, columns, matches.overlap, CONFIG))
    assert one.checked.any() and (one.violation[one.checked] == 0).any()
    np.testing.assert_array_equal(one.forbidden, other.forbidden)
    np.testing.assert_array_equal(one.checked, other.checked)
    np.testing.assert_allclose(one.violation, other.violation, atol=1e-9)


@pytest.mark.parametrize("most", [500, 4])
def test_candidates_and_those_that_matter_to_a_seed(monkeypatch, scene, most):
    monkeypatch.setattr(pair_table, "_MAX_PARTNERS", most)
    blobs, cmap, shapes, wanted = scene
    matches = find_matches(blobs, cmap, shapes[:3], {w for w in wanted if w[0] < 3}, CONFIG, Deadline(), BLANK)
    target = Target("crane", crane(), RED, CRANE)

    def related():
        search = GroupSearch(candidates_of(target, SHAPE_OF, matches, CONFIG), matches, CONFIG, Deadline())
        c, t = search.candidates, search.table
        whole = [search.seeds, c.component, c.marker, c.role, c.match, t.forbidden, t.checked]
        return whole, [*c.poses.arrays, c.share, c.score, c.weight, t.violation]

    one, other = both(monkeypatch, related)
    assert 0 < len(one[0][0]) < len(one[0][1])
    for a, b in zip(one[0], other[0], strict=True):
        np.testing.assert_array_equal(a, b)
    for a, b in zip(one[1], other[1], strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_groups(monkeypatch, scene):
    blobs, cmap, shapes, wanted = scene
    matches = find_matches(blobs, cmap, shapes[:3], {w for w in wanted if w[0] < 3}, CONFIG, Deadline(), BLANK)
    all_ = candidates_of(Target("crane", crane(), RED, CRANE), SHAPE_OF, matches, CONFIG)
    for changes in ({}, {"missing_cost": 0.0, "min_components": 1, "min_satisfied": 0.5}, {"search_nodes": 3}):
        config = RecognizerConfig(**changes)

        def grouped(config=config):
            search = GroupSearch(all_, matches, config, Deadline())
            found = [g for seed in search.seeds for g in search.best_groups(int(seed), frozenset([0, 3]))]
            return [(g.members, g.matches, g.satisfied, g.checked) for g in found], [
                (g.weight, g.score) for g in found
            ], search.exact  # fmt: skip

        one, other = both(monkeypatch, grouped)
        assert one[0] == other[0] and len(one[0]) > 0
        np.testing.assert_allclose(one[1], other[1], atol=1e-6)
        assert one[2] == other[2] == ("search_nodes" not in changes)


def test_suppression(monkeypatch, scene):
    _, _, shapes, _ = scene
    placed = starts_of(scene)
    rng = np.random.default_rng(0)
    placed = placed.replace(w=0.2 * placed.z * rng.random(len(placed)), score=rng.integers(0, 9, len(placed)) / 9)
    group, quota = placed.blob * 10 + placed.shape, rng.integers(1, 9, len(placed))
    quota = quota[np.unique(group, return_inverse=True)[1]]
    one, other = both(monkeypatch, lambda: suppress(placed, group, shapes, quota, CONFIG, 0.5, Deadline()))
    assert one.tolist() == other.tolist()
    assert 0 < len(one) < len(placed)
