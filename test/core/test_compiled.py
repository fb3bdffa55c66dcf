"""Compiled twins against the numpy code that says what they compute."""

from dataclasses import replace

import numpy as np
import pytest
from solids import (
    BENT,
    BLUE,
    BODY,
    RATIONAL,
    RED,
    camera_of,
    chain,
    jolted,
    pose,
    random_poses,
    render,
    sign,
    slide,
    truck,
)

from artrec_ros.core import bank as bank_module
from artrec_ros.core import distinct, evidence, guesses, kinematics, occlusion, posefit, spatial, views, whole_object
from artrec_ros.core.bank import blob_shape
from artrec_ros.core.blobs import find_blobs
from artrec_ros.core.compiled import geometry, jit, refining
from artrec_ros.core.config import RecognizerConfig
from artrec_ros.core.datatypes import Target
from artrec_ros.core.deadline import Deadline
from artrec_ros.core.evidence import OWNED, UNKNOWN, LabelField
from artrec_ros.core.projection import project
from artrec_ros.core.spatial import Poses, SpatialModel
from artrec_ros.core.transforms import wrap_angle
from artrec_ros.core.whole_object import WholeObjectFinder

LENSES = pytest.mark.parametrize("lens", [(), BENT[:4], BENT, RATIONAL], ids=len)
pytestmark = pytest.mark.skipif(not jit.COMPILED, reason="numba is not installed")


@pytest.fixture
def scene(rng):
    """A truck's surface, poses of it in view, and a label image that has something to say on them."""
    return scene_of(truck(), rng)


@pytest.fixture(params=[truck, chain, sign, slide])
def any_scene(request, rng):
    """The same of objects with every kind of joint, and with none."""
    return scene_of(request.param(), rng)


def scene_of(model, rng):
    coarse = np.random.default_rng(4).choice([0, RED, 5, 1], (24, 32), p=[0.2, 0.4, 0.3, 0.1])
    labels = np.kron(coarse, np.ones((10, 10))).astype(np.uint8)
    return SpatialModel(model, RED), random_poses(rng, model, 12), LabelField(labels)


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def plainly(monkeypatch, *modules):
    """From here on numpy does the work of these modules."""
    for module in modules:
        monkeypatch.setattr(module, "COMPILED", False)


@LENSES
def test_points_project_alike(lens):
    camera = camera_of(distortion=lens)
    view = geometry.view_of(LabelField(np.zeros((240, 320), np.uint8)), camera)
    X = np.random.default_rng(0).normal((0, 0, 1), 1.0, (200, 3))  # some beside and behind the camera
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


@pytest.mark.parametrize("occlusion", [False, True])
@LENSES
def test_patches_score_alike(scene, lens, occlusion, monkeypatch):
    surface, poses, field = scene
    camera = camera_of(distortion=lens)
    patches = np.arange(len(surface.patches))
    compiled = surface.score(field, camera, poses, patches, occlusion=occlusion)
    plainly(monkeypatch, spatial)
    plain = surface.score(field, camera, poses, patches, occlusion=occlusion)
    assert np.abs(plain.votes).max() > 10
    for one, other in zip(compiled.arrays, plain.arrays, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-4, atol=1e-3)


def test_hypotheses_that_are_no_numbers_score_nothing(scene):
    surface, poses, field = scene
    broken = replace(poses, t=np.full_like(poses.t, np.nan))
    scores = surface.score(field, camera_of(), broken, np.arange(len(surface.patches)), occlusion=True)
    assert not scores.votes.any() and not scores.area_px.any()


def test_chains_place_components_alike(any_scene, monkeypatch):
    surface, poses, _ = any_scene
    kin = surface.kinematics
    compiled = kin.forward(poses.R, poses.t, poses.q)
    plainly(monkeypatch, kinematics)
    plain = kin.forward(poses.R, poses.t, poses.q)
    for name in ("R", "t", "axis", "origin"):
        np.testing.assert_allclose(getattr(compiled, name), getattr(plain, name), atol=1e-12)


def test_joints_are_found_alike(any_scene, monkeypatch):
    surface, poses, field = any_scene
    before = Poses(poses.R.copy(), poses.t.copy(), poses.q.copy())
    compiled = surface.search_joints(field, camera_of(), poses, 0.25)
    for name in ("R", "t", "q"):
        np.testing.assert_array_equal(getattr(poses, name), getattr(before, name))
    plainly(monkeypatch, spatial)
    np.testing.assert_allclose(compiled.q, surface.search_joints(field, camera_of(), poses, 0.25).q)
    assert compiled.q.shape[1] == 0 or len(np.unique(compiled.q)) > 1


