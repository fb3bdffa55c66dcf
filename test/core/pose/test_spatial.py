"""Hypotheses of a spatial object: what hides what, where contours land, and what the labels say."""

import numpy as np
import pytest
from solids import (
    BENT,
    BODY,
    RATIONAL,
    RED,
    camera_of,
    chain,
    frames_of,
    jolted,
    pose,
    random_poses,
    render,
    sign,
    truck,
)

from artrec_ros.core.geometry.projection import project
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.surface import contains
from artrec_ros.core.pose import surface_model as spatial
from artrec_ros.core.pose.surface_model import Poses, SpatialModel

CAMERA = camera_of((160, 120), 150.0)


def judged(surface, labels, poses, camera=CAMERA, occlusion=True, patches=None):
    patches = np.arange(len(surface.patches)) if patches is None else patches
    return surface.score(LabelField(labels), camera, poses, patches, occlusion=occlusion)


def test_hypotheses_are_picked_and_joined():
    poses = random_poses(np.random.default_rng(0), chain(), 5)
    assert len(poses) == 5 and len(poses[[1, 3]]) == 2 and len(poses[poses.t[:, 2] < 0]) == 0
    again = Poses.concatenate([poses[[0]], poses[[1, 2]], poses[np.arange(3, 5)]])
    for name in ("R", "t", "q"):
        np.testing.assert_array_equal(getattr(again, name), getattr(poses, name))


def test_a_marker_straight_ahead_is_seen_with_cosine_one():
    surface = SpatialModel(sign(), RED)
    centre = surface.centre[0]
    at = pose()
    straight = Poses(at.R, np.array([[0, 0, 1.0]]) - centre @ at.R[0].T, at.q)
    cosine, depth = surface.in_camera(frames_of(surface, straight), np.array([0]))
    assert cosine[0, 0] == pytest.approx(1.0) and depth[0, 0] == pytest.approx(1.0)
    back = Poses(at.R @ np.diag([-1.0, -1.0, 1.0]), straight.t, at.q)
    assert surface.in_camera(frames_of(surface, back), np.array([0]))[0][0, 0] < -0.9


@pytest.mark.parametrize("lens", [(), BENT], ids=len)
def test_contours_land_on_the_projected_outline_and_normals_point_out_of_it(lens):
    camera = camera_of(distortion=lens)
    model = truck()
    surface = SpatialModel(model, RED)
    rng = np.random.default_rng(3)
    at = jolted(rng, pose(0, 0, 0.9, model=model), 5, 0.05, 0.3, 0.3)
    frames = frames_of(surface, at)
    which = np.array([0, 3, 5])
    pixels, normals = surface.project_contours(camera, frames, which)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0)
    np.testing.assert_allclose(pixels, project(camera, surface.place_contours(frames, which)))
    cosine, _ = surface.in_camera(frames, surface.markers[which])
    compared = 0
    for h in range(5):
        for k, number in enumerate(which):
            if cosine[h, k] < 0.3:
                continue
            patch = surface.patches[surface.markers[number]]
            dense = np.linspace(patch.marker.outline, np.roll(patch.marker.outline, -1, axis=0), 20, endpoint=False)
            dense = np.pad(dense.transpose(1, 0, 2).reshape(-1, 2), ((0, 0), (0, 1)))
            T = patch.marker.T_component_marker
            c = patch.component
            outline = project(camera, T.apply(dense) @ frames.R[h, c].T + frames.t[h, c])
            assert contains(outline, pixels[h, k] - 0.3 * normals[h, k]).all()
            assert not contains(outline, pixels[h, k] + 0.3 * normals[h, k]).any()
            compared += 1
    assert compared > 5


@pytest.mark.parametrize("bodies", [True, False])
def test_the_truth_gets_more_votes_than_what_is_near_it(bodies):
    model = truck(bodies)
    surface = SpatialModel(model, RED)
    truth = pose(0, 0, 0.9, 0.4, model=model, joints={"fore": 0.4, "hind": -0.3})
    labels = render(CAMERA, [(model, truth, RED)])
    rng = np.random.default_rng(4)
    off = jolted(rng, truth, 60, 0.05, 0.25, 0.3)
    far = Poses(truth.R, truth.t + (3.0, 0, 0), truth.q)
    votes = judged(surface, labels, Poses.concatenate([truth, off, far])).votes.sum(axis=1)
    assert votes[0] > 0
    assert np.mean(votes[1:-1] < votes[0]) > 0.95
    assert votes[-1] == 0  # beyond the border: nothing for, nothing against


