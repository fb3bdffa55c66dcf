"""Steps of least squares by edges that are found otherwise than a compiled fit finds them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base.config import FitConfig
from ..geometry.transforms import Array, rotation_from_rotvec
from ..image.image_frame import ImageFrame
from .contour_term_kernels import ContourFit
from .floor_term import equations, floor_term
from .floor_term_kernels import FloorTerm
from .pose_fit import AS_GOOD_AS_CERTAIN, weight_at_edges
from .poses import Poses
from .surface_model import SpatialModel


class Beside(NamedTuple):
    """What steps balance beside edges.

    :param at_edges: (H,) see `ContourTerm`: paint may be larger than it was measured, and light spread otherwise.
    """

    floor: FloorTerm
    at_edges: Array


class ContourSteps:
    """Those of one model's poses. :param facing: they turn about the optical axis alone."""

    def __init__(self, surface: SpatialModel, config: FitConfig, *, facing: bool) -> None:
        self._surface, self._config = surface, config
        self._held = AS_GOOD_AS_CERTAIN if facing else 0.0

    def begun(self, frame: ImageFrame, used: np.ndarray) -> Beside:
        """:param used: (H, M) markers whose contours are fitted."""
        floor = floor_term(frame.scene.floor, self._config)
        return Beside(floor, weight_at_edges(self._surface, used, self._config, floor))

    def step(
        self, beside: Beside, poses: Poses, fit: ContourFit, residual: Array, weight: Array
    ) -> tuple[Poses, float]:
        """One step, and how far it takes the contours at most, pixels. :param residual, weight: (H, K, m)."""
        config, kin, (H, _, _, n) = self._config, self._surface.kinematics, fit.jacobian.shape
        r, w = residual.reshape(H, -1), weight.reshape(H, -1)
        J = np.concatenate([fit.jacobian.reshape(H, -1, n), np.ones((*r.shape, 1))], axis=-1)
        held = np.empty((H, n + 1))  # per unit of a point's variance: steps are short (Levenberg)
        held[:, :3] = (config.shift_sigma * np.maximum(poses.t[:, 2:], 1e-6)) ** -2.0
        held[:, 3:n], held[:, 6:n] = config.bend_sigma**-2.0, (config.bend_sigma * kin.unit) ** -2.0
        held *= config.point_sigma_px**2
        held[:, 3:5] += self._held
        held[:, n] = np.minimum(beside.at_edges, AS_GOOD_AS_CERTAIN)
        weighed = (J * w[..., None]).swapaxes(1, 2)
        stands, down = equations(beside.floor, poses, n + 1)
        pull = weighed @ r[..., None] + down[..., None]  # of joints nothing more: those that nobody sees stay
        step = -np.linalg.solve(weighed @ J + held[:, None] * np.eye(n + 1) + stands, pull)
        x, moved = step[..., 0], np.where(w > 0, np.abs(J[..., :n] @ step[:, :n])[..., 0], 0.0)
        R = rotation_from_rotvec(x[:, 3:6]) @ poses.R
        return Poses(R, poses.t + x[:, :3], kin.bound(poses.q + x[:, 6:n])), float(moved.max(initial=0.0))
