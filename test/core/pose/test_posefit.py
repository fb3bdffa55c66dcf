"""Edges along normals, and poses that least squares brings to them."""

import numpy as np
import pytest
from solids import (
    BACKGROUND,
    BENT,
    BODY,
    RED,
    camera_of,
    chain,
    contour_pixels,
    frames_of,
    jolted,
    pose,
    render,
    sign,
    slide,
    truck,
    turn_between,
)

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.transforms import rotation_from_rotvec
from artrec_ros.core.image.image_frame import view_of
from artrec_ros.core.image.label_field import OWNED, UNKNOWN, LabelField
from artrec_ros.core.pose.edge_kernels import edge_room, find_edges
from artrec_ros.core.pose.edges import edge_terms
from artrec_ros.core.pose.fit_kernels import Motion, normal_equations
from artrec_ros.core.pose.pose_fit import contour_fit, refine
from artrec_ros.core.pose.surface_model import LEAST_COSINE, Poses, SpatialModel

CAMERA = camera_of()
REACH = (8, 6, 4, 3, 3, 2, 2)
HEIGHT, WIDTH = 40, 60


def half_plane(edge, seam=0, outer=BACKGROUND):
    """RED left of x = edge - seam / 2, `outer` right of edge + seam / 2, unknown between; all at pixels' borders."""
    x = np.tile(np.arange(WIDTH), (HEIGHT, 1))
    return np.select([x < edge - seam / 2, x < edge + seam / 2], [RED, UNKNOWN], outer).astype(np.uint8)


def edges(labels, points, normal, reach=5, label=RED):
    """Signed distances of the edge along the normals of a contour's points, and their weights: (n,) each."""
    model, field, pixels = SpatialModel(sign(), label), LabelField(labels), np.array(points, float)
    room = edge_room(len(pixels), reach, 6)
    room.outline[:2], room.outline[2:] = pixels.T, np.broadcast_to(np.array(normal, float), pixels.shape).T
    find_edges(0, edge_terms(model, field, (reach,)), 0, view_of(field, CAMERA), room)
    return room.edge, room.weight


@pytest.mark.parametrize("reach", [5, 8])
@pytest.mark.parametrize("seam", [0, 2, 4])
def test_an_edge_is_where_the_class_ends_or_amid_a_seam(seam, reach):
    """Pixel 30 is the first beyond the edge, or as far to the right of the seam's middle: 29.5."""
    offset = np.random.default_rng(0).uniform(-1, 1, 400)  # a contour's points fall anywhere between pixels
    found, weight = edges(half_plane(30, seam), np.column_stack([29.5 - offset, np.full(400, 20)]), (1, 0), reach)
    assert (weight > 0).all()
    assert (found - offset).mean() == pytest.approx(0, abs=0.05 + 0.12 * seam)
    assert np.abs(found - offset).max() < 0.6 + 0.25 * seam


@pytest.mark.parametrize("offset", [-2.0, -0.7, 0.0, 1.3, 2.0])
def test_edges_are_found_along_any_normal(offset):
    y, x = np.mgrid[:200, :200]
    labels = np.where(np.hypot(x - 100.2, y - 99.7) < 60, RED, BACKGROUND).astype(np.uint8)
    angle = np.linspace(0, 2 * np.pi, 500, endpoint=False)
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    found, weight = edges(labels, (100.2, 99.7) + (60 + offset) * normal, normal)
    assert (weight > 0).all()
    assert found.mean() == pytest.approx(-offset, abs=0.15)
    assert np.abs(found + offset).max() < 1.3


def test_an_edge_seen_the_wrong_way_round_is_none():
    _, weight = edges(half_plane(30), [(30, 20), (29, 20)], (-1, 0))
    assert not weight.any()


def test_where_no_edge_is_in_reach_there_is_no_say():
    _, weight = edges(half_plane(30), [(15, 20), (45, 20), (22, 20), (37, 20), (-300, 20), (900, 900)], (1, 0))
    assert not weight.any()
    _, weight = edges(half_plane(30), [(29, 20)], (1, 0), label=7)
    assert not weight.any()


def test_a_speck_does_not_move_an_edge_far():
    labels = half_plane(30)
    labels[20, 26] = BACKGROUND
    labels[20, 32] = UNKNOWN
    found, weight = edges(labels, [(29, 20), (30, 20)], (1, 0))
    np.testing.assert_allclose(found, [0.5, -0.5], atol=0.6)
    assert weight.all()


