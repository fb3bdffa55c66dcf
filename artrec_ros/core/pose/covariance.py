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

from ..base.config import CovarianceConfig, RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .pose_fit import ContourFit, contour_fit
from .surface_model import Poses, SpatialModel

_LEAST_DEPTH_M = 0.05  # of a share that is to be more than nothing


def pose_covariances(
    model: SpatialModel, frame: ImageFrame, poses: Poses, use: np.ndarray, config: RecognizerConfig
) -> Array:
    """(H, 6+J, 6+J) covariances of fitted hypotheses: x, y, z, rotations about them, along the camera's axes; joints.

    :param use: (H, M) bool: the markers of `model.markers` that each was fitted to.
    """
    prior, sigma_px = _prior(model, poses, config), config.fit.point_sigma_px
    fit = contour_fit(model, frame, poses, use, config.covariance.reach_px, config.fit)
    seams_px = model.seams_px(frame.field)[use.argmax(axis=1)]
    Jw = fit.jacobian * fit.weight[..., None]
    A = _transposed(_stacked(Jw)) @ _stacked(fit.jacobian) / sigma_px**2 + prior
    noise = _noise(fit, Jw, seams_px, config.covariance) / sigma_px**4 + prior
    inverse = np.linalg.inv(A)
    covariance = inverse @ noise @ inverse
    return np.asarray((covariance + _transposed(covariance)) / 2, np.float64)


def _noise(fit: ContourFit, Jw: Array, seams_px: Array, config: CovarianceConfig) -> Array:
    """(H, 6+J, 6+J) J' W cov(e) W J.

    :param Jw: (H, M, m, 6+J) rows of W J.
    """
    w, (_, _, n_points, n_par) = fit.weight, Jw.shape
    independent = np.minimum(1.0, fit.spacing_px)[..., None]  # (H, M, 1) of each point, a share
    n = (independent * (w > 0)).sum(axis=(1, 2))
    freedom = n / np.maximum(np.maximum(n - n_par, config.least_freedom * n), 1e-9)
    spread = (w * fit.residual**2).sum(axis=(1, 2)) / np.maximum(w.sum(axis=(1, 2)), 1e-9) * freedom
    deviation = np.sqrt((config.floor_px**2 + spread)[:, None, None] / np.maximum(independent, 1e-3))
    each = _stacked(Jw * deviation[..., None])
    outwards = seams_px[:, None, None] * Jw.sum(axis=(1, 2))[:, None]  # (H, 1, 6+J)
    sideways = _stacked(_transposed(fit.normal) @ Jw)  # (H, 2 M, 6+J)
    starts = n_points * np.arange(config.stretches) // config.stretches
    pull = _stacked(np.add.reduceat(Jw * fit.residual[..., None], starts, axis=2))
    robust = config.stretch_share * freedom[:, None, None] * _squared(pull)
    seam, shift = config.seam_share**2 * _squared(outwards), config.shift_px**2 * _squared(sideways)
    return _squared(each) + seam + shift + robust


def _prior(model: SpatialModel, poses: Poses, config: RecognizerConfig) -> Array:
    """(H, 6+J, 6+J) information on the parameters that needs no image."""
    sigma, kin = np.empty((len(poses), 6 + model.kinematics.n_joints)), model.kinematics
    sigma[:, :3] = config.covariance.most_range_share * np.maximum(poses.t[:, 2:], _LEAST_DEPTH_M)
    sigma[:, 3:6], sigma[:, 6:] = config.covariance.most_turn_rad, config.fit.joint_sigma * kin.unit
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
