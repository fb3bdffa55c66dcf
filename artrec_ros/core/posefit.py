"""Least squares of a whole object's pose and joints on the contours of its markers.

Batched Gauss-Newton with Levenberg damping. A contour point's residual is its distance along its normal
to the edge of its class there (point to line); a point with no edge in reach, hidden or merged, has no say.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .compiled import refining
from .compiled.fitting import Motion, contour_rows
from .compiled.geometry import view_of
from .compiled.jit import COMPILED
from .compiled.refining import Joints, StepTerms
from .datatypes import Camera
from .edges import edge_terms, find_edges
from .evidence import LabelField
from .kinematics import Frames, Kinematics
from .projection import projection_jacobian
from .spatial import LEAST_COSINE, Poses, SpatialModel
from .transforms import Array, rotation_from_rotvec

JOINT_SIGMA = 1.5  # a weak pull to the middle of a joint's range keeps unseen joints determined
POINT_SIGMA_PX = 0.7  # labels place a boundary this well
PIN = 1e9  # weight that holds a joint
_STEP = StepTerms(POINT_SIGMA_PX, damping=np.array([0.05, 0.15]), limit=np.array([0.15, 0.3]))


def refine(
    model: SpatialModel,
    field: LabelField,
    camera: Camera,
    poses: Poses,
    use: np.ndarray,
    reach_px: tuple[int, ...],
    free_joints: np.ndarray | None = None,
) -> Poses:
    """Fit poses to the labels' boundaries; a hypothesis that uses no marker stays.

    :param use: (H, M) bool: which markers of `model.markers` to use under each hypothesis.
    :param reach_px: how far each step looks for edges.
    :param free_joints: (H, J) bool; None: all.
    """
    free = np.ones(poses.q.shape, bool) if free_joints is None else free_joints
    if COMPILED:
        return _refine_compiled(model, field, camera, poses, use, reach_px, free)
    used = np.flatnonzero(use.any(axis=1))
    fitted = poses[used]
    for reach in reach_px if len(used) else ():
        A, b = _normal_equations(model, field, camera, fitted, use[used], reach)
        _hold(model, fitted, A, b, free[used])
        fitted = _step(model, fitted, A, b)
    order = np.arange(len(poses))
    order[used] = len(poses) + np.arange(len(used))
    return Poses.concatenate([poses, fitted])[order]


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


def contour_fit(
    model: SpatialModel, field: LabelField, camera: Camera, poses: Poses, use: np.ndarray, reach: int
) -> ContourFit:
    """How poses fit as they are; the markers that some hypothesis uses."""
    frames = model.kinematics.forward(poses.R, poses.t, poses.q)
    which = np.flatnonzero(use.any(axis=0))
    if COMPILED:
        return _contour_fit_compiled(model, field, camera, poses, frames, use, which, reach)
    patches = model.markers[which]
    cosine, _ = model.in_camera(frames, patches)
    pixels, normal = model.project_contours(camera, frames, which)
    edge, weight = find_edges(field, pixels, normal, model.label[patches], reach)
    weight = weight * (use[:, which] & (cosine > LEAST_COSINE))[..., None]
    X = model.place_contours(frames, which)
    row = np.einsum("hmki,hmkij->hmkj", normal, projection_jacobian(camera, X))  # (H, M, m, 3): d residual / d X
    columns = [row, np.cross(X - poses.t[:, None, None], row)]  # shift, and turn about the object's origin
    J = np.concatenate([*columns, _joint_columns(model, frames, X, row, model.component[patches])], axis=-1)
    return ContourFit(normal, _spacing_px(pixels), -edge, weight, J)


def _spacing_px(pixels: Array) -> Array:
    """(H, M) mean distance of neighbouring points of contours (H, M, m, 2)."""
    return np.asarray(np.linalg.norm(np.roll(pixels, -1, axis=2) - pixels, axis=-1).mean(axis=2), np.float64)


def _contour_fit_compiled(
    model: SpatialModel,
    field: LabelField,
    camera: Camera,
    poses: Poses,
    frames: Frames,
    use: np.ndarray,
    which: np.ndarray,
    reach: int,
) -> ContourFit:
    kin, size = model.kinematics, (len(poses), len(model.markers), model.contour.shape[1])
    normal, spacing_px, residual = np.empty((*size, 2)), np.empty(size[:2]), np.empty(size)
    weight, jacobian = np.empty(size), np.empty((*size, 6 + kin.n_joints))
    terms, view, used = edge_terms(model, field, (reach,)), view_of(field, camera), np.ascontiguousarray(use)
    for h in range(len(poses)):
        motion = Motion(poses.t[h], frames.axis[h], frames.origin[h], kin.revolute, kin.moves)
        contour_rows(
            model.compiled, model.markers, used[h], frames.R[h], frames.t[h], motion, terms, view, LEAST_COSINE,
            normal[h], spacing_px[h], residual[h], weight[h], jacobian[h],
        )  # fmt: skip
    kept = (values[:, which] for values in (normal, spacing_px, residual, weight, jacobian))
    return ContourFit(*kept)


def _normal_equations(
    model: SpatialModel, field: LabelField, camera: Camera, poses: Poses, use: np.ndarray, reach: int
) -> tuple[Array, Array]:
    fit = contour_fit(model, field, camera, poses, use, reach)
    n = len(poses)
    J = fit.jacobian.reshape(n, -1, fit.jacobian.shape[-1])
    Jw = J * fit.weight.reshape(n, -1)[..., None]
    return Jw.transpose(0, 2, 1) @ J, np.einsum("hkp,hk->hp", Jw, fit.residual.reshape(n, -1))


def _refine_compiled(
    model: SpatialModel,
    field: LabelField,
    camera: Camera,
    poses: Poses,
    use: np.ndarray,
    reach_px: tuple[int, ...],
    free: np.ndarray,
) -> Poses:
    kin = model.kinematics
    R, t, q = poses.R.copy(), poses.t.copy(), poses.q.copy()
    middle, weight = _prior(kin)
    joints = Joints(kin.lower, kin.upper, kin.unit, kin.revolute, kin.endless, kin.moves, middle, weight, PIN)
    refining.refine(
        model.compiled, kin.chain, joints, model.markers, np.ascontiguousarray(use), free,
        edge_terms(model, field, reach_px), _STEP, view_of(field, camera), LEAST_COSINE, R, t, q,
    )  # fmt: skip
    return Poses(R, t, q)


def _joint_columns(model: SpatialModel, frames: Frames, X: Array, row: Array, component: np.ndarray) -> Array:
    kin = model.kinematics
    out = np.zeros((*X.shape[:-1], kin.n_joints))
    for j in range(kin.n_joints):
        on = kin.moves[component, j]
        if not on.any():
            continue
        axis = frames.axis[:, j, None, None]
        arm = X[:, on] - frames.origin[:, j, None, None]
        velocity = (
            np.cross(np.broadcast_to(axis, arm.shape), arm) if kin.revolute[j] else np.broadcast_to(axis, arm.shape)
        )
        out[..., j][:, on] = np.sum(row[:, on] * velocity, axis=-1)
    return out


def _prior(kin: Kinematics) -> tuple[Array, Array]:
    """Where the joints' weak prior pulls to, and how strongly: (J,) each."""
    return (kin.lower + kin.upper) / 2, (POINT_SIGMA_PX / (JOINT_SIGMA * kin.unit)) ** 2