@pytest.mark.parametrize("occlusion", [False, True])
def test_whole_objects_have_the_same_votes(any_scene, monkeypatch, occlusion):
    surface, poses, field = any_scene
    finder = WholeObjectFinder(Target("truck", surface.model, RED))
    compiled = finder.votes(field, camera_of(), poses, occlusion=occlusion)
    plainly(monkeypatch, spatial, whole_object)
    np.testing.assert_allclose(compiled, finder.votes(field, camera_of(), poses, occlusion=occlusion), rtol=1e-4)


def test_boxes_hide_the_same_points(scene, monkeypatch, rng):
    surface, poses, _ = scene
    frames = surface.kinematics.forward(poses.R, poses.t, poses.q)
    X = poses.t[:, None] + rng.normal(0, 0.15, (len(poses), 200, 3))
    ignored = rng.random((200, len(surface.boxes))) < 0.2
    compiled = surface.boxes.hidden(frames, X, ignored)
    plainly(monkeypatch, occlusion)
    np.testing.assert_array_equal(compiled, surface.boxes.hidden(frames, X, ignored))
    assert 0.1 < compiled.mean() < 0.9


@LENSES
def test_fits_agree(scene, lens, monkeypatch):
    surface, poses, field = scene
    camera, rng = camera_of(distortion=lens), np.random.default_rng(5)
    use = rng.random((len(poses), len(surface.markers))) < 0.7
    use[0] = False
    free = rng.random(poses.q.shape) < 0.7
    compiled = posefit.refine(surface, field, camera, poses, use, (4,), free)
    plainly(monkeypatch, posefit)
    plain = posefit.refine(surface, field, camera, poses, use, (4,), free)
    assert np.abs(plain.t - poses.t).max() > 1e-3 and np.abs(plain.q - poses.q).max() > 1e-3
    for name in ("R", "t", "q"):
        np.testing.assert_allclose(getattr(compiled, name), getattr(plain, name), atol=1e-6)
        np.testing.assert_array_equal(getattr(compiled, name)[0], getattr(poses, name)[0])


