"""Compiled code of the image plane against direct computation, libraries and laws, on small cases.

The whole file runs as plain Python as well (`test_uncompiled.py`).
"""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from scene import Placed, crane, crane_placed, disc, draw, flag, rectangle, render
from scipy.spatial import cKDTree
from settings import settings
from test_recognizer import BLUE, CRANE, RED

from artrec_ros.core.alignment import contour_map
from artrec_ros.core.alignment import refinement_kernels as contour_fit
from artrec_ros.core.alignment.contour_map import ContourMap
from artrec_ros.core.alignment.counting_kernels import by_count
from artrec_ros.core.alignment.matching import find_matches
from artrec_ros.core.alignment.overlap import overlap_matrix
from artrec_ros.core.alignment.placements import Placements, evidence, matched_share
from artrec_ros.core.alignment.refinement import refine, refine_slanted, suppress
from artrec_ros.core.alignment.shapes import Shape
from artrec_ros.core.alignment.starts import find_starts
from artrec_ros.core.base.config import with_values
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.constraints.intervals import Interval
from artrec_ros.core.constraints.pair_boxes import reach_m
from artrec_ros.core.grouping import group_kernels as group_search
from artrec_ros.core.grouping import group_search as grouping
from artrec_ros.core.grouping import pair_table
from artrec_ros.core.grouping.candidates import candidates_of
from artrec_ros.core.grouping.group_search import GroupSearch
from artrec_ros.core.image.blobs import blob_anchors, find_blobs
from artrec_ros.core.image.contour_kernels import merge_boxes
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.verdict.explain import violations

pytestmark = pytest.mark.uncompiled
CONFIG = settings(max_slant_deg=30.0, coarse_step=8, refine_steps=6)
SIZE = (150, 110)
BLANK = (0, 0, 40, 20)
MARKERS = (flag(), flag(mirrored=True), rectangle("bar", 0.8, 0.16), disc("d", 0.3))
SHAPE_OF = {("base", "flag"): 0, ("base", "flag_mirrored"): 1, ("fore", "bar"): 2, ("aft", "bar"): 2}
CRANES = {(0, RED), (1, RED), (2, RED)}
TRUTH = crane_placed(60.3, 44.6, 0.4, 34, (0.2, -0.3))


@pytest.fixture(scope="module")
def scene():
    """Labels, blobs, their contour map, shapes: a crane, a disc, one that the border cuts off."""
    labels = render(SIZE, crane(), [TRUTH], RED)
    draw(labels, disc("disc", 0.3), Placed(120, 30, 0.0, 40), BLUE)
    draw(labels, flag(), Placed(140, 90, 2.0, 30), RED)
    blobs = find_blobs(labels, {RED, BLUE}, CONFIG, BLANK)
    return SimpleNamespace(
        labels=labels, blobs=blobs, cmap=ContourMap.build(blobs, SIZE), shapes=[Shape.from_marker(m) for m in MARKERS]
    )


@pytest.fixture(scope="module")
def starts(scene):
    return find_starts(scene.blobs, scene.cmap, scene.shapes, {*CRANES, (3, BLUE)}, CONFIG, Deadline())


@pytest.fixture(scope="module")
def matches(scene):
    return find_matches(scene.blobs, scene.cmap, scene.shapes[:3], CRANES, CONFIG, Deadline(), BLANK)


@pytest.fixture(scope="module")
def candidates(matches):
    return candidates_of(Target("crane", crane(), RED, CRANE), SHAPE_OF, matches, CONFIG)


def placed_points(p, n, points):
    return p.t[n] + p.z[n] * points + p.w[n] * np.conj(points)


# contours and their map


