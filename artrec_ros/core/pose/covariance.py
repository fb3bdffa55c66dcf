"""How sure a fitted pose is: the covariance of least squares whose residuals are not independent.

With residuals r = J x + e, weights W and a weak prior P, the estimate's covariance is
A^-1 (J' W cov(e) W J + P) A^-1 with A = J' W J + P. What makes up cov(e):

* each contour point by itself: the residuals' own spread, with the degrees of freedom that the fit took from it;
  points nearer than a pixel see the same labels and count as one;
* all points of a marker together, outwards or inwards: where in the seam that a segmenter leaves between two classes
  the edge lies is not known, and is the same all around; nor is it where that may be a body of no class as well. Nor is
  where between two blended colours it lies. What all markers that stand apart have in common of it the fit tells, as
  one parameter more; but each has surroundings of its own, and of a joint its own marker's edges alone may tell;
* all edges of the image together, along x and along y: what is left of the lens' distortion, light from a side, a
  shutter that rolls. However many markers an object has, they do not average this out;
* each stretch of a contour together, as far as its residuals say: half hidden, merged or shaded (the cluster-robust
  estimate of Liang and Zeger, 1986).

How far from a contour an edge may lie by chance the labels along its normal tell: rounding, seams, stray and lost
pixels leave its place open, each point's by itself. Where edges are farther off they lie elsewhere, and neighbours do
together: networks give labels for cells of pixels, round corners and tear borders. Few points then say something of
their own, and all of it counts for more.

To this comes what no derivative tells: where the same fit comes to rest when it begins elsewhere (`restarts.py`). And
where a segmenter leaves wide seams all of it counts for more: its shade and blur move edges in ways of their own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.config import CovarianceConfig, RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .covariance_kernels import Spreads, Sums, Weights, add_up, spread_out
from .floor_term import equations, floor_term
from .pose_fit import AS_GOOD_AS_CERTAIN, contour_fit, weight_at_edges
from .poses import Poses
from .restarts import scatter
from .surface_model import SpatialModel

_LEAST_DEPTH_M = 0.05  # of a share that is to be more than nothing


@dataclass(frozen=True)
class Sources:
    """What makes H fitted hypotheses err, each (H, 6+J, 6+J) and per unit of its share in `CovarianceConfig`.

    :param known: what is known without any image, as far as the image tells no more.
    :param spread, seam, blend, shift, stretch: of each sort of error of the contours.
    :param seams_px: (H,) half the seam.
    """

    known: Array
    spread: Array
    seam: Array
    blend: Array
    shift: Array
    stretch: Array
    seams_px: Array

    def covariance(self, config: CovarianceConfig, restart: Array | None = None) -> Array:
        """(H, 6+J, 6+J) of all of them together. :param restart: the same of restarts; None: to first order."""
        made = config.spread_share**2 * self.spread + config.seam_share**2 * self.seam
        made += config.colour_edge_px**2 * self.blend + config.stretch_share**2 * self.stretch
        if restart is not None:
            made += config.restart_share**2 * restart
        by_seams = (1 + config.seam_gain * self.seams_px)[:, None, None]
        return np.asarray(self.known + config.shift_px**2 * self.shift + by_seams * made, np.float64)


def pose_covariances(
    model: SpatialModel,
    frame: ImageFrame,
    poses: Poses,
    use: np.ndarray,
    config: RecognizerConfig,
    *,
    facing: bool = False,
) -> Array:
    """(H, 6+J, 6+J) covariances of fitted hypotheses: x, y, z, rotations about them, along the camera's axes; joints.

    :param use: (H, M) bool: the markers of `model.markers` that each was fitted to.
    :param facing: poses turn about the optical axis alone.
    """
    known, use = deviations_without_image(model, poses, config), model.sides.with_all(use)
    found = sources(model, frame, poses, use, known, config)
    first = found.covariance(config.covariance)
    covariance = found.covariance(
        config.covariance, scatter(model, frame, poses, use, first, known, config, facing=facing)
    )
    return np.asarray((covariance + _transposed(covariance)) / 2, np.float64)


def sources(
    model: SpatialModel, frame: ImageFrame, poses: Poses, use: np.ndarray, known: Array, config: RecognizerConfig
) -> Sources:
    """As of `pose_covariances`. :param known: (H, 6+J) deviations without any image."""
    c, sigma_px = config.covariance, config.fit.point_sigma_px
    floor, n_par = floor_term(frame.scene.floor, config.fit), known.shape[1]
    at_edges = weight_at_edges(model, use, config.fit, floor)
    certain = np.column_stack([known**-2.0, at_edges / sigma_px**2])
    prior = np.minimum(certain, AS_GOOD_AS_CERTAIN)[:, None] * np.eye(n_par + 1)
    prior += equations(floor, poses, n_par + 1)[0] / sigma_px**2
    fit = contour_fit(model, frame, poses, use, c.reach_px, config.fit)
    by = Weights(float(sigma_px**2), np.minimum(at_edges, AS_GOOD_AS_CERTAIN), float(c.least_freedom), int(c.stretches))
    A, sums = prior.copy(), Sums(*np.empty((4, len(poses))))
    add_up(fit, by, A, sums)
    gain = np.ascontiguousarray(np.linalg.inv(A)[:, :, :n_par])
    spreads = Spreads(*np.zeros((4, len(poses), n_par, n_par)))
    spread_out(fit, by, sums, gain, spreads)
    seams_px = model.seams_px(frame.field, most=True)[use.argmax(axis=1)]
    # weights are 1 / (1 + variance of the edge's place): by these weights the mean of the variances
    rough_px2 = np.maximum(sums.square - c.exact_share * sums.left_open, 0.0) * (frame.image is None)
    more = (1 + c.rough_gain * rough_px2)[:, None, None]
    return Sources(
        known=_transposed(gain) @ prior @ gain,
        spread=more * spreads.spread,
        seam=more * seams_px[:, None, None] ** 2 * spreads.by_pixel,
        blend=spreads.by_pixel * (frame.image is not None),
        shift=spreads.shift,
        stretch=more * spreads.stretch,
        seams_px=seams_px,
    )


def deviations_without_image(model: SpatialModel, poses: Poses, config: RecognizerConfig) -> Array:
    """(H, 6+J) standard deviations of pose and joints before labels are looked at."""
    known, kin = np.empty((len(poses), 6 + model.kinematics.n_joints)), model.kinematics
    known[:, :3] = config.covariance.most_range_share * np.maximum(poses.t[:, 2:], _LEAST_DEPTH_M)
    known[:, 3:6], known[:, 6:] = config.covariance.most_turn_rad, config.fit.joint_sigma * kin.unit
    return known


def _transposed(A: Array) -> Array:
    return A.swapaxes(-1, -2)
