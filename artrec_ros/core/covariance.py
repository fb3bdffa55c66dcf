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

from .datatypes import Camera
from .evidence import LabelField
from .posefit import JOINT_SIGMA, POINT_SIGMA_PX, ContourFit, contour_fit
from .spatial import Poses, SpatialModel
from .transforms import Array

REACH_PX = 3
FLOOR_PX = 0.15  # a contour's points are never surer than this
SEAM_SHARE = 0.6  # standard deviation of an edge's place, as a share of half the seam
SHIFT_PX = 0.1  # of a marker as a whole, in each direction
STRETCHES = 4  # of a contour, whose points err together
STRETCH_SHARE = 0.5  # of what the stretches' residuals pull counts: the rest is the other terms' already
MOST_TURN_RAD, MOST_RANGE_SHARE = 1.0, 0.5  # what is known of a pose without any contour


def pose_covariance(model: SpatialModel, field: LabelField, camera: Camera, poses: Poses, use: np.ndarray) -> Array:
    """(6, 6) covariance of one fitted hypothesis: x, y, z, then rotations about them, along the camera's axes.

    :param use: (1, M) bool: the markers of `model.markers` that it was fitted to.
    """
    prior = _prior(model, poses)
    if not use.any():
        return np.diag(1 / np.diag(prior)[:6])
    fit = contour_fit(model, field, camera, poses, use, REACH_PX)
    seam_px = field.seam_px(int(model.label[model.markers[np.flatnonzero(use[0])[0]]]))
    Jw = fit.jacobian[0] * fit.weight[0][..., None]  # (M, m, 6+J)
    n_par = Jw.shape[-1]
    A = Jw.reshape(-1, n_par).T @ fit.jacobian[0].reshape(-1, n_par) / POINT_SIGMA_PX**2 + prior
    noise = _noise(fit, Jw, seam_px) / POINT_SIGMA_PX**4 + prior
    inverse = np.linalg.inv(A)
    covariance = (inverse @ noise @ inverse)[:6, :6]
    return np.asarray((covariance + covariance.T) / 2, np.float64)


def _noise(fit: ContourFit, Jw: Array, seam_px: float) -> Array:
    """J' W cov(e) W J."""
    w, n_par = fit.weight[0], Jw.shape[-1]
    independent = np.minimum(1.0, fit.spacing_px[0])[:, None] * np.ones_like(w)  # of each point, a share
    n = float(independent[w > 0].sum())
    freedom = n / max(n - n_par, 0.25 * n, 1e-9)
    spread = float(np.sum(w * fit.residual[0] ** 2) / max(w.sum(), 1e-9)) * freedom
    variance = (FLOOR_PX**2 + spread) / np.maximum(independent, 1e-3)
    points = (Jw * variance[..., None]).reshape(-1, n_par).T @ Jw.reshape(-1, n_par)
    outwards = Jw.sum(axis=(0, 1))
    sideways = Jw.transpose(0, 2, 1) @ fit.normal[0]  # (M, 6+J, 2)
    shift = (sideways @ sideways.transpose(0, 2, 1)).sum(axis=0)
    starts = np.linspace(0, w.shape[1], STRETCHES, endpoint=False).astype(int)
    pull = np.add.reduceat(Jw * fit.residual[0][..., None], starts, axis=1).reshape(-1, n_par)
    robust = STRETCH_SHARE * freedom * pull.T @ pull
    return points + (SEAM_SHARE * seam_px) ** 2 * np.outer(outwards, outwards) + SHIFT_PX**2 * shift + robust


def _prior(model: SpatialModel, poses: Poses) -> Array:
    """Information on the parameters that needs no image."""
    range_m = MOST_RANGE_SHARE * max(float(poses.t[0, 2]), 0.05)
    sigma = np.concatenate([[range_m] * 3, [MOST_TURN_RAD] * 3, JOINT_SIGMA * model.kinematics.unit])
    return np.diag(sigma**-2.0)
