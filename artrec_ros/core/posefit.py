"""Least squares of a whole object's pose and joints on the contours of its markers.

Batched Gauss-Newton with Levenberg damping. A contour point's residual is its signed distance to the
boundary of its class (point to line); Tukey's weight forgets points whose boundary another part hides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .datatypes import Camera
from .evidence import LabelField
from .kinematics import Frames
from .projection import projection_jacobian
from .spatial import LEAST_COSINE, Poses, SpatialModel
from .transforms import Array, rotation_from_rotvec

NORMALS_AGREE = 0.6  # cosine between the model's normal and the boundary's
JOINT_SIGMA_RAD = 1.5  # a weak pull to the middle of a joint's range keeps unseen joints determined
POINT_SIGMA_PX = 0.7  # labels place a boundary this well


@dataclass(frozen=True)
class Fit:
    """Refined hypotheses, RMS contour distance (H,) in pixels, and information matrix (H, 6+J, 6+J).

    The first six parameters are the object origin's shift and a rotation about it, both along the camera's axes.
    """

    poses: Poses
    rms_px: Array
    information: Array


def refine(
    model: SpatialModel,
    field: LabelField,
    camera: Camera,
    poses: Poses,
    use: np.ndarray,
    gates_px: tuple[float, ...],
    erosion_px: float,
    free_joints: np.ndarray | None = None,
) -> Fit:
    """Fit poses to the labels' boundaries.

    :param use: (H, M) bool: which markers of `model.markers` to use under each hypothesis.
    :param gates_px: Tukey's gate of each step.
    :param erosion_px: how far the labels' boundary lies inside the true one.
    :param free_joints: (H, J) bool; None: all.
    """
    n_par = 6 + model.kinematics.n_joints
    rms, A = np.zeros(len(poses)), np.zeros((len(poses), n_par, n_par))
    for gate in gates_px:
        A, b, rms = _normal_equations(model, field, camera, poses, use, gate, erosion_px)
        _hold(model, poses, A, b, free_joints)
        poses = _step(model, poses, A, b)
    return Fit(poses, rms, A)


def _normal_equations(
    model: SpatialModel, field: LabelField, camera: Camera, poses: Poses, use: np.ndarray, gate: float, erosion: float
) -> tuple[Array, Array, Array]:
    kin = model.kinematics
    frames = kin.forward(poses.R, poses.t, poses.q)
    which = np.flatnonzero(use.any(axis=0))
    patches = model.markers[which]
    cosine, _ = model.in_camera(frames, patches)
    c = model.component[patches]
    X = model.contour[which] @ frames.R[:, c].transpose(0, 1, 3, 2) + frames.t[:, c][:, :, None]  # (H, M, m, 3)
    pixels, normal = model.project_contours(camera, frames, which)
    d = np.empty((*pixels.shape[:-1], 3))
    for label in np.unique(model.label[patches]):
        on = model.label[patches] == label
        d[:, on] = field.distance(int(label), pixels[:, on])
    gradient = d[..., 1:]
    length = np.linalg.norm(gradient, axis=-1)
    r = d[..., 0] - erosion  # the true outline lies `erosion` outside of the labels' boundary
    agree = np.sum(gradient * normal, axis=-1) > NORMALS_AGREE * np.maximum(length, 1e-6)
    ok = (use[:, which] & (cosine > LEAST_COSINE))[..., None] & agree & (np.abs(r) < gate) & (length > 0.2)
    w = np.where(ok, (1 - (r / gate) ** 2) ** 2, 0.0)
    direction = gradient / np.maximum(length, 1e-6)[..., None]
    row = np.einsum("hmki,hmkij->hmkj", direction, projection_jacobian(camera, X))  # (H, M, m, 3): d residual / d X
    J = np.concatenate([row, np.cross(X - poses.t[:, None, None], row)], axis=-1)  # v, omega about the object's origin
    if kin.n_joints:
        J = np.concatenate([J, _joint_columns(model, frames, X, row, c)], axis=-1)
    n_h, n_par = len(poses), J.shape[-1]
    J, w, r = J.reshape(n_h, -1, n_par), w.reshape(n_h, -1), r.reshape(n_h, -1)
    Jw = J * w[..., None]
    A = Jw.transpose(0, 2, 1) @ J
    b = np.einsum("hkp,hk->hp", Jw, r)
    rms = np.sqrt(np.sum(w * r**2, axis=1) / np.maximum(w.sum(axis=1), 1e-9))
    return A, b, rms


def _joint_columns(model: SpatialModel, frames: Frames, X: Array, row: Array, component: np.ndarray) -> Array:
    kin = model.kinematics
    out = np.zeros((*X.shape[:-1], kin.n_joints))
    for j in range(kin.n_joints):
        on = kin.moves[component, j]
        if not on.any():
            continue
        axis = frames.axis[:, j, None, None]
        arm = X[:, on] - frames.origin[:, j, None, None]
        velocity = np.cross(np.broadcast_to(axis, arm.shape), arm) if kin.revolute[j] else np.broadcast_to(axis, arm.shape)
        out[..., j][:, on] = np.sum(row[:, on] * velocity, axis=-1)
    return out


def _hold(model: SpatialModel, poses: Poses, A: Array, b: Array, free: np.ndarray | None) -> None:
    """Add the joints' weak prior; pin those that are not free."""
    kin = model.kinematics
    middle = (kin.lower + kin.upper) / 2
    for j in range(kin.n_joints):
        weight = (POINT_SIGMA_PX / JOINT_SIGMA_RAD) ** 2
        A[:, 6 + j, 6 + j] += weight
        b[:, 6 + j] += weight * (poses.q[:, j] - middle[j])
        if free is not None:
            pinned = ~free[:, j]
            A[pinned, 6 + j, 6 + j] += 1e9


def _step(model: SpatialModel, poses: Poses, A: Array, b: Array) -> Poses:
    kin = model.kinematics
    n_par = A.shape[1]
    depth = np.maximum(poses.t[:, 2], 0.05)
    # damping in each parameter's own unit: 5 % of the range, 0.15 rad
    scale = np.concatenate([np.repeat(1 / (0.05 * depth)[:, None] ** 2, 3, axis=1), np.full((len(depth), n_par - 6 + 3), 1 / 0.15**2)], axis=1)
    damped = A + np.eye(n_par) * (scale * POINT_SIGMA_PX**2 + 1e-9)[:, None, :]
    x = -np.linalg.solve(damped, b[..., None])[..., 0]
    limit = np.concatenate([np.repeat(0.15 * depth[:, None], 3, axis=1), np.full((len(depth), n_par - 3), 0.3)], axis=1)
    x *= np.minimum(1.0, 1.0 / np.maximum(np.abs(x / limit).max(axis=1, keepdims=True), 1e-12))
    R = rotation_from_rotvec(x[:, 3:6]) @ poses.R
    q = np.clip(poses.q + x[:, 6:], kin.lower, kin.upper)
    return Poses(R, poses.t + x[:, :3], q)

