"""The last fit of objects in space, where the image has colours: to where these change, not to classes' boundaries.

Where a class ends is what somebody has told of colours: of blurred edges it takes more than half of what is blended, or
less, and markers look too large, or too small. Along each normal of a contour the colours a little inside and outside
are the two ends of a step; the edge is where half of it is done. Where colours tell none (a neighbour of like colour,
clutter), the labels' edge counts, but less.
"""

from __future__ import annotations

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .colour_edge_kernels import ColourEdges, look_for_colours
from .contour_steps import ContourSteps
from .contour_term_kernels import ContourFit
from .pose_fit import contour_fit
from .poses import Poses
from .surface_model import SpatialModel

_STILL_PX = 0.05  # a step that takes no contour farther is the last: edges are told to a tenth of a pixel
_KEPT = 0.8  # of what points weigh at least: one that loses its edges lies on nothing


class ColourFit:
    """Fits one model's poses."""

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._surface, self._config, self._steps = surface, config.fit, ContourSteps(surface, config.fit, facing=False)
        shown = [surface.patches[p].marker for p in surface.markers]
        self._radius_m = np.array([m.radius for m in shown if m is not None])

    def fitted(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Poses at rest on the colours' edges, but for those that lie worse on them than before.

        :param used: (H, M) markers that the labels support.
        """
        if not len(poses) or not used.any():
            return poses
        at, (fit, residual, weight) = poses, self.edges(frame, poses, used)
        before, seen = _misfit(residual, weight), _total(weight)
        steps = self._steps.begun(frame, used)
        for _ in range(self._config.colour_rounds):
            # far residuals pull no more than those of a pixel (Huber)
            at, moved_px = self._steps.step(steps, at, fit, residual, weight / np.maximum(1.0, np.abs(residual)))
            fit, residual, weight = self.edges(frame, at, used)
            if moved_px < _STILL_PX:
                break
        better = (_misfit(residual, weight) < before) & (_total(weight) > _KEPT * seen)
        both = Poses.concatenate([poses, at])
        return both[np.arange(len(poses)) + len(poses) * better]

    def edges(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> tuple[ContourFit, Array, Array]:
        """Contours against the labels' edges, and the residuals and weights (H, M, m) of the colours'."""
        config, which = self._config, np.flatnonzero(used.any(axis=0))
        fit = contour_fit(self._surface, frame, poses, used, config.colour_reach_px, config)
        scale = frame.camera.focal_px / np.maximum(poses.t[:, 2], 1e-6)
        half_px = np.clip(self._radius_m[which] * scale[:, None], 1.0, config.colour_reach_px + 0.5)
        residual, weight = fit.residual.copy(), fit.weight.copy()
        terms = ColourEdges(
            frame.colours, float(frame.gamma), float(config.colour_contrast), float(config.colour_doubt)
        )
        look_for_colours(terms, fit.point, fit.normal, half_px, residual, weight)
        return fit, residual, weight


def _misfit(residual: Array, weight: Array) -> Array:
    """(H,) mean size of the residuals (H, M, m)."""
    return np.asarray((weight * np.minimum(np.abs(residual), 3.0)).sum(axis=(1, 2)) / np.maximum(_total(weight), 1e-9))


def _total(weight: Array) -> Array:
    return np.asarray(weight.sum(axis=(1, 2)))
