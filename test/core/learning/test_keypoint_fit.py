"""Joints from a few annotated points."""

import numpy as np
import pytest
from solids import SIDE_ON, camera_of, truck

from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import rotation_from_rotvec
from artrec_ros.core.learning.keypoint_fit import Points, fit_points
from artrec_ros.core.model.kinematics import Kinematics

MODEL = truck()
KIN = Kinematics(MODEL)


def scene(seed, noise_px=0.0):
    """The ends of the axes of all markers that face the camera, and the joints' true positions."""
    rng = np.random.default_rng(seed)
    R = (rotation_from_rotvec([0, rng.uniform(-0.8, 0.2), 0]) @ SIDE_ON)[None]
    t = np.array([[rng.uniform(-0.05, 0.05), 0.0, rng.uniform(0.6, 0.9)]])
    q = rng.uniform(0.7 * KIN.lower, 0.7 * KIN.upper)[None]
    frames = KIN.forward(R, t, q)
    rows = []
    for c, component in enumerate(MODEL.components):
        for marker in component.markers:
            T = marker.T_component_marker
            normal = frames.R[0, c] @ T.rotation[:, 2]
            centre = frames.R[0, c] @ T.position + frames.t[0, c]
            if normal @ centre < -0.2 * np.linalg.norm(centre):
                ends = T.apply(np.column_stack([np.stack([marker.tail, marker.head]), np.zeros(2)]))
                rows += [(c, end, T.rotation[:, 2]) for end in ends]
    component = np.array([r[0] for r in rows])
    place = np.array([r[1] for r in rows])
    X = np.einsum("nij,nj->ni", frames.R[0, component], place) + frames.t[0, component]
    pixel = project(camera_of(), X) + rng.normal(0, noise_px, (len(rows), 2))
    return Points(component, place, np.array([r[2] for r in rows]), pixel), R[0], t[0], q[0]


@pytest.mark.parametrize("seed", range(6))
def test_exact_points_give_back_the_pose_and_the_joints_that_they_tell(seed):
    points, R, t, q = scene(seed)
    fit = fit_points(KIN, camera_of(), points)
    assert fit.rms_px < 0.01
    np.testing.assert_allclose(fit.R, R, atol=2e-3)
    np.testing.assert_allclose(fit.t, t, atol=2e-3)
    told = fit.q_noise < 0.2
    assert told.any()
    np.testing.assert_allclose(fit.q[told], q[told], atol=3e-3)


def test_noise_is_told_in_proportion():
    errors, told = [], []
    for seed in range(12):
        points, _, _, q = scene(seed, noise_px=0.5)
        fit = fit_points(KIN, camera_of(), points)
        seen = fit.q_noise < 0.25
        errors += list(np.abs(fit.q - q)[seen])
        told += list(fit.q_noise[seen])
    assert np.median(errors) < 0.08
    assert 0.2 < np.median(errors) / np.median(told) < 2.0


def test_joints_that_no_point_tells_are_unknown():
    points, *_ = scene(0)
    root = points.component == 0
    alone = Points(points.component[root], points.place[root], points.normal[root], points.pixel[root])
    fit = fit_points(KIN, camera_of(), alone)
    assert fit is None or (fit.q_noise > 1.0).all() or KIN.n_joints == 0


def test_too_few_points_fit_nothing():
    points, *_ = scene(0)
    few = Points(points.component[:3], points.place[:3], points.normal[:3], points.pixel[:3])
    assert fit_points(KIN, camera_of(), few) is None


@pytest.mark.parametrize("span", [0.0, 0.05])
def test_points_in_one_place_or_on_one_line_do_no_harm(span):
    line = np.linspace(0, 1, 5)[:, None] * (span, 0, 0)
    normal, pixel = np.tile([0.0, -1.0, 0.0], (5, 1)), 100.0 + 1e3 * line[:, :2]
    points = Points(np.zeros(5, int), line, normal, pixel)
    fit = fit_points(KIN, camera_of(), points)
    assert fit is None or np.isfinite(fit.R).all() and np.isfinite(fit.rms_px)
