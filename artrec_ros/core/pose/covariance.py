"""How sure a fitted pose is: the covariance of least squares whose residuals are not independent.

With residuals r = J x + e, weights W and a weak prior P, the estimate's covariance is
A^-1 (J' W cov(e) W J + P) A^-1 with A = J' W J + P. What makes up cov(e):

* each contour point by itself: the residuals' own spread, with the degrees of freedom that the fit took from it;
  points nearer than a pixel see the same labels and count as one;
* all points together, outwards or inwards: where in the seam that a segmenter leaves between two classes the edge
  lies is not known, and is the same all around;
* each marker as a whole, sideways: pixels' borders, and what a flat rigid model leaves out;
* each stretch of a contour together, as far as its residuals say: half hidden, merged or shaded (the cluster-robust
  estimate of Liang and Zeger, 1986).
"""

from __future__ import annotations

import numpy as np

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .pose_fit import JOINT_SIGMA, POINT_SIGMA_PX, ContourFit, contour_fit
from .surface_model import Poses, SpatialModel

REACH_PX = 3
FLOOR_PX = 0.15  # a contour's points are never surer than this
SEAM_SHARE = 0.6  # standard deviation of an edge's place, as a share of half the seam
SHIFT_PX = 0.1  # of a marker as a whole, in each direction
STRETCHES = 4  # of a contour, whose points err together
STRETCH_SHARE = 0.5  # of what the stretches' residuals pull counts: the rest is the other terms' already
MOST_TURN_RAD, MOST_RANGE_SHARE = 1.0, 0.5  # what is known of a pose without any contour


def pose_covariances(model: SpatialModel, frame: ImageFrame, poses: Poses, use: np.ndarray) -> Array:
    """(H, 6, 6) covariances of fitted hypotheses: x, y, z, then rotations about them, along the camera's axes.

    :param use: (H, M) bool: the markers of `model.markers` that each was fitted to.
    """
    prior = _prior(model, poses)
    fit = contour_fit(model, frame, poses, use, REACH_PX)
    seams_px = np.array([frame.field.seam_px(model.marker_labels[first]) for first in use.argmax(axis=1)])
    Jw = fit.jacobian * fit.weight[..., None]
    A = _transposed(_stacked(Jw)) @ _stacked(fit.jacobian) / POINT_SIGMA_PX**2 + prior
    noise = _noise(fit, Jw, seams_px) / POINT_SIGMA_PX**4 + prior
    inverse = np.linalg.inv(A)
    covariance = (inverse @ noise @ inverse)[:, :6, :6]
    return np.asarray((covariance + _transposed(covariance)) / 2, np.float64)


def _noise(fit: ContourFit, Jw: Array, seams_px: Array) -> Array:
    """(H, 6+J, 6+J) J' W cov(e) W J.

    :param Jw: (H, M, m, 6+J) rows of W J.
    """
    w, (_, _, n_points, n_par) = fit.weight, Jw.shape
    independent = np.minimum(1.0, fit.spacing_px)[..., None]  # (H, M, 1) of each point, a share
    n = (independent * (w > 0)).sum(axis=(1, 2))
    freedom = n / np.maximum(np.maximum(n - n_par, 0.25 * n), 1e-9)
    spread = (w * fit.residual**2).sum(axis=(1, 2)) / np.maximum(w.sum(axis=(1, 2)), 1e-9) * freedom
    deviation = np.sqrt((FLOOR_PX**2 + spread)[:, None, None] / np.maximum(independent, 1e-3))
    each = _stacked(Jw * deviation[..., None])
    outwards = seams_px[:, None, None] * Jw.sum(axis=(1, 2))[:, None]  # (H, 1, 6+J)
    sideways = _stacked(_transposed(fit.normal) @ Jw)  # (H, 2 M, 6+J)
    starts = n_points * np.arange(STRETCHES) // STRETCHES
    pull = _stacked(np.add.reduceat(Jw * fit.residual[..., None], starts, axis=2))
    robust = STRETCH_SHARE * freedom[:, None, None] * _squared(pull)
    return _squared(each) + SEAM_SHARE**2 * _squared(outwards) + SHIFT_PX**2 * _squared(sideways) + robust


def _prior(model: SpatialModel, poses: Poses) -> Array:
    """(H, 6+J, 6+J) information on the parameters that needs no image."""
    sigma = np.empty((len(poses), 6 + model.kinematics.n_joints))
    sigma[:, :3] = MOST_RANGE_SHARE * np.maximum(poses.t[:, 2:], 0.05)
    sigma[:, 3:6], sigma[:, 6:] = MOST_TURN_RAD, JOINT_SIGMA * model.kinematics.unit
    return np.asarray(np.eye(sigma.shape[1]) * (sigma**-2.0)[:, None], np.float64)


def _stacked(rows: Array) -> Array:
    """(H, M n, p) of rows (H, M, n, p)."""
    h, m, n, p = rows.shape
    return rows.reshape(h, m * n, p)


def _transposed(A: Array) -> Array:
    return A.swapaxes(-1, -2)


def _squared(A: Array) -> Array:
    """A' A of a stack of matrices."""
    return _transposed(A) @ A
