"""Compiled steps of the recognition in space, each against what is known of it from elsewhere."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from solids import BENT, RATIONAL, RED, camera_of, random_poses, truck

from artrec_ros.core.base import jit
from artrec_ros.core.geometry import pixel_kernels as geometry
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.image.label_field import OUTSIDE, OWNED, UNKNOWN, LabelField
from artrec_ros.core.pose import pose_fit as posefit
from artrec_ros.core.pose import step_kernels as refining
from artrec_ros.core.pose.distinct import CELL_AXIS, CELL_LOG_DEPTH, CELL_PLACE, best_distinct
from artrec_ros.core.pose.surface_model import SpatialModel

LENSES = pytest.mark.parametrize("lens", [(), BENT[:4], BENT, RATIONAL], ids=len)
pytestmark = pytest.mark.uncompiled


@pytest.fixture
def rng():
    return np.random.default_rng(3)


@pytest.fixture
def scene(rng):
    """A truck's surface, poses of it in view, and a label image that has something to say on them."""
    coarse = np.random.default_rng(4).choice([0, RED, 5, 1], (24, 32), p=[0.2, 0.4, 0.3, 0.1])
    labels = np.kron(coarse, np.ones((10, 10))).astype(np.uint8)
    return SpatialModel(truck(), RED), random_poses(rng, truck(), 12), LabelField(labels)


@LENSES
def test_points_land_where_opencv_puts_them(lens, rng):
    camera = camera_of(distortion=lens)
    view = geometry.view_of(LabelField(np.zeros((240, 320), np.uint8)), camera)
    X = np.column_stack([rng.uniform(-0.5, 0.5, (100, 2)), np.ones(100)]) * rng.uniform(0.3, 3.0, (100, 1))
    expected = cv2.projectPoints(X, np.zeros(3), np.zeros(3), camera.matrix, np.array(lens, float))[0][:, 0]
    np.testing.assert_allclose([geometry.project(*x, view) for x in X], expected, atol=1e-8)
    np.testing.assert_allclose(project(camera, X), expected, atol=1e-8)


@LENSES
def test_points_beside_and_behind_the_camera_project_alike(lens):
    camera = camera_of(distortion=lens)
    view = geometry.view_of(LabelField(np.zeros((240, 320), np.uint8)), camera)
    X = np.random.default_rng(0).normal((0, 0, 1), 1.0, (200, 3))
    found = [geometry.project(*x, view) for x in X]
    np.testing.assert_allclose(found, project(camera, X), rtol=1e-9, atol=1e-6)


def test_pixels_are_looked_up_alike():
    labels = np.random.default_rng(1).integers(0, 9, (6, 9), np.uint8)
    field = LabelField(labels)
    at = np.concatenate(
        [np.random.default_rng(2).uniform(-6, 14, (300, 2)), np.mgrid[-2:10, -2:8].reshape(2, -1).T / 2]
    )
    found = [field.padded[geometry.pixel(float(x), float(y), 9, 6)] for x, y in at]
    np.testing.assert_array_equal(found, field.at(at))
    view = geometry.view_of(field, camera_of())

    @jit.jit
    def padded_pixel(x, y, view):
        return geometry.padded_pixel(x, y, view)

    found = [field.padded[padded_pixel(float(x), float(y), view)] for x, y in at]
    np.testing.assert_array_equal(found, field.at(at))
    assert field.padded[geometry.pixel(np.nan, 2.0, 9, 6)] == field.padded[0]


def test_hypotheses_that_are_no_numbers_score_nothing(scene):
    surface, poses, field = scene
    broken = replace(poses, t=np.full_like(poses.t, np.nan))
    scores = surface.score(field, camera_of(), broken, np.arange(len(surface.patches)), occlusion=True)
    assert not scores.votes.any() and not scores.area_px.any()


