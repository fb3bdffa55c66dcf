"""The pinhole camera with lens distortion, batched."""

from __future__ import annotations

import cv2
import numpy as np

from .camera import Camera
from .pixel_kernels import MIN_DEPTH_M, pinhole
from .transforms import Array

_STRAIGHT = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)  # steps at most; pixels


def project(camera: Camera, X: Array) -> Array:
    """Pixels (..., 2) of points (..., 3) in the camera's optical frame (z forward, metres)."""
    if camera.straight is not None:
        focal, centre = camera.straight
        pixels: Array = X[..., :2] / np.maximum(X[..., 2:], MIN_DEPTH_M)
        pixels *= focal
        pixels += centre
        return pixels
    pixels = np.empty((*X.shape[:-1], 2))
    lens = camera.matrix, camera.rational, camera.bent, camera.fold
    pixels[..., 0], pixels[..., 1] = pinhole(X[..., 0], X[..., 1], X[..., 2], *lens)
    return pixels


def projection_jacobian(camera: Camera, X: Array) -> Array:
    """(..., 2, 3) derivative of the undistorted pixel by the point; distortion only bends the step."""
    z = np.maximum(X[..., 2], MIN_DEPTH_M)
    fx, fy = camera.matrix[0, 0], camera.matrix[1, 1]
    J = np.zeros((*X.shape[:-1], 2, 3))
    J[..., 0, 0], J[..., 1, 1] = fx / z, fy / z
    J[..., 0, 2], J[..., 1, 2] = -fx * X[..., 0] / z**2, -fy * X[..., 1] / z**2
    return J


def normalise(camera: Camera, pixels: Array) -> Array:
    """(n, 2) undistorted normalised coordinates (x/z, y/z) of (n, 2) pixels."""
    if not len(pixels):
        return np.zeros((0, 2))
    points = np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2)
    matrix = camera.matrix.copy()
    if camera.bent:  # by its default OpenCV stops after five steps, a pixel off in the corners of a wide lens
        points = cv2.undistortImagePoints(points, matrix, camera.distortion, None, _STRAIGHT)
    return cv2.undistortPoints(points, matrix, None).reshape(-1, 2)