def _hold(model: SpatialModel, poses: Poses, A: Array, b: Array, free: np.ndarray) -> None:
    """Add the joints' weak prior; pin those that are not free."""
    joints = 6 + np.arange(model.kinematics.n_joints)
    middle, weight = _prior(model.kinematics)
    A[:, joints, joints] += weight + PIN * ~free
    b[:, joints] += weight * (poses.q - middle)


def _step(model: SpatialModel, poses: Poses, A: Array, b: Array) -> Poses:
    kin = model.kinematics
    n_par = A.shape[1]
    depth = np.maximum(poses.t[:, 2], 0.05)
    # each parameter's own unit: the range, a radian, a joint's unit
    units = np.concatenate(
        [depth[:, None] * np.ones(3), np.ones((len(depth), 3)), np.tile(kin.unit, (len(depth), 1))], 1
    )
    kind = [0] * 3 + [1] * (n_par - 3)
    damped = A + np.eye(n_par) * ((_STEP.sigma_px / (units * _STEP.damping[kind])) ** 2 + 1e-9)[:, None, :]
    x = -np.linalg.solve(damped, b[..., None])[..., 0]
    x *= np.minimum(1.0, 1.0 / np.maximum(np.abs(x / (units * _STEP.limit[kind])).max(axis=1, keepdims=True), 1e-12))
    R = rotation_from_rotvec(x[:, 3:6]) @ poses.R
    return Poses(R, poses.t + x[:, :3], kin.bound(poses.q + x[:, 6:]))