def test_of_hypotheses_that_are_alike_the_best_is_kept(rng):
    poses = random_poses(rng, truck(), 30)
    poses = poses[rng.integers(0, 30, 120)]
    poses.t[::2] *= rng.uniform(0.97, 1.03, (60, 1))
    poses.t[7], score = np.nan, rng.normal(size=120)
    kept = best_distinct(poses, score, 500)
    assert 30 <= len(kept) < 100 and (np.diff(score[kept]) <= 0).all()
    assert best_distinct(poses, score, 5).tolist() == kept[:5].tolist()
    for h in set(range(120)) - set(kept.tolist()) - {7}:
        near = kept[score[kept] >= score[h]]
        place = np.abs(poses.t[near, :2] / poses.t[near, 2:] - poses.t[h, :2] / poses.t[h, 2]).max(axis=1)
        depth = np.abs(np.log(poses.t[near, 2] / poses.t[h, 2]))
        axes = np.abs((poses.R[near] - poses.R[h])[:, :, [0, 2]]).max(axis=(1, 2))
        assert ((place <= CELL_PLACE) & (depth <= CELL_LOG_DEPTH) & (axes <= CELL_AXIS)).any()


def test_a_seams_gaps_are_those_to_the_nearest_pixel_of_another_known_class():
    coarse = np.random.default_rng(4).choice([0, RED, 5, OWNED], (7, 8), p=[0.5, 0.3, 0.15, 0.05])
    labels = np.kron(coarse, np.ones((5, 5))).astype(np.uint8)
    known = np.argwhere(~np.isin(labels, (UNKNOWN, OWNED, OUTSIDE, RED)))
    expected = []
    for y, x in np.argwhere(labels == RED).tolist():
        if not (4 <= y < 31 and 4 <= x < 36) or (labels[y - 1 : y + 2, x - 1 : x + 2] == RED).all():
            continue
        off = known - (y, x)
        near = np.hypot(*off[np.abs(off).max(axis=1) <= 4].T)
        expected.append(near.min() - 1 if len(near) else np.inf)
    assert np.isinf(expected).any() and len(set(expected)) > 3
    np.testing.assert_allclose(np.sort(LabelField(labels)._gaps_px(RED)), np.sort(expected))


@pytest.mark.parametrize("size", [(1, 1), (8, 8), (9, 9), (9, 1)])
def test_small_images_and_absent_classes_have_no_seam(size):
    field = LabelField(np.full(size, RED, np.uint8))
    assert field.seam_px(RED) == field.seam_px(RED + 1) == 0.0


@pytest.mark.parametrize("turns", range(4))
def test_every_side_of_a_large_blob_tells_its_seam(turns):
    labels = np.zeros((460, 620), np.uint8)
    labels[10:450, 10:610], labels[:, :9] = RED, 5  # only one side has something known beside it
    gaps = LabelField(np.rot90(labels, turns).copy())._gaps_px(RED)
    assert np.isfinite(gaps).sum() > 5
    assert np.median(gaps[np.isfinite(gaps)]) == 1.0


def test_equations_whose_rows_begin_late_are_solved(rng):
    """Joints that move nothing in use have no part in the others' equations."""
    n = 12
    for quiet in ([], [7], [6, 7, 11], [0, 5], list(range(6, n))):
        J = rng.normal(0, 1, (30, n))
        J[:, quiet] = 0.0
        A, b = J.T @ J + np.diag(rng.uniform(0.1, 2.0, n)), rng.normal(0, 1, n)
        A[5, 5], x = A[5, 5] + 1e9, np.empty(n)
        expected = np.linalg.solve(A, b)
        refining.solve(A, b, x, np.empty(n, np.int64))
        np.testing.assert_allclose(x, expected, rtol=1e-9, atol=1e-12)


def test_a_fit_from_no_numbers_harms_no_other(scene):
    surface, poses, field = scene
    use = np.ones((len(poses), len(surface.markers)), bool)
    alone = posefit.refine(surface, field, camera_of(), poses, use, (4, 3))
    broken = replace(poses, t=np.where(np.arange(len(poses))[:, None] % 3 == 0, np.nan, poses.t))
    found = posefit.refine(surface, field, camera_of(), broken, use, (4, 3))
    good = np.arange(len(poses)) % 3 != 0
    for name in ("R", "t", "q"):
        np.testing.assert_array_equal(getattr(found, name)[good], getattr(alone, name)[good])


def test_results_are_kept_until_any_of_the_sources_changes(tmp_path):
    source, kept = tmp_path / "one.py", tmp_path / "__pycache__" / "two.f-1.py311.nbi"
    source.write_text("a = 1")
    jit.forget_stale(tmp_path)
    kept.write_text("compiled")
    jit.forget_stale(tmp_path)
    assert kept.exists()
    source.write_text("a = 2")
    jit.forget_stale(tmp_path)
    assert not kept.exists()
