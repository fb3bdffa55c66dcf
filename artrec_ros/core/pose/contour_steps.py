"""Steps of least squares by edges that are found otherwise than a compiled fit finds them."""

from __future__ import annotations

import numpy as np

from ..base.config import FitConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .contour_step_kernels import Beside, step_each
from .contour_term_kernels import ContourFit
from .floor_term import floor_term
from .pose_fit import damping_of, joints_of, weight_at_edges
from .poses import Poses
from .surface_model import SpatialModel


class ContourSteps:
    """Those of one model's poses. :param facing: they turn about the optical axis alone."""

    def __init__(self, surface: SpatialModel, config: FitConfig, *, facing: bool) -> None:
        self._surface, self._config, self._damping = surface, config, damping_of(config, facing=facing)
        self.joints = joints_of(surface.kinematics)

    def begun(self, frame: ImageFrame, used: np.ndarray) -> Beside:
        """:param used: (H, M) markers whose contours are fitted."""
        floor = floor_term(frame.scene.floor, self._config)
        return Beside(floor, self._damping, weight_at_edges(self._surface, used, self._config, floor))

    def step(
        self, beside: Beside, poses: Poses, fit: ContourFit, residual: Array, weight: Array
    ) -> tuple[Poses, float]:
        """One step, and how far it takes the contours at most, pixels. :param residual, weight: (H, K, m)."""
        R, t, q = poses.R.copy(), poses.t.copy(), poses.q.copy()
        moved_px = step_each(fit, residual, weight, beside, self.joints, R, t, q)
        return Poses(R, t, q), float(moved_px)