def test_contours_turn_with_the_image(scene):
    """By a quarter, points and normals alike; and the inside stays on the same side."""
    turned = find_blobs(np.ascontiguousarray(np.rot90(scene.labels)), {RED, BLUE}, CONFIG)
    upright = find_blobs(scene.labels, {RED, BLUE}, CONFIG)
    assert len(upright) == len(turned) >= 4
    for b in upright:
        x, y = b.contour.T
        expected = np.stack([y, SIZE[0] - 1 - x, b.normals[:, 1], -b.normals[:, 0]], axis=1)
        (same,) = (o for o in turned if cKDTree(o.contour).query(expected[:, :2])[0].max() < 1e-9)
        got = np.concatenate([same.contour, same.normals], axis=1)
        assert cKDTree(got).query(expected)[0].max() < 1e-9
        for blob in (b, same):
            x, y = blob.pixels.T.astype(int)
            assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0


def test_points_where_something_else_ends_are_cut(scene):
    for b in find_blobs(scene.labels, {RED}, CONFIG, (30, 20, 40, 30)):
        for (x, y), cut in zip(b.pixels.tolist(), b.cut, strict=True):
            assert cut == (x in (0, SIZE[0] - 1) or y in (0, SIZE[1] - 1) or (29 <= x <= 70 and 19 <= y <= 50))


@pytest.mark.parametrize("most_boxes", [64, 0])
def test_the_map_holds_opencvs_transform(monkeypatch, scene, most_boxes):
    """To the last bit, in boxes of their own and in one around all; and the nearest points are near."""
    monkeypatch.setattr(contour_map, "_MOST_BOXES", most_boxes)
    cmap, blobs = ContourMap.build(scene.blobs, SIZE), scene.blobs
    pixels = np.concatenate([b.pixels for b in blobs]) - np.array(cmap.origin)
    seen = ~np.concatenate([b.cut for b in blobs])
    distance = np.full(cmap.distance.shape, 255, np.uint8)
    for label, slot in cmap.slots.items():
        top, of_class = slot * cmap.height, np.array([blobs[b].label == label for b in cmap.blob[:-1]])
        corners = [pixels[cmap.blob[:-1] == n] for n, b in enumerate(blobs) if b.label == label]
        boxes = np.array([[*p.min(axis=0) - 16, *p.max(axis=0) + 17] for p in corners])
        whole = np.array([[*boxes[:, :2].min(axis=0), *boxes[:, 2:].max(axis=0)]])
        for left, above, right, below in (merge_boxes(boxes) if most_boxes else whole).tolist():
            canvas = np.full((below - above, right - left), 255, np.uint8)
            x, y = pixels[seen & of_class].T
            inside = (x >= left) & (x < right) & (y >= above) & (y < below)
            canvas[y[inside] - above, x[inside] - left] = 0
            far = cv2.distanceTransform(canvas, cv2.DIST_L2, 5)
            distance[top + above : top + below, left:right] = cv2.convertScaleAbs(far, alpha=15.0)
        rows, columns = np.nonzero(cmap.distance[top : top + cmap.height] < 200)
        index = cmap.nearest[top + rows, columns]
        assert (seen & of_class)[index].all()
        here = np.stack([columns, rows], axis=1)
        true = cKDTree(pixels[seen & of_class]).query(here)[0]
        np.testing.assert_allclose(np.hypot(*(pixels[index] - here).T), true, rtol=0.035)
    np.testing.assert_array_equal(cmap.distance, distance)
    assert 0 == distance.min() < distance.max() == 255


# hypotheses


def test_points_are_counted(scene, starts):
    """As one reads them from the map one by one."""
    cmap, few = scene.cmap, starts.take(np.arange(0, len(starts), 5))
    few = few.replace(t=few.t + np.linspace(0, 5, len(few)))
    share = matched_share(cmap, scene.shapes, few, 2.0, Deadline())
    for n in range(len(few)):
        hits = 0
        for p in placed_points(few, n, scene.shapes[few.shape[n]].points) - complex(*cmap.origin):
            x, y = round(p.real), round(p.imag)
            inside = 0 <= x < cmap.distance.shape[1] and 0 <= y < cmap.height
            hits += inside and cmap.distance[few.slot[n] * cmap.height + y, x] <= 30
        assert share[n] == hits / 120
    assert share.min() < 0.5 < share.max()
    late = Deadline(0)
    assert not matched_share(cmap, scene.shapes, few, 2.0, late).any() and late.hit