def test_half_the_usual_seam_is_added_where_only_unknown_follows():
    """Elsewhere in the same image the class is followed by another one across a seam."""
    labels = half_plane(30, 2)
    labels[:10, 29:] = UNKNOWN  # red ends at 28.5, nothing known follows
    assert LabelField(labels).seam_px(RED) == pytest.approx(1, abs=0.2)
    found, _ = edges(labels, [(29, 5)], (1, 0))
    assert found[0] == pytest.approx(0.5, abs=0.4)
    alone, _ = edges(half_plane(29, 0, UNKNOWN), [(29, 5)], (1, 0))
    assert alone[0] == pytest.approx(-0.5, abs=0.4)


def scene(model, truth, camera=CAMERA):
    surface = SpatialModel(model, RED)
    field = LabelField(render(camera, [(model, truth, RED)]))
    everything = np.arange(len(surface.patches))
    scores = surface.score(field, camera, truth, everything, occlusion=True)
    return surface, field, scores.agree[:, surface.markers] > 0.5


SCENES = {
    "sign": (sign(), pose(0.02, 0, 0.7, 0.5, 0.2)),
    "truck": (truck(), pose(0, 0, 0.8, 0.4, 0.1, truck(), {"fore": 0.4, "hind": -0.3})),
    "bare truck": (truck(bodies=False), pose(0, 0, 0.8, -0.5, 0.1, truck(), {"fore": -0.4, "hind": 0.2})),
    "slide": (slide(), pose(0.05, 0, 0.7, 0.4, 0.3, slide(), {"bar": 0.06})),
    "chain": (chain(), pose(-0.1, 0.03, 0.7, 0.2, 0, chain(), {"arm": 0.2, "rod": 0.05, "finger": 0.4})),
}
each_scene = pytest.mark.parametrize("name", SCENES)


@each_scene
@pytest.mark.parametrize("lens", [(), BENT], ids=len)
def test_neighbours_come_to_the_truth(name, lens):
    model, truth = SCENES[name]
    camera = camera_of(distortion=lens)
    surface, field, use = scene(model, truth, camera)
    kin = surface.kinematics
    starts = jolted(np.random.default_rng(0), truth, 24, 0.01, 0.06, 0.04)
    starts.q[:] = np.clip(starts.q, kin.lower, kin.upper)
    fit = refine(surface, field, camera, starts, np.tile(use, (24, 1)), REACH)
    place = np.linalg.norm(fit.t - truth.t, axis=1) / truth.t[0, 2]
    turn = np.array([turn_between(R, truth.R[0]) for R in fit.R])
    assert np.median(place) < 0.02 and np.mean(place < 0.035) > 0.7
    assert np.median(turn) < 0.08
    moved = np.linalg.norm(starts.t - truth.t, axis=1) / truth.t[0, 2]
    assert np.median(place) < 0.75 * np.median(moved)
    if kin.n_joints:
        bend = np.abs(fit.q - truth.q)
        assert np.median(bend, axis=0).max() < 0.15
    left = contour_fit(surface, field, camera, fit, np.tile(use, (24, 1)), 2)
    assert np.average(left.residual**2, weights=left.weight) < 0.8**2


def test_the_jacobian_is_the_residuals_derivative():
    """Where the edge itself stays put: a point's distance from it changes by its own motion along the normal."""
    model, truth = SCENES["truck"]
    surface, field, use = scene(model, truth)
    fit, rng = contour_fit(surface, field, CAMERA, truth, use, 3), np.random.default_rng(0)
    kin, which = surface.kinematics, np.flatnonzero(use[0])

    def pixels(x):
        R = rotation_from_rotvec(x[3:6]) @ truth.R
        return contour_pixels(surface, CAMERA, Poses(R, truth.t + x[:3], truth.q + x[6:]))[:, which]

    step = 1e-6 * rng.normal(size=6 + kin.n_joints)
    moved = np.sum((pixels(step) - pixels(-step)) / 2 * fit.normal, axis=-1)
    np.testing.assert_allclose(fit.jacobian @ step, moved, rtol=1e-3, atol=1e-8)