def test_what_is_measured_of_a_marker_in_full_view():
    model = sign()
    surface = SpatialModel(model, RED)
    truth = pose(0.02, 0.01, 0.5, 0.5, 0.3)
    labels = render(CAMERA, [(model, truth, RED)])
    scores = judged(surface, labels, truth)
    assert scores.area_px[0, 0] == pytest.approx(np.count_nonzero(labels == RED), rel=0.05)
    assert scores.agree[0, 0] > 0.95
    away = Poses(truth.R @ np.diag([-1.0, -1.0, 1.0]), truth.t, truth.q)
    behind = Poses(truth.R, truth.t * (1, 1, -1), truth.q)
    for unseen in (away, behind):
        scores = judged(surface, labels, unseen)
        assert scores.votes[0, 0] == scores.area_px[0, 0] == scores.agree[0, 0] == 0


def test_a_marker_behind_another_part_is_not_judged():
    model = truck()
    surface = SpatialModel(model, RED)
    labels = np.full((120, 160), BODY, np.uint8)
    marker = next(i for i in surface.markers if surface.patches[i].marker.name == "outer_left")
    turned = pose(0, 0, 0.9, 0.0, model=model, joints={"fore": 0.3})
    assert judged(surface, labels, turned).area_px[0, marker] == 0
    for heading in np.linspace(0, 6, 13):
        at = pose(0, 0, 0.9, heading, model=model)
        shown, all_of_it = (judged(surface, labels, at, occlusion=o).area_px for o in (True, False))
        assert (shown <= all_of_it + 1e-9).all()


def twins(monkeypatch, surface, labels, camera, poses, patches, occlusion):
    out = []
    for compiled in (True, False):
        monkeypatch.setattr(spatial, "COMPILED", compiled)
        out.append(judged(surface, labels, poses, camera, occlusion, patches))
    return out


@pytest.mark.parametrize("lens", [(), BENT[:4], BENT, RATIONAL], ids=len)
@pytest.mark.parametrize("bodies", [True, False])
def test_the_compiled_kernel_says_what_numpy_says(monkeypatch, lens, bodies):
    """Without numba the kernel runs as plain Python: few hypotheses."""
    camera = camera_of((160, 120), 150.0, lens)
    model = truck(bodies)
    surface = SpatialModel(model, RED)
    truth = pose(0, 0, 0.9, 0.4, model=model, joints={"fore": 0.4})
    rng = np.random.default_rng(5)
    labels = render(camera, [(model, truth, RED)])
    labels[rng.random(labels.shape) < 0.1] = 0
    poses = Poses.concatenate([truth, jolted(rng, truth, 6, 0.05, 0.4, 0.4), random_poses(rng, model, 4)])
    some = np.flatnonzero(surface.component == 1)
    for patches in (np.arange(len(surface.patches)), some, some[:1]):
        for occlusion in (True, False):
            fast, plain = twins(monkeypatch, surface, labels, camera, poses, patches, occlusion)
            for name in ("votes", "area_px", "agree"):
                a, b = getattr(fast, name), getattr(plain, name)
                assert a.shape == (len(poses), len(patches))
                np.testing.assert_allclose(a, b, rtol=1e-4, atol=1e-3, err_msg=name)
    assert np.abs(plain.votes).max() > 0


@pytest.mark.parametrize("compiled", [True, False])
def test_no_hypotheses_give_no_scores(monkeypatch, compiled):
    monkeypatch.setattr(spatial, "COMPILED", compiled)
    surface = SpatialModel(truck(), RED)
    none = pose(model=truck())[np.zeros(0, int)]
    scores = judged(surface, np.ones((120, 160), np.uint8), none)
    assert scores.votes.shape == scores.area_px.shape == (0, len(surface.patches))
    field = LabelField(np.ones((120, 160), np.uint8))
    assert surface.search_joints(field, CAMERA, none, 0.2).q.shape == none.q.shape


def test_patches_scores_do_not_depend_on_which_others_are_asked_for():
    model = truck()
    surface = SpatialModel(model, RED)
    truth = pose(0, 0, 0.9, 0.4, model=model)
    labels = render(CAMERA, [(model, truth, RED)])
    whole = judged(surface, labels, truth)
    for some in (surface.markers, np.array([0, 4, 9]), np.flatnonzero(~surface.is_marker)):
        np.testing.assert_allclose(judged(surface, labels, truth, patches=some).votes, whole.votes[:, some])
