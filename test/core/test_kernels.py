"""Pieces of the compiled twin against the numpy code that says what they compute."""

import builtins
import importlib.util

import numpy as np
import pytest
from solids import BENT, RATIONAL, RED, camera_of, random_poses, truck

from artrec_ros.core import kernels
from artrec_ros.core.evidence import LabelField
from artrec_ros.core.projection import project
from artrec_ros.core.spatial import SURFACE, SpatialModel


def distortion_of(camera):
    return np.pad(camera.distortion, (0, 8 - len(camera.distortion)))


@pytest.mark.parametrize("lens", [(), BENT[:4], BENT, RATIONAL], ids=len)
def test_points_project_alike(lens):
    camera = camera_of(distortion=lens)
    X = np.random.default_rng(0).normal((0, 0, 1), 1.0, (200, 3))  # some beside and behind the camera
    found = [kernels._project(*x, camera.matrix, distortion_of(camera), bool(lens)) for x in X]
    np.testing.assert_allclose(found, project(camera, X), rtol=1e-9, atol=1e-6)


def test_pixels_are_looked_up_alike():
    labels = np.random.default_rng(1).integers(0, 9, (6, 9), np.uint8)
    field = LabelField(labels)
    at = np.concatenate(
        [np.random.default_rng(2).uniform(-6, 14, (300, 2)), np.mgrid[-2:10, -2:8].reshape(2, -1).T / 2]
    )
    found = [field.padded[kernels._pixel(float(x), float(y), 9, 6)] for x, y in at]
    np.testing.assert_array_equal(found, field.at(at))


def test_points_are_hidden_alike():
    model = truck()
    surface = SpatialModel(model, RED)
    rng = np.random.default_rng(3)
    poses = random_poses(rng, model, 3)
    frames = surface.kinematics.forward(poses.R, poses.t, poses.q)
    X = poses.t[:, None] + rng.normal(0, 0.2, (3, 60, 3))
    box_R, eye = surface._boxes_in_camera(frames)
    found = [
        [kernels._is_hidden(*x, box_R[h], eye[h], surface._half, SURFACE) for x in X[h]] for h in range(len(poses))
    ]
    expected = surface.hidden(frames, X)
    assert 0 < expected.mean() < 1
    np.testing.assert_array_equal(found, expected)


def test_scores_start_as_arrays_of_their_own():
    votes, area, agree = kernels.empty_scores(2, 3)
    assert votes.shape == area.shape == agree.shape == (2, 3)
    assert not np.shares_memory(votes, area) and not np.shares_memory(area, agree)


def test_without_numba_the_functions_are_plain_python(monkeypatch):
    real = builtins.__import__

    def refuse(name, *args, **options):
        if name == "numba":
            raise ImportError(name)
        return real(name, *args, **options)

    spec = importlib.util.spec_from_file_location("artrec_ros.core.kernels_without_numba", kernels.__file__)
    plain = importlib.util.module_from_spec(spec)
    monkeypatch.setattr(builtins, "__import__", refuse)
    spec.loader.exec_module(plain)
    assert plain.COMPILED is False
    assert plain._pixel(2.2, 0.9, 5, 4) == kernels._pixel(2.2, 0.9, 5, 4)
