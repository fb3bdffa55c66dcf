"""Poses that least squares brings to the edges."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import DEFAULTS
from solids import (
    BENT,
    BODY,
    CAB,
    RED,
    RIGHT_SIDE,
    camera_of,
    chain,
    contour_pixels,
    facing,
    frames_of,
    jolted,
    marker,
    plate,
    pose,
    render,
    sign,
    slide,
    truck,
    turn_between,
)

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.codes import OWNED, UNKNOWN
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.pose.contour_term_kernels import ContourTerm, add_contours, leave_outwards
from artrec_ros.core.pose.edge_kernels import edge_room
from artrec_ros.core.pose.edges import edge_terms
from artrec_ros.core.pose.placed_kernels import Joints, Placed, no_equations
from artrec_ros.core.pose.pose_fit import contour_fit, fit_poses
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel

CAMERA, FIT = camera_of(), DEFAULTS.fit
REACH = (8, 6, 4, 3, 3, 2, 2)


def scene(model, truth, camera=CAMERA):
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    frame = ImageFrame(LabelField(render(camera, [(model, truth, RED)])), camera)
    everything = np.arange(len(surface.patches))
    scores = surface.score(frame, truth, everything, occlusion=True)
    return surface, frame, scores.agree[:, surface.markers] > 0.5


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
    surface, frame, use = scene(model, truth, camera)
    kin = surface.kinematics
    starts = jolted(np.random.default_rng(0), truth, 24, 0.01, 0.06, 0.04)
    starts.q[:] = np.clip(starts.q, kin.lower, kin.upper)
    fit = fit_poses(surface, frame, starts, np.tile(use, (24, 1)), REACH, FIT)
    place = np.linalg.norm(fit.t - truth.t, axis=1) / truth.t[0, 2]
    turn = np.array([turn_between(R, truth.R[0]) for R in fit.R])
    assert np.median(place) < 0.02 and np.mean(place < 0.035) > 0.7
    assert np.median(turn) < 0.08
    moved = np.linalg.norm(starts.t - truth.t, axis=1) / truth.t[0, 2]
    assert np.median(place) < 0.75 * np.median(moved)
    if kin.n_joints:
        bend = np.abs(fit.q - truth.q)
        assert np.median(bend, axis=0).max() < 0.15
    left = contour_fit(surface, frame, fit, np.tile(use, (24, 1)), 2, FIT)
    assert np.average(left.residual**2, weights=left.weight) < 0.8**2


def test_the_jacobian_is_the_residuals_derivative():
    """Where the edge itself stays put: a point's distance from it changes by its own motion along the normal."""
    model, truth = SCENES["truck"]
    surface, frame, use = scene(model, truth)
    fit, rng = contour_fit(surface, frame, truth, use, 3, DEFAULTS.fit), np.random.default_rng(0)
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
        surface, frame, use = scene(model, truth)
        kin, n = surface.kinematics, 6 + surface.kinematics.n_joints
        fit, frames = contour_fit(surface, frame, truth, use, 4, DEFAULTS.fit), frames_of(surface, truth)
        to, room = no_equations(n - 6), edge_room(surface.contour.shape[1], 4, n)
        joints = Joints(kin.lower, kin.upper, kin.unit, kin.revolute, kin.endless, kin.moves)
        placed = Placed(truth.t[0], truth.q[0], frames.R[0], frames.t[0], frames.axis[0], frames.origin[0], joints)
        edges = edge_terms(surface, frame.field, (4,), FIT)
        shown, least = surface.shown_contour(truth, use), surface.limits.least_cosine
        term = ContourTerm(surface.compiled, surface.markers, use, edges, frame.view, least, shown, np.ones(1))
        add_contours(term, 0, 0, placed, to, np.empty(n, np.int64), room)
        J, w = fit.jacobian.reshape(-1, n), fit.weight.ravel()
        assert (w > 0).sum() > 20
        np.testing.assert_allclose(np.tril(to.A), np.tril((J * w[:, None]).T @ J), rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(to.b, (J * w[:, None]).T @ fit.residual.ravel(), rtol=1e-9, atol=1e-6)
        with_offset, held = np.column_stack([J, np.ones(len(J))]), np.diag([*np.full(n, 1e-3), 3.0])
        A, b = (with_offset * w[:, None]).T @ with_offset + held, (with_offset * w[:, None]).T @ fit.residual.ravel()
        leave_outwards(3.0, to)
        left = np.tril(to.A) + np.tril(to.A, -1).T + 1e-3 * np.eye(n)
        np.testing.assert_allclose(np.linalg.solve(left, to.b), np.linalg.solve(A, b)[:n], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("n", [1, 3])
def test_what_a_fit_keeps_lies_in_one_order_in_memory(n):
    """However many hypotheses and markers: compiled code that takes it would be compiled anew for another order."""
    surface, frame, use = scene(*SCENES["truck"])
    truth = SCENES["truck"][1][np.zeros(n, int)]
    fit = contour_fit(surface, frame, truth, np.tile(use, (n, 1)), 3, FIT)
    assert 0 < fit.point.shape[1] < len(surface.markers)
    assert all(values.flags.c_contiguous for values in fit)


def test_hypotheses_left_at_the_deadline_stay():
    model, truth = SCENES["sign"]
    surface, frame, use = scene(model, truth)
    starts = jolted(np.random.default_rng(7), truth, 100, 0.01, 0.05, 0.0)
    looks = []

    class Once(Deadline):
        @property
        def expired(self):
            looks.append(True)
            return len(looks) > 1

    some = fit_poses(surface, replace(frame, deadline=Once()), starts, np.tile(use, (100, 1)), (4,), FIT)
    every = fit_poses(surface, frame, starts, np.tile(use, (100, 1)), (4,), FIT)
    fitted = (some.t != starts.t).any(axis=1)
    assert 0 < fitted.sum() < 100
    np.testing.assert_array_equal(some.t[fitted], every.t[fitted])


def test_joints_that_are_held_do_not_move():
    model, truth = SCENES["truck"]
    surface, frame, use = scene(model, truth)
    starts = jolted(np.random.default_rng(2), truth, 5, 0.01, 0.05, 0.1)
    free = np.tile([True, False], (5, 1))
    fit = fit_poses(surface, frame, starts, np.tile(use, (5, 1)), REACH, FIT, free)
    np.testing.assert_allclose(fit.q[:, 1], starts.q[:, 1], atol=1e-4)
    assert (np.abs(fit.q[:, 0] - starts.q[:, 0]) > 1e-3).any()


def test_joints_stay_within_their_limits():
    model, _ = SCENES["truck"]
    truth = pose(0, 0, 0.8, 0.3, 0, model, {"fore": 0.8, "hind": -0.8})
    surface, frame, use = scene(model, truth)
    starts = jolted(np.random.default_rng(3), truth, 10, 0.01, 0.05, 0.3)
    fit = fit_poses(surface, frame, starts, np.tile(use, (10, 1)), REACH, FIT)
    assert (np.abs(fit.q) <= 0.8 + 1e-9).all()


def test_an_unseen_joint_stays_determined():
    model, truth = SCENES["truck"]
    surface, frame, use = scene(model, truth)
    torso = use & (surface.component[surface.markers] == 0)
    fit = fit_poses(surface, frame, truth, torso, REACH, FIT)
    assert np.isfinite(fit.q).all()
    assert np.linalg.norm(fit.t - truth.t) < 0.03


def test_without_markers_in_use_nothing_moves():
    model, truth = SCENES["truck"]
    surface, frame, use = scene(model, truth)
    fit = fit_poses(surface, frame, truth, np.zeros_like(use), REACH, FIT)
    np.testing.assert_array_equal(fit.t, truth.t)


def test_one_hypothesis_does_not_depend_on_the_others():
    model, truth = SCENES["truck"]
    surface, frame, use = scene(model, truth)
    starts = jolted(np.random.default_rng(4), truth, 4, 0.01, 0.05, 0.05)
    together = fit_poses(surface, frame, starts, np.tile(use, (4, 1)), (4, 3), FIT)
    for h in range(4):
        alone = fit_poses(surface, frame, starts[[h]], use, (4, 3), FIT)
        np.testing.assert_allclose(alone.t[0], together.t[h], atol=1e-9)
        np.testing.assert_allclose(alone.R[0], together.R[h], atol=1e-9)


@pytest.mark.parametrize("value", [UNKNOWN, BODY, RED, OWNED])
def test_plain_images_leave_poses_finite_and_near(value):
    model, truth = SCENES["truck"]
    surface, _, use = scene(model, truth)
    frame = ImageFrame(LabelField(np.full((240, 320), value, np.uint8)), CAMERA)
    fit = fit_poses(surface, frame, truth, use, REACH, FIT)
    assert np.isfinite(fit.t).all() and np.isfinite(fit.R).all()
    np.testing.assert_allclose(fit.t, truth.t, atol=1e-9)


def test_noise_and_poses_behind_the_camera_stay_finite():
    model, truth = SCENES["truck"]
    surface, _, use = scene(model, truth)
    labels = np.random.default_rng(5).integers(0, 8, (240, 320), np.uint8)
    frame = ImageFrame(LabelField(labels), CAMERA)
    starts = jolted(np.random.default_rng(6), truth, 8, 0.3, 1.0, 0.5)
    starts.t[0, 2], starts.t[1, 2] = -0.5, 0.0
    fit = fit_poses(surface, frame, starts, np.tile(np.ones_like(use), (8, 1)), REACH, FIT)
    assert np.isfinite(fit.t).all() and np.isfinite(fit.q).all()
    np.testing.assert_allclose(fit.R @ fit.R.transpose(0, 2, 1), np.tile(np.eye(3), (8, 1, 1)), atol=1e-6)


def visor():
    """A plate whose upper edge a peak of its own hides from above, and whose rear edge a fin does from ahead."""
    peak = Box(Pose.from_xyz_rpy((0, -0.03, 0.045)), np.array([0.24, 0.06, 0.01]))
    fin = Box(Pose.from_xyz_rpy((-0.105, -0.03, 0)), np.array([0.01, 0.06, 0.1]))
    plate = marker("face", CAB, RIGHT_SIDE, (0, -0.001, 0))
    return ObjectModel("visor", (Component("plate", (plate,), True, None, None, (peak, fin), BODY),))


def test_what_is_shown_of_a_contour_is_what_the_image_shows():
    """A little inside of a shown point there is the marker; a little inside of a hidden one there is not."""
    model = visor()
    surface, rng = SpatialModel(model, RED, DEFAULTS.votes), np.random.default_rng(0)
    seen: dict[bool, list[bool]] = {True: [], False: []}
    for _ in range(12):
        truth = pose(*rng.uniform(-0.1, 0.1, 2), 0.9, rng.uniform(-0.7, 0.7), 0, model)
        truth = replace(truth, R=rotation_from_rotvec([rng.uniform(-0.1, 0.6), 0, 0]) @ truth.R)
        labels, use = render(CAMERA, [(model, truth, RED)]), np.ones((1, len(surface.markers)), bool)
        fit = contour_fit(surface, ImageFrame(LabelField(labels), CAMERA), truth, use, 3, FIT)
        towards = np.rint(contour_pixels(surface, CAMERA, truth) - 1.5 * fit.normal)[0].astype(int)
        frames = frames_of(surface, truth)
        shown, towards_camera = surface.shown_contour(truth, use)[0], facing(surface, frames, surface.markers)[0] > 0.3
        for k in np.flatnonzero(towards_camera):
            for i in range(towards.shape[1]):
                seen[bool(shown[k, i])].append(bool(labels[towards[k, i, 1], towards[k, i, 0]] == RED))
    assert len(seen[False]) > 50
    assert np.mean(seen[True]) > 0.9 and np.mean(seen[False]) < 0.25


def test_what_the_object_hides_of_its_own_contours_does_not_pull():
    """The edge beside a hidden point is that of what hides it, and lies inwards."""
    model, rng = visor(), np.random.default_rng(1)
    off: dict[bool, list[float]] = {True: [], False: []}
    for _ in range(25):
        truth = pose(*rng.uniform(-0.1, 0.1, 2), rng.uniform(0.9, 1.3), rng.uniform(0.2, 0.5), 0, model)
        truth = replace(truth, R=rotation_from_rotvec([rng.uniform(0.1, 0.2), 0, 0]) @ truth.R)
        surface, frame, _ = scene(model, truth)
        use, start = np.ones((1, 1), bool), jolted(rng, truth, 1, 0.003, 0.03, 0.0)
        for last in off:
            fit = fit_poses(surface, frame, start, use, (4, 3, 3, 2, 2), FIT, last=last)
            off[last].append(float(np.linalg.norm(fit.t - truth.t)))
    assert np.median(off[True]) < 0.8 * np.median(off[False])


@pytest.mark.parametrize(("name", "wider_px"), [("truck", 1), ("slide", 1), ("chain", 1), ("truck", -1), ("slide", -1)])
def test_labels_a_pixel_off_all_around_hardly_change_the_last_fit(name, wider_px):
    """How far apart several markers are tells the range, too."""
    model, truth = SCENES[name]
    surface, frame, use = scene(model, truth)
    labels, more = frame.field.labels, np.ones((3, 3), np.uint8)
    if wider_px < 0:  # what they leave is unknown
        labels = np.where(cv2.erode(labels, more) == cv2.dilate(labels, more), labels, UNKNOWN)
    else:
        marked = cv2.dilate(np.where(labels == RED, RED, 0).astype(np.uint8), more)
        labels = np.where(marked == RED, RED, labels)
    frame = replace(frame, field=LabelField(labels.astype(np.uint8)))
    fits = [fit_poses(surface, frame, truth, use, REACH, FIT, last=last) for last in (False, True)]
    off = [abs(float(np.linalg.norm(fit.t) / np.linalg.norm(truth.t)) - 1) for fit in fits]
    assert off[1] < 0.3 * off[0] + 0.003, off


def test_of_one_compact_marker_alone_its_size_tells_the_range():
    model = plate()
    truth = pose(0.02, 0, 0.7, 0.5, 0, model)
    surface, frame, use = scene(model, truth)
    plain, last = (fit_poses(surface, frame, truth, use, REACH, FIT, last=how) for how in (False, True))
    np.testing.assert_array_equal(plain.t, last.t)
