"""The pinhole camera with lens distortion, batched."""

from __future__ import annotations

import cv2
import numpy as np

from .camera import Camera
from .transforms import Array

MIN_DEPTH_M = 1e-3  # nearer points are pushed to this depth: their pixels land far outside the image


def project(camera: Camera, X: Array) -> Array:
    """Pixels (..., 2) of points (..., 3) in the camera's optical frame (z forward, metres)."""
    z = np.maximum(X[..., 2], MIN_DEPTH_M)
    x, y = X[..., 0] / z, X[..., 1] / z
    if camera.bent:
        x, y = _distort(camera, x, y)
    K = camera.matrix
    return np.stack([K[0, 0] * x + K[0, 1] * y + K[0, 2], K[1, 1] * y + K[1, 2]], axis=-1)


def _distort(camera: Camera, x: Array, y: Array) -> tuple[Array, Array]:
    """OpenCV's rational model on normalised coordinates (plumb_bob is its first five coefficients)."""
    k1, k2, p1, p2, k3, k4, k5, k6 = camera.rational
    r2 = np.minimum(x * x + y * y, camera.fold)
    radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    return (
        x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
    )


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
    distortion = camera.distortion if camera.bent else None
    return cv2.undistortPoints(points, camera.matrix.copy(), distortion).reshape(-1, 2)