def test_sweeping_leads_the_same_way(scene, monkeypatch):
    surface, poses, field = scene
    finder, camera = WholeObjectFinder(Target("truck", surface.model, RED)), camera_of()
    votes = finder.votes(field, camera, poses, occlusion=True)
    found, best = finder._sweep(field, camera, poses, votes)
    assert (best > votes).any()
    plainly(monkeypatch, whole_object)
    plain, plain_best = finder._sweep(field, camera, poses, votes)
    np.testing.assert_allclose(best, plain_best, rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(found.q, plain.q, atol=1e-9)


@pytest.mark.parametrize("spread", [1.0, 0.012])  # the second one's steps soon are too small to go on
def test_climbing_leads_the_same_way(scene, monkeypatch, spread):
    surface, poses, field = scene
    finder, camera, clock = WholeObjectFinder(Target("truck", surface.model, RED)), camera_of(), Deadline(60.0)
    votes = finder.votes(field, camera, poses, occlusion=True)
    found, best = finder._climb(field, camera, poses, votes, 4, spread, clock)
    assert (best >= votes).all() and (best > votes).any()
    np.testing.assert_allclose(finder.votes(field, camera, found, occlusion=True), best, rtol=0.02, atol=1e-3)
    plainly(monkeypatch, whole_object)
    plain, plain_best = finder._climb(field, camera, poses, votes, 4, spread, clock)
    # a point between two pixels may round to either, and lead another way from there
    same = np.isclose(best, plain_best, rtol=1e-6, atol=1e-3)
    assert same.mean() > 0.7
    for name in ("R", "t", "q"):
        np.testing.assert_allclose(getattr(found, name)[same], getattr(plain, name)[same], atol=1e-9)


def test_alignments_with_a_blob_agree(monkeypatch):
    model = truck()
    bank = guesses.Guesser(model, SpatialModel(model, RED), 0)._banks[0]
    labels = np.zeros((120, 160), np.uint8)
    labels[30:70, 40:110] = RED
    field, camera = LabelField(labels), camera_of()
    (blob,) = find_blobs(labels, {RED}, RecognizerConfig(), ())
    shape = blob_shape(blob, 0.5)
    found = [bank.align(field, camera, shape, most) for most in (70, 10_000)]
    plainly(monkeypatch, bank_module)
    for (T, votes, view), most in zip(found, (70, 10_000), strict=True):
        T_plain, votes_plain, view_plain = bank.align(field, camera, shape, most)
        assert len(T) == 70 if most == 70 else len(T) > 70
        assert (np.diff(votes_plain) <= 0).all()
        np.testing.assert_allclose(votes, votes_plain, rtol=1e-5)
        gap = np.diff(votes_plain) > -1e-4 * votes_plain[:-1]  # the order of equal votes hangs on the last digit
        clear = ~(np.append(gap, False) | np.append(False, gap))
        clear[-1] = False  # more of its votes may have been left out
        assert clear.sum() > 5
        np.testing.assert_array_equal(view[clear], view_plain[clear])
        turned = wrap_angle(T[clear, 2] - T_plain[clear, 2])
        np.testing.assert_allclose(turned, 0.0, atol=1e-6)
        np.testing.assert_allclose(T[clear][:, [0, 1, 3]], T_plain[clear][:, [0, 1, 3]], rtol=1e-6)


@LENSES
def test_similarities_are_lifted_alike(monkeypatch, lens):
    rng, bank = np.random.default_rng(5), views.view_bank(truck().required.markers[0])
    flips = views.flips_of(np.array([v.turn for v in bank]), np.array([v.direction for v in bank]))
    low, high = (0, 0, -4, 20), (320, 240, 4, 600)
    T, camera = rng.uniform(low, high, (50, 4)), camera_of(distortion=lens)
    view, origin = rng.integers(0, len(bank), 50), np.array([0.02, -0.1, 0.05])
    found = views.lift(flips, view, T, camera, origin)
    plainly(monkeypatch, views)
    for one, other in zip(found, views.lift(flips, view, T, camera, origin), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_hypotheses_are_told_apart_alike(monkeypatch, rng):
    poses = random_poses(rng, truck(), 30)
    poses = poses[rng.integers(0, 30, 200)]
    poses.t[::2] *= rng.uniform(0.97, 1.03, (100, 1))
    poses.t[7], score = np.nan, rng.normal(size=200)
    found = [distinct.best_distinct(poses, score, n) for n in (5, 500)]
    plainly(monkeypatch, distinct)
    assert [f.tolist() for f in found] == [distinct.best_distinct(poses, score, n).tolist() for n in (5, 500)]
    assert 30 <= len(found[1]) < 150


def test_contours_fit_alike(monkeypatch, any_scene, rng):
    surface, poses, field = any_scene
    use = rng.random((len(poses), len(surface.markers))) < 0.6
    use[:, -1] |= use.shape[1] == 1
    found = posefit.contour_fit(surface, field, camera_of(distortion=BENT), poses, np.asfortranarray(use), 3)
    plainly(monkeypatch, posefit)
    plain = posefit.contour_fit(surface, field, camera_of(distortion=BENT), poses, use, 3)
    for name in ("normal", "spacing_px", "weight", "jacobian"):
        np.testing.assert_allclose(getattr(found, name), getattr(plain, name), rtol=1e-6, atol=1e-6)
    said = plain.weight > 0
    assert said.sum() > 15
    np.testing.assert_allclose(found.residual[said], plain.residual[said], atol=1e-6)


@pytest.mark.parametrize("owned", [False, True])
def test_edges_of_markers_of_two_classes_are_found_alike(monkeypatch, rng, owned):
    """With seams of widths of their own, and pixels that another object owns."""
    model = truck()
    torso, fore, hind = model.components
    surface = SpatialModel(replace(model, components=(torso, fore, replace(hind, label=BLUE))), RED)
    truth = pose(0.0, 0.0, 0.8, 0.3, model=model)
    labels = render(camera_of(), [(surface.model, truth, RED)])
    labels[labels == BODY] = UNKNOWN
    if owned:
        labels[::3, ::3] = OWNED
    field = LabelField(labels)
    field._seams.update({RED: 1.5, BLUE: 0.8})
    poses, use = jolted(rng, truth, 20, 0.005, 0.03, 0.05), np.ones((20, len(surface.markers)), bool)
    found = posefit.contour_fit(surface, field, camera_of(), poses, use, 4)
    plainly(monkeypatch, posefit)
    plain = posefit.contour_fit(surface, field, camera_of(), poses, use, 4)
    np.testing.assert_allclose(found.weight, plain.weight, atol=1e-6)
    of_class = surface.label[surface.markers]
    for label in (RED, BLUE):
        mine = plain.weight[:, of_class == label] > 0
        assert mine.sum() > 50
        pairs = (fit.residual[:, of_class == label][mine] for fit in (found, plain))
        np.testing.assert_allclose(*pairs, atol=1e-6)


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


def test_seams_are_measured_alike(scene, monkeypatch):
    _, _, field = scene
    compiled = field._gaps_px(RED)
    plainly(monkeypatch, evidence)
    plain = field._gaps_px(RED)
    assert len(plain) > 300 and np.isinf(plain).any() and len(np.unique(plain)) > 3
    np.testing.assert_array_equal(compiled, plain)


@pytest.mark.parametrize("size", [(1, 1), (8, 8), (9, 9), (9, 1)])
@pytest.mark.parametrize("compiled", [True, False])
def test_small_images_and_absent_classes_have_no_seam(monkeypatch, size, compiled):
    monkeypatch.setattr(evidence, "COMPILED", compiled)
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
