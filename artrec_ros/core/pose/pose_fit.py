"""Least squares of a whole object's pose and joints on the contours of its markers.

Gauss-Newton with Levenberg damping. A contour point's residual is its distance along its normal
to the edge of its class there (point to line); a point with no edge in reach, hidden or merged, has no say.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from . import step_kernels as refining
from .edges import edge_terms
from .fit_kernels import Motion, contour_rows
from .step_kernels import Joints, StepTerms
from .surface_model import LEAST_COSINE, Poses, SpatialModel

JOINT_SIGMA = 1.5  # a weak pull to the middle of a joint's range keeps unseen joints determined
POINT_SIGMA_PX = 0.7  # labels place a boundary this well
PIN = 1e9  # weight that holds a joint
_STEP = StepTerms(POINT_SIGMA_PX, damping=np.array([0.05, 0.15]), limit=np.array([0.15, 0.3]))
_AT_ONCE = 64  # hypotheses between two looks at the clock


def refine(
    model: SpatialModel,
    frame: ImageFrame,
    poses: Poses,
    use: np.ndarray,
    reach_px: tuple[int, ...],
    free_joints: np.ndarray | None = None,
) -> Poses:
    """Fit poses to the labels' boundaries; a hypothesis that uses no marker stays, as do those left at the deadline.

    :param use: (H, M) bool: which markers of `model.markers` to use under each hypothesis.
    :param reach_px: how far each step looks for edges.
    :param free_joints: (H, J) bool; None: all.
    """
    kin, use = model.kinematics, np.ascontiguousarray(use)
    free = np.ones(poses.q.shape, bool) if free_joints is None else free_joints
    R, t, q = poses.R.copy(), poses.t.copy(), poses.q.copy()
    middle, weight = (kin.lower + kin.upper) / 2, (POINT_SIGMA_PX / (JOINT_SIGMA * kin.unit)) ** 2
    joints = Joints(kin.lower, kin.upper, kin.unit, kin.revolute, kin.endless, kin.moves, middle, weight, PIN)
    terms, view = edge_terms(model, frame.field, reach_px), frame.view
    for part in frame.deadline.parts(len(poses), _AT_ONCE):
        refining.refine(
            model.compiled, kin.chain, joints, model.markers, use[part], free[part], terms, _STEP, view, LEAST_COSINE,
            R[part], t[part], q[part],
        )  # fmt: skip
    return Poses(R, t, q)


@dataclass(frozen=True)
class ContourFit:
    """The contours of M markers of one or more hypotheses against the labels' edges, m points each.

    :param normal: (H, M, m, 2) outward unit normals in the image. :param spacing_px: (H, M) of neighbouring points.
    :param residual: (H, M, m) signed distance of each point from its edge along its normal, pixels.
    :param weight: (H, M, m), 0 where there is no edge, and the residual says nothing.
    :param jacobian: (H, M, m, 6+J) of the residuals.
    """

    normal: Array
    spacing_px: Array
    residual: Array
    weight: Array
    jacobian: Array


def contour_fit(model: SpatialModel, frame: ImageFrame, poses: Poses, use: np.ndarray, reach: int) -> ContourFit:
    """How poses fit as they are; the markers that some hypothesis uses."""
    kin, size = model.kinematics, (len(poses), len(model.markers), model.contour.shape[1])
    frames, which = kin.forward(poses.R, poses.t, poses.q), np.flatnonzero(use.any(axis=0))
    normal, spacing_px, residual = np.empty((*size, 2)), np.empty(size[:2]), np.empty(size)
    weight, jacobian = np.empty(size), np.empty((*size, 6 + kin.n_joints))
    terms, view, used = edge_terms(model, frame.field, (reach,)), frame.view, np.ascontiguousarray(use)
    for h in range(len(poses)):
        motion = Motion(poses.t[h], frames.axis[h], frames.origin[h], kin.revolute, kin.moves)
        contour_rows(
            model.compiled, model.markers, used[h], frames.R[h], frames.t[h], motion, terms, view, LEAST_COSINE,
            normal[h], spacing_px[h], residual[h], weight[h], jacobian[h],
        )  # fmt: skip
    kept = (values[:, which] for values in (normal, spacing_px, residual, weight, jacobian))
    return ContourFit(*kept)
