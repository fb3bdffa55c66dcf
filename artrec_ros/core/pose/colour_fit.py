"""The last fit of objects in space, where the image has colours: to where these change, not to classes' boundaries.

Where a class ends is what somebody has told of colours: of blurred edges it takes more than half of what is blended, or
less, and markers look too large, or too small. Along each normal of a contour the colours a little inside and outside
are the two ends of a step; the edge is where half of it is done. Where colours tell none (a neighbour of like colour,
clutter), the labels' edge counts, but less.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .colour_edge_kernels import ColourEdges
from .contour_step_kernels import Rounds, fit_to_colours, look_at_colours
from .contour_steps import ContourSteps
from .contour_term_kernels import ContourFit
from .occlusion import BEHIND
from .pose_fit import contours_of
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
        self._rounds = Rounds(config.fit.colour_rounds, _STILL_PX)

    def fitted(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Poses at rest on the colours' edges, but for those that lie worse on them than before.

        :param used: (H, M) markers that the labels support.
        """
        if not len(poses) or not used.any():
            return poses
        R, t, q, said = poses.R.copy(), poses.t.copy(), poses.q.copy(), np.empty((2, len(poses), 2))
        looks, fit = self._looks(frame, used)
        fit_to_colours(*looks, self._rounds, self._steps.begun(frame, used), R, t, q, fit, said)
        (before, seen), (after, left) = said.swapaxes(1, 2)
        better = (after < before) & (left > _KEPT * seen)
        return Poses.concatenate([poses, Poses(R, t, q)])[np.arange(len(poses)) + len(poses) * better]

    def edges(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> tuple[ContourFit, Array, Array]:
        """Contours against the labels' edges, and the residuals and weights (H, M, m) of the colours'."""
        looks, fit = self._looks(frame, used)
        residual, weight = np.empty(fit.residual.shape), np.empty(fit.weight.shape)
        look_at_colours(*looks, poses.R, poses.t, poses.q, fit, residual, weight)
        return fit, residual, weight

    def _looks(self, frame: ImageFrame, used: np.ndarray) -> tuple[tuple[Any, ...], ContourFit]:
        """What compiled code looks at, and room for what it finds."""
        config, surface, reach_px = self._config, self._surface, self._config.colour_reach_px
        term, which, fit = contours_of(surface, frame, used, reach_px, config)
        colours = ColourEdges(
            frame.colours, float(frame.gamma), float(config.colour_contrast), float(config.colour_doubt)
        )
        chain, joints = surface.kinematics.chain, self._steps.joints
        return (term, which, chain, joints, BEHIND, colours, self._radius_m[which], reach_px + 0.5), fit