def test_the_normal_equations_are_sums_over_the_contours_points():
    for name in ("truck", "chain"):
        model, truth = SCENES[name]
        surface, field, use = scene(model, truth)
        kin, n = surface.kinematics, 6 + surface.kinematics.n_joints
        fit, frames = contour_fit(surface, field, CAMERA, truth, use, 4), frames_of(surface, truth)
        A, b, room = np.empty((n, n)), np.empty(n), edge_room(surface.contour.shape[1], 4, n)
        motion = Motion(truth.t[0], frames.axis[0], frames.origin[0], kin.revolute, kin.moves)
        terms, view = edge_terms(surface, field, (4,)), view_of(field, CAMERA)
        normal_equations(
            surface.compiled, surface.markers, use[0], frames.R[0], frames.t[0], motion, terms, 0, view, LEAST_COSINE,
            A, b, np.empty(n, np.int64), room,
        )  # fmt: skip
        J, w = fit.jacobian.reshape(-1, n), fit.weight.ravel()
        assert (w > 0).sum() > 20
        np.testing.assert_allclose(A, (J * w[:, None]).T @ J, rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(b, (J * w[:, None]).T @ fit.residual.ravel(), rtol=1e-9, atol=1e-6)


def test_hypotheses_left_at_the_deadline_stay():
    model, truth = SCENES["sign"]
    surface, field, use = scene(model, truth)
    starts = jolted(np.random.default_rng(7), truth, 100, 0.01, 0.05, 0.0)
    looks = []

    class Once(Deadline):
        @property
        def expired(self):
            looks.append(True)
            return len(looks) > 1

    some = refine(surface, field, CAMERA, starts, np.tile(use, (100, 1)), (4,), deadline=Once())
    every = refine(surface, field, CAMERA, starts, np.tile(use, (100, 1)), (4,))
    fitted = (some.t != starts.t).any(axis=1)
    assert 0 < fitted.sum() < 100
    np.testing.assert_array_equal(some.t[fitted], every.t[fitted])


def test_joints_that_are_held_do_not_move():
    model, truth = SCENES["truck"]
    surface, field, use = scene(model, truth)
    starts = jolted(np.random.default_rng(2), truth, 5, 0.01, 0.05, 0.1)
    free = np.tile([True, False], (5, 1))
    fit = refine(surface, field, CAMERA, starts, np.tile(use, (5, 1)), REACH, free)
    np.testing.assert_allclose(fit.q[:, 1], starts.q[:, 1], atol=1e-4)
    assert (np.abs(fit.q[:, 0] - starts.q[:, 0]) > 1e-3).any()


def test_joints_stay_within_their_limits():
    model, _ = SCENES["truck"]
    truth = pose(0, 0, 0.8, 0.3, 0, model, {"fore": 0.8, "hind": -0.8})
    surface, field, use = scene(model, truth)
    starts = jolted(np.random.default_rng(3), truth, 10, 0.01, 0.05, 0.3)
    fit = refine(surface, field, CAMERA, starts, np.tile(use, (10, 1)), REACH)
    assert (np.abs(fit.q) <= 0.8 + 1e-9).all()


def test_an_unseen_joint_stays_determined():
    model, truth = SCENES["truck"]
    surface, field, use = scene(model, truth)
    torso = use & (surface.component[surface.markers] == 0)
    fit = refine(surface, field, CAMERA, truth, torso, REACH)
    assert np.isfinite(fit.q).all()
    assert np.linalg.norm(fit.t - truth.t) < 0.03


def test_without_markers_in_use_nothing_moves():
    model, truth = SCENES["truck"]
    surface, field, use = scene(model, truth)
    fit = refine(surface, field, CAMERA, truth, np.zeros_like(use), REACH)
    np.testing.assert_array_equal(fit.t, truth.t)


def test_one_hypothesis_does_not_depend_on_the_others():
    model, truth = SCENES["truck"]
    surface, field, use = scene(model, truth)
    starts = jolted(np.random.default_rng(4), truth, 4, 0.01, 0.05, 0.05)
    together = refine(surface, field, CAMERA, starts, np.tile(use, (4, 1)), (4, 3))
    for h in range(4):
        alone = refine(surface, field, CAMERA, starts[[h]], use, (4, 3))
        np.testing.assert_allclose(alone.t[0], together.t[h], atol=1e-9)
        np.testing.assert_allclose(alone.R[0], together.R[h], atol=1e-9)


@pytest.mark.parametrize("value", [UNKNOWN, BODY, RED, OWNED])
def test_plain_images_leave_poses_finite_and_near(value):
    model, truth = SCENES["truck"]
    surface, _, use = scene(model, truth)
    field = LabelField(np.full((240, 320), value, np.uint8))
    fit = refine(surface, field, CAMERA, truth, use, REACH)
    assert np.isfinite(fit.t).all() and np.isfinite(fit.R).all()
    np.testing.assert_allclose(fit.t, truth.t, atol=1e-9)


def test_noise_and_poses_behind_the_camera_stay_finite():
    model, truth = SCENES["truck"]
    surface, _, use = scene(model, truth)
    field = LabelField(np.random.default_rng(5).integers(0, 8, (240, 320), np.uint8))
    starts = jolted(np.random.default_rng(6), truth, 8, 0.3, 1.0, 0.5)
    starts.t[0, 2], starts.t[1, 2] = -0.5, 0.0
    fit = refine(surface, field, CAMERA, starts, np.tile(np.ones_like(use), (8, 1)), REACH)
    assert np.isfinite(fit.t).all() and np.isfinite(fit.q).all()
    np.testing.assert_allclose(fit.R @ fit.R.transpose(0, 2, 1), np.tile(np.eye(3), (8, 1, 1)), atol=1e-6)
