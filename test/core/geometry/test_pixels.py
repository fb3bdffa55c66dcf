"""Where points land in the image and which pixel that is, as compiled code works it out."""

import cv2
import numba
import numpy as np
import pytest
from solids import BENT, RATIONAL, camera_of

from artrec_ros.core.geometry import pixel_kernels as geometry
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField

LENSES = pytest.mark.parametrize("lens", [(), BENT[:4], BENT, RATIONAL], ids=len)
pytestmark = pytest.mark.uncompiled


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def blank_view(camera):
    return ImageFrame(LabelField(np.zeros((240, 320), np.uint8)), camera).view


@LENSES
def test_points_land_where_opencv_puts_them(lens, rng):
    camera = camera_of(distortion=lens)
    view = blank_view(camera)
    X = np.column_stack([rng.uniform(-0.5, 0.5, (100, 2)), np.ones(100)]) * rng.uniform(0.3, 3.0, (100, 1))
    expected = cv2.projectPoints(X, np.zeros(3), np.zeros(3), camera.matrix, np.array(lens, float))[0][:, 0]
    np.testing.assert_allclose([geometry.project(*x, view) for x in X], expected, atol=1e-8)
    np.testing.assert_allclose(project(camera, X), expected, atol=1e-8)


@LENSES
def test_points_beside_and_behind_the_camera_project_alike(lens):
    camera = camera_of(distortion=lens)
    view = blank_view(camera)
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
    view = ImageFrame(field, camera_of()).view

    @numba.njit  # not kept on disk: nothing there would notice that the kernels have changed
    def padded_pixel(x, y, view):
        return geometry.padded_pixel(x, y, view)

    found = [field.padded[padded_pixel(float(x), float(y), view)] for x, y in at]
    np.testing.assert_array_equal(found, field.at(at))
    assert field.padded[geometry.pixel(np.nan, 2.0, 9, 6)] == field.padded[0]
