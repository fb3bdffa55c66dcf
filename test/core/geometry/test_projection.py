"""The camera against OpenCV's, its inverse and finite differences."""

import cv2
import numpy as np
import pytest
from solids import BENT, RATIONAL, camera_of

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import MIN_DEPTH_M, normalise, project, projection_jacobian

LENSES = [(), BENT[:4], BENT, RATIONAL]


def points_in_view(n=200, seed=0):
    rng = np.random.default_rng(seed)
    z = rng.uniform(0.3, 5.0, n)
    return np.column_stack([rng.uniform(-0.55, 0.55, n) * z, rng.uniform(-0.4, 0.4, n) * z, z])


@pytest.mark.parametrize("lens", LENSES, ids=len)
def test_pixels_are_opencvs(lens):
    camera, X = camera_of(distortion=lens), points_in_view()
    theirs = cv2.projectPoints(X, np.zeros(3), np.zeros(3), camera.matrix.copy(), np.array(lens) if lens else None)[0]
    np.testing.assert_allclose(project(camera, X), theirs[:, 0], atol=1e-6)


@pytest.mark.parametrize("lens", LENSES, ids=len)
def test_normalised_coordinates_lead_back_to_the_points(lens):
    camera, X = camera_of(distortion=lens), points_in_view()
    rays = normalise(camera, project(camera, X))
    np.testing.assert_allclose(rays, X[:, :2] / X[:, 2:], atol=1e-9)


def test_any_batch_shape_and_none_at_all():
    camera, X = camera_of(distortion=BENT), points_in_view(24)
    flat = project(camera, X)
    np.testing.assert_array_equal(project(camera, X.reshape(2, 3, 4, 3)), flat.reshape(2, 3, 4, 2))
    assert project(camera, np.zeros((0, 3))).shape == (0, 2)
    assert normalise(camera, np.zeros((0, 2))).shape == (0, 2)
    assert projection_jacobian(camera, np.zeros((0, 5, 3))).shape == (0, 5, 2, 3)


def test_skew_counts():
    camera = Camera(np.array([[300, 7.0, 160], [0, 310, 120], [0, 0, 1]]), np.zeros(0), (320, 240))
    X = points_in_view(5)
    homogeneous = X @ camera.matrix.T
    np.testing.assert_allclose(project(camera, X), homogeneous[:, :2] / homogeneous[:, 2:])


def test_the_derivative_is_that_of_the_undistorted_pixel():
    camera, X = camera_of(), points_in_view(50)
    step = 1e-6
    numeric = np.stack(
        [(project(camera, X + step * e) - project(camera, X - step * e)) / (2 * step) for e in np.eye(3)], axis=-1
    )
    np.testing.assert_allclose(projection_jacobian(camera, X), numeric, rtol=1e-6, atol=1e-4)
    np.testing.assert_array_equal(projection_jacobian(camera_of(distortion=BENT), X), projection_jacobian(camera, X))


@pytest.mark.parametrize("lens", LENSES, ids=len)
def test_points_beside_and_behind_the_camera_stay_finite(lens):
    camera = camera_of(distortion=lens)
    X = np.array([[0.2, 0.1, 0.0], [0.2, 0.1, -1.0], [0.0, 0.0, -2.0], [1e-9, 0, MIN_DEPTH_M / 2]])
    assert np.isfinite(project(camera, X)).all()
    assert np.isfinite(projection_jacobian(camera, X)).all()


def test_a_point_beside_a_plain_camera_lands_outside_the_image():
    x, y = project(camera_of(), np.array([0.5, 0.0, 0.0]))
    assert x > 10000 and abs(y) < 240


@pytest.mark.parametrize("k4", [-4.0, -1.0, -0.3, -0.15])
def test_behind_a_pole_of_the_lens_nothing_is_seen(k4):
    """Where the model divides by nothing, which no lens does, pixels would be infinite."""
    camera = camera_of(distortion=[0, 0, 0, 0, 0, k4, 0, 0])
    assert 0 < camera.fold < -1 / k4
    r = np.linspace(0, 3, 2001)
    pixels = project(camera, np.column_stack([r, np.zeros(2001), np.ones(2001)]))
    assert np.isfinite(pixels).all() and (np.diff(pixels[:, 0]) > 0).all()
