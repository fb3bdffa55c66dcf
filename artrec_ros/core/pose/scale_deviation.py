"""How well fits of what faces the camera tell its scale."""

from __future__ import annotations

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .covariance import deviations_without_image, sources
from .floor_term import floor_term
from .pose_fit import contour_fit, weight_at_edges
from .poses import Poses
from .surface_model import SpatialModel


def scale_deviations(
    model: SpatialModel, frame: ImageFrame, poses: Poses, use: np.ndarray, config: RecognizerConfig
) -> Array:
    """(H,) deviations of the logarithms of the scales of poses at rest, by their contours, which may all lie outwards
    or inwards of where the object ends, but for what is between markers that adjoin each other.

    :param use: (H, M) the markers that each was fitted to.
    """
    known = deviations_without_image(model, poses, config)
    told = sources(model, frame, poses, use, known, config).covariance(config.covariance)[:, 2, 2]
    told_by_fit = weight_at_edges(model, use, config.fit, floor_term(frame.scene.floor, config.fit))
    by_pixel = _by_pixel(model, frame, poses, use, known, config)
    off = np.where(np.isinf(told_by_fit), config.fit.edges_off_px * by_pixel, 0.0)
    return np.asarray(np.sqrt(told + off**2) / poses.t[:, 2], np.float64)


def _by_pixel(
    model: SpatialModel, frame: ImageFrame, poses: Poses, use: np.ndarray, known: Array, config: RecognizerConfig
) -> Array:
    """(H,) by how much farther off fits are of whose edges all lie a pixel inwards."""
    fit = contour_fit(model, frame, poses, use, config.covariance.reach_px, config.fit)
    weight = fit.weight / config.fit.point_sigma_px**2
    A = np.einsum("hkm,hkma,hkmb->hab", weight, fit.jacobian, fit.jacobian)
    A += known[:, None] ** -2.0 * np.eye(known.shape[1])
    open_ = model.open_contour[np.flatnonzero(use.any(axis=0))]
    pull = np.einsum("hkm,hkma->ha", weight * open_, fit.jacobian)
    return np.asarray(np.linalg.solve(A, pull[..., None])[:, 2, 0], np.float64)
