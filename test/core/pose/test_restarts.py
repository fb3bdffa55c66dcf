"""Fits begun elsewhere: back at the same rest where the image tells a pose, apart where it does not."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, jolted, pose, render, sign, slide, truck

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.pose.covariance import deviations_without_image, sources
from artrec_ros.core.pose.pose_fit import fit_poses
from artrec_ros.core.pose.restarts import scatter
from artrec_ros.core.pose.surface_model import SpatialModel

CAMERA = camera_of()
MODELS = {"truck": truck(), "sign": sign(), "slide": slide()}


def found(name, truth, use=None):
    """Scatter, first covariance and deviations without image of a fit that begun near the truth."""
    surface = SpatialModel(MODELS[name], RED, DEFAULTS.votes)
    frame = ImageFrame(LabelField(render(CAMERA, [(MODELS[name], truth, RED)])), CAMERA)
    scores = surface.score(frame, truth, surface.markers, occlusion=True)
    use = scores.agree > 0.5 if use is None else use(surface)
    start = jolted(np.random.default_rng(0), truth, 1, 0.003, 0.03, 0.0)
    fit = fit_poses(surface, frame, start, use, (4, 3, 3, 2, 2), DEFAULTS.fit, last=True)
    known = deviations_without_image(surface, fit, DEFAULTS)
    first = sources(surface, frame, fit, use, known, DEFAULTS).covariance(DEFAULTS.covariance)
    return surface, frame, fit, use, first, known


@pytest.mark.parametrize("name", sorted(MODELS))
def test_where_the_image_tells_a_pose_all_come_back(name):
    *args, first, known = found(name, pose(0.0, 0.0, 0.55, 0.7, 0.2, MODELS[name]))
    again = scatter(*args, first, known, DEFAULTS)[0]
    assert again.shape == first[0].shape and np.linalg.eigvalsh(again).min() > -1e-12
    np.testing.assert_allclose(again, again.T, atol=1e-15)
    assert np.trace(again[:6, :6] / np.outer(known[0, :6], known[0, :6])) < 0.005


def test_tilts_of_a_small_marker_that_looks_to_the_camera_do_not():
    small, large = (found("sign", pose(0.0, 0.0, z, 0.15, 0.1)) for z in (3.5, 0.5))
    apart, together = (
        np.sqrt(np.trace(scatter(*args, first, known, DEFAULTS)[0, 3:6, 3:6])) for *args, first, known in (small, large)
    )
    assert apart > np.radians(4) and apart > 2 * together


@pytest.mark.parametrize("name", sorted(MODELS))
def test_there_is_none_where_no_marker_is_in_use(name):
    *args, first, known = found(
        name, pose(0.0, 0.0, 0.8, 0.4, 0.1, MODELS[name]), lambda s: np.zeros((1, len(s.markers)), bool)
    )
    np.testing.assert_allclose(scatter(*args, first, known, DEFAULTS), 0.0, atol=1e-12)


def test_what_faces_the_camera_keeps_its_tilt():
    *args, first, known = found("sign", pose(0.0, 0.0, 1.5, 0.0, 0.3))
    again = scatter(*args, first, known, DEFAULTS, facing=True)[0]
    np.testing.assert_allclose(again[3:5], 0.0, atol=1e-9)
    assert again[2, 2] > 0
