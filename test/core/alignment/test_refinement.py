"""Placements thinned out, brought to the contours, and what the contours tell of them."""

from functools import partial

import numpy as np
import pytest
from cranes import BLANK, BLUE, CONFIG, RED, SIZE, TRUTH, placed_points
from scene import flag

from artrec_ros.core.alignment import refinement_kernels as contour_fit
from artrec_ros.core.alignment.contour_map import ContourMap
from artrec_ros.core.alignment.placements import Placements, evidence
from artrec_ros.core.alignment.refinement import refine, suppress
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.image.blobs import find_blobs

pytestmark = pytest.mark.uncompiled


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


@pytest.mark.parametrize("slanted", [False, True])
def test_refinement_finds_a_known_similarity(scene, slanted):
    truth = TRUTH["base", "flag"]
    z = truth.scale * np.exp(1j * (truth.theta - flag().axis_angle))
    rng = np.random.default_rng(1)
    off = rng.normal(0, 1, (4, 12))
    t0, z0 = complex(truth.x, truth.y) + off[0] + 1j * off[1], z * np.exp(0.04 * (off[2] + 1j * off[3]))
    none = np.zeros(12, np.int32)
    placed = Placements.similarities(t0, z0, none, none, none + scene.cmap.slots[RED])
    found = refine(scene.cmap, scene.shapes, placed, CONFIG, Deadline(), slanted=slanted)
    assert np.median(np.abs(found.t - complex(truth.x, truth.y))) < 0.3 < np.median(np.abs(t0 - found.t))
    assert np.median(np.abs(found.z / z - 1)) < 0.02
    assert (np.abs(found.w) <= np.tan(np.radians(15)) ** 2 * np.abs(found.z) + 1e-9).all()
    assert found.w.any() == slanted


@pytest.mark.parametrize("slanted", [False, True])
def test_refinement_of_each_is_its_own_and_moves_with_the_image(scene, starts, slanted):
    some = starts.take(np.arange(0, len(starts), 7))
    refined = partial(refine, config=CONFIG, deadline=Deadline(), slanted=slanted)
    together = refined(scene.cmap, scene.shapes, some)
    labels = np.zeros((SIZE[1] + 40, SIZE[0] + 60), np.uint8)
    labels[19 : 19 + SIZE[1], 23 : 23 + SIZE[0]] = scene.labels
    inside = np.flatnonzero([not b.cut.any() for b in scene.blobs])  # whose contour the border does not end
    moved = ContourMap.build(find_blobs(labels, {RED, BLUE}, CONFIG), labels.shape[::-1])
    alone = Placements.concatenate(
        [refined(scene.cmap, scene.shapes, some.take(np.array([n]))) for n in range(len(some))]
    )
    there = refined(moved, scene.shapes, some.replace(t=some.t + 23 + 19j))
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