def test_counts_are_sorted_and_equal_ones_keep_their_order():
    count = np.random.default_rng(0).integers(0, 9, 60)
    assert by_count(count, 60, 8).tolist() == np.argsort(-count, kind="stable").tolist()
    assert by_count(count[:0], 0, 8).tolist() == []


@pytest.mark.parametrize("changes", [{}, {"coarse_keep": 20, "couple_spans": (1, 3)}, {"max_scale": 33.0}])
def test_starts_are_the_best_of_all_hypotheses(scene, changes):
    """Of every couple of anchors and every turn over the whole blob, tried one by one."""
    config = settings(coarse_step=8, **changes)
    found = find_starts(scene.blobs, scene.cmap, scene.shapes, {(0, RED)}, config, Deadline())
    shape, most = scene.shapes[0], config.max_scale or np.inf
    for b, blob in enumerate(scene.blobs):
        mine = found.take(np.flatnonzero(found.blob == b))
        if blob.label != RED:
            assert not len(mine)
            continue
        tried = []
        for polygon in blob_anchors(blob, config):
            p, q = polygon @ np.array([1, 1j]), shape.anchors
            spans = config.alignment.couple_spans
            for i, j, span, other in itertools.product(range(len(p)), range(len(q)), spans, spans):
                if span < len(p) and other < len(q):
                    z = (p[(i + span) % len(p)] - p[i]) / (q[(j + other) % len(q)] - q[j])
                    tried.append((p[i] - z * q[j], z))
        moments = cv2.moments(blob.polygon)
        centre = complex(moments["m10"], moments["m01"]) / moments["m00"]
        k = np.sqrt(blob.area_px / shape.area_m2)
        tried += [(centre, k * np.exp(2j * np.pi * turn / 24)) for turn in range(24)]
        t, z = np.array(tried).T
        area = shape.area_m2 * np.abs(z) ** 2
        low = max(config.min_blob_px, config.alignment.min_area_ratio * blob.area_px)
        high = config.alignment.max_area_ratio * blob.area_px
        t, z, area = (a[(low <= area) & (area <= high) & (np.abs(z) <= most)] for a in (t, z, area))
        tolerance = np.clip(config.alignment.tolerance_share * np.sqrt(area), 1.0, config.alignment.tolerance_px)
        slot = scene.cmap.slots[RED]
        where = t[:, None] + z[:, None] * shape.points - complex(*scene.cmap.origin)
        x = np.clip(np.rint(where.real), 0, scene.cmap.distance.shape[1] - 1).astype(int)
        y = np.clip(np.rint(where.imag), 0, scene.cmap.height - 1).astype(int)
        near = scene.cmap.distance[slot * scene.cmap.height + y, x] <= np.floor(tolerance * 15)[:, None]
        share = near.mean(axis=1)
        passed = (near[:, ::8].mean(axis=1) >= config.alignment.coarse_match) & (share >= config.alignment.coarse_match)
        assert bool(len(mine)) == passed.any()
        if not len(mine):
            continue
        assert mine.score[0] == mine.score.max() == pytest.approx(share[passed].max())
        assert len(mine) <= max(4, len(blob.pixels) // 8)
        for n in range(len(mine)):
            same = (np.abs(t - mine.t[n]) < 1e-6) & (np.abs(z - mine.z[n]) < 1e-6)
            assert same.any() and np.abs(share[same] - mine.score[n]).min() < 1e-12
        apart = np.hypot(np.abs(mine.t[:, None] - mine.t), shape.rms_radius_m * np.abs(mine.z[:, None] - mine.z))
        reach = np.maximum(1.0, config.alignment.same_start * shape.rms_radius_m * np.abs(mine.z))
        for a, better in itertools.combinations(range(len(mine)), 2):
            assert apart[a, better] > reach[a] - 1e-9
        if "coarse_keep" not in changes:  # what is not kept is near one as good, unless the quota is full
            for n in np.flatnonzero(passed) if len(mine) < max(4, len(blob.pixels) // 8) else ():
                d = np.hypot(np.abs(mine.t - t[n]), shape.rms_radius_m * np.abs(mine.z - z[n]))
                assert ((d <= reach + 1e-9) & (mine.score >= share[n] - 1e-12)).any()
    assert len(found)


def test_suppression_goes_from_the_best_to_the_worst(scene, starts):
    rng = np.random.default_rng(0)
    w = 0.9 * starts.z * rng.random(len(starts))
    placed = starts.replace(w=w, score=rng.integers(0, 9, len(starts)) / 9)
    group, quota = placed.blob * 10 + placed.shape, rng.integers(1, 6, 1000)
    quota = quota[group]
    expected = []
    for g in np.unique(group):
        kept = []
        for n in sorted(np.flatnonzero(group == g), key=lambda n: -placed.score[n]):
            shape = scene.shapes[placed.shape[n]]
            for m in kept:
                order = shape.symmetry.order(placed.scale[m], CONFIG.alignment.symmetry_px)
                turned = np.abs(placed.z[n] - placed.z[m] * np.exp(2j * np.pi * np.arange(order or 1) / (order or 1)))
                turn = turned.min() if order else abs(abs(placed.z[n]) - abs(placed.z[m]))
                squeeze = abs(w[n]) - abs(w[m])
                off = np.hypot(abs(placed.t[n] - placed.t[m]), shape.rms_radius_m * np.hypot(turn, squeeze))
                if off <= max(1.0, 0.5 * shape.rms_radius_m * placed.scale[m]):
                    break
            else:
                kept += [n] if len(kept) < quota[n] else []
        expected += kept
    assert suppress(placed, group, scene.shapes, quota, CONFIG, 0.5).tolist() == expected
    assert 0 < len(expected) < len(placed)


# refinement and evidence


def test_equations_are_solved():
    rng = np.random.default_rng(0)
    for _ in range(10):
        J = rng.normal(size=(12, 6))
        A, b = J.T @ J + 0.1 * np.eye(6), rng.normal(size=6)
        got, full = b.copy(), A.copy()
        contour_fit._solve(full, got, 6)
        np.testing.assert_allclose(got, np.linalg.solve(A, b), rtol=1e-9)
        four = A[:4, :4]
        lower = tuple(four[i, j] for i in range(4) for j in range(i + 1))
        got = contour_fit._solve_similarity(lower, tuple(b[:4]), 0.5)
        np.testing.assert_allclose(got, np.linalg.solve(four + 0.5 * np.eye(4), -b[:4]), rtol=1e-9)


def test_a_step_of_refinement_is_weighted_least_squares():
    """Of point-to-line distances, by their derivatives with respect to (x, y, Re z, Im z)."""
    rng = np.random.default_rng(3)
    z, gate = 20 * np.exp(0.7j), 3.0
    p, n_shape, n = rng.normal(size=40) + 1j * rng.normal(size=40), *np.exp(1j * rng.uniform(-1, 1, (2, 40)))
    off = rng.normal(0, 2, 40) + 1j * rng.normal(0, 2, 40)
    residual = (np.conj(n) * off).real
    J = np.stack([n.real, n.imag, (np.conj(n) * p).real, (np.conj(n) * 1j * p).real], axis=1)
    weight = np.clip(1 - (residual / gate) ** 2, 0, None) ** 2 * (np.abs(off) < 2 * gate)
    weight *= (np.conj(z / abs(z) * n_shape) * n).real >= 0.6
    assert 5 < np.count_nonzero(weight) < 35
    A, b = J.T @ (weight[:, None] * J), J.T @ (weight * residual)
    found = np.stack([off.real, off.imag, n.real, n.imag])
    parts = (np.ascontiguousarray(a) for a in (p.real, p.imag, n_shape.real, n_shape.imag))
    lower, right = contour_fit._similarity_sums(*parts, found, z.real, z.imag, gate, 0.6)
    np.testing.assert_allclose(lower, [A[i, j] for i in range(4) for j in range(i + 1)], atol=1e-9)
    np.testing.assert_allclose(right, b, atol=1e-9)


@pytest.mark.parametrize("method", [refine, refine_slanted])
def test_refinement_finds_a_known_similarity(scene, method):
    truth = TRUTH["base", "flag"]
    z = truth.scale * np.exp(1j * (truth.theta - flag().axis_angle))
    rng = np.random.default_rng(1)
    off = rng.normal(0, 1, (4, 12))
    t0, z0 = complex(truth.x, truth.y) + off[0] + 1j * off[1], z * np.exp(0.04 * (off[2] + 1j * off[3]))
    none = np.zeros(12, np.int32)
    placed = Placements.similarities(t0, z0, none, none, none + scene.cmap.slots[RED])
    found = method(scene.cmap, scene.shapes, placed, CONFIG, Deadline())
    assert np.median(np.abs(found.t - complex(truth.x, truth.y))) < 0.3 < np.median(np.abs(t0 - found.t))
    assert np.median(np.abs(found.z / z - 1)) < 0.02
    assert (np.abs(found.w) <= np.tan(np.radians(15)) ** 2 * np.abs(found.z) + 1e-9).all()
    assert found.w.any() == (method is refine_slanted)


@pytest.mark.parametrize("method", [refine, refine_slanted])
def test_refinement_of_each_is_its_own_and_moves_with_the_image(scene, starts, method):
    some = starts.take(np.arange(0, len(starts), 7))
    together = method(scene.cmap, scene.shapes, some, CONFIG, Deadline())
    labels = np.zeros((SIZE[1] + 40, SIZE[0] + 60), np.uint8)
    labels[19 : 19 + SIZE[1], 23 : 23 + SIZE[0]] = scene.labels
    inside = np.flatnonzero([not b.cut.any() for b in scene.blobs])  # whose contour the border does not end
    moved = ContourMap.build(find_blobs(labels, {RED, BLUE}, CONFIG), labels.shape[::-1])
    alone = Placements.concatenate(
        [method(scene.cmap, scene.shapes, some.take(np.array([n])), CONFIG, Deadline()) for n in range(len(some))]
    )
    there = method(moved, scene.shapes, some.replace(t=some.t + 23 + 19j), CONFIG, Deadline())
    mine = np.isin(some.blob, inside)
    assert mine.sum() > 3
    for name, shift in (("t", 23 + 19j), ("z", 0), ("w", 0)):
        expected = getattr(together, name)
        np.testing.assert_allclose(getattr(alone, name), expected, rtol=1e-9, atol=1e-9)
        near = mine & (np.abs(together.t - some.t) < 10)
        np.testing.assert_allclose(getattr(there, name)[near] - shift, expected[near], rtol=1e-5, atol=1e-5)


def test_evidence_is_what_each_point_tells(scene, starts):
    cmap, some = scene.cmap, starts.take(np.arange(0, len(starts), 6))
    number = np.arange(len(some))
    at_border = SIZE[0] - 1 + 1j * np.linspace(20, SIZE[1] - 1, len(some))
    t = np.select([number % 4 == 2, number % 4 == 3], [some.t - (30 + 25j), at_border], some.t)
    some = some.replace(t=t, w=0.1 * some.z * np.exp(1j * number))
    found = evidence(cmap, scene.shapes, some, CONFIG, BLANK)
    share, most_px = CONFIG.alignment.tolerance_share, CONFIG.alignment.tolerance_px
    tolerance = np.clip(share * np.sqrt(some.area_px(scene.shapes)), 1.0, most_px)
    for n in range(len(some)):
        shape = scene.shapes[some.shape[n]]
        hits, worth, in_view = 0, 0.0, 0
        for i, p in enumerate(placed_points(some, n, shape.points)):
            x = int(np.clip(np.rint(p.real - cmap.origin[0]), 0, cmap.nearest.shape[1] - 1))
            y = int(np.clip(np.rint(p.imag - cmap.origin[1]), 0, cmap.height - 1))
            at = cmap.nearest[some.slot[n] * cmap.height + y, x]
            normal = some.z[n] * shape.normals[i] - some.w[n] * np.conj(shape.normals[i])
            off, cosine = abs(p - cmap.points[at]), (np.conj(normal / abs(normal)) * cmap.normals[at]).real
            matched = off <= tolerance[n] and cosine >= 0.6
            assert found.matched[n, i] == (at if matched else -1)
            blank = -1.5 <= p.real <= 40.5 and -1.5 <= p.imag <= 20.5
            seen = 0.5 < p.real < SIZE[0] - 1.5 and 0.5 < p.imag < SIZE[1] - 1.5 and not blank
            in_view += seen
            hits += matched and seen
            worth += 1 - 0.5 * (off / tolerance[n]) ** 2 if matched and seen else 0.0
        assert found.share[n] == pytest.approx(hits / max(in_view, 1))
        assert found.score[n] == pytest.approx(worth / max(in_view, 1))
        assert found.visible[n] == pytest.approx(in_view / 120)
    assert found.share.min() < 0.5 < found.share.max() and found.visible.min() < 1


# pairs, candidates, groups


def test_overlap_is_that_of_the_polygons():
    rng = np.random.default_rng(2)
    shapes = [Shape.from_marker(rectangle("bar", 1.0, 0.5)), Shape.from_marker(disc("d", 0.4))]
    n, none = 12, np.zeros(12, np.int32)
    t = rng.uniform(0, 50, (n, 2)) @ np.array([1, 1j])
    z = 30 * np.exp(rng.normal(0, 0.3, n) + 1j * rng.uniform(-3, 3, n))
    placed = Placements.similarities(t, z, np.arange(n, dtype=np.int32) % 2, none, none).replace(w=0.2 * np.conj(z))
    overlap = overlap_matrix(shapes, placed, np.zeros(n, int))
    for i, j in itertools.product(range(n), range(n)):
        a, b = (placed_points(placed, k, shapes[k % 2].corners) for k in (i, j))
        a, b = (np.stack([p.real, p.imag], axis=1).astype(np.float32) for p in (a, b))
        common = cv2.intersectConvexConvex(a, b)[0] / min(cv2.contourArea(a), cv2.contourArea(b))
        assert overlap[i, j] == pytest.approx(common, abs=0.06)
    assert (np.triu(overlap, 1) > 0.3).any() and (overlap == 0).any()


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
            turn = pose.theta - matches.axis_direction(k, MARKERS[s].axis_angle)
            assert np.exp(1j * turn * max(order, 1)) == pytest.approx(1)
            assert candidates.weight[n] == pytest.approx(matches.placed.score[k] * matches.perimeter_px[k])
        for role in roles:
            thetas = [candidates.poses.theta[n] for n in mine if candidates.key(n) == role]
            assert len({round(float(theta), 6) for theta in thetas}) == max(order, 1)
    assert len(candidates) > len(matches) > 3


def test_of_a_disc_no_direction_is_known(scene):
    found = find_matches(scene.blobs, scene.cmap, scene.shapes, {(3, BLUE)}, CONFIG, Deadline(), BLANK)
    model = ObjectModel("dot", (Component("dot", (disc("d", 0.3),), required=True),))
    dots = candidates_of(Target("dot", model, BLUE), {("dot", "d"): 3}, found, CONFIG)
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
    if not fit:
        pairs = tuple(replace(p, allowed={"distance_m": Interval(2.0, 2.1)}) for p in CRANE.pairs)
        target = Target("crane", crane(), RED, replace(CRANE, pairs=pairs))
        candidates = candidates_of(target, SHAPE_OF, matches, CONFIG)
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
    search = GroupSearch(candidates, matches, with_values(CONFIG, {"grouping.max_partners": most}), Deadline())
    index = np.concatenate([seeds, kept]).astype(int)
    assert search.seeds.tolist() == list(range(len(seeds)))
    np.testing.assert_array_equal(search.candidates.poses.arrays, candidates.take(index).poses.arrays)
    np.testing.assert_array_equal(search.candidates.role, candidates.role[index])
    for name in ("forbidden", "checked", "violation"):
        np.testing.assert_allclose(getattr(search.table, name), getattr(whole, name)[np.ix_(index, index)], atol=1e-9)
    assert 0 < len(seeds) < len(index)


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
