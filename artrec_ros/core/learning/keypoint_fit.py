"""Pose and joints of an object from a few points of it in an image: Levenberg-Marquardt from many sides at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project, projection_jacobian
from ..geometry.transforms import Array, rotation_from_quaternion, rotation_from_rotvec, skew
from ..model.kinematics import Frames, Kinematics

# How wide a search is that always ends in the same place: more costs time alone.
_TURNS = 400  # orientations that are looked at
_STARTS = 32  # of those, the ones from which the points' sides are seen best
_KEPT = 6
_STEPS, _LAST_STEPS = 12, 30
_LEAST_PX = 0.5  # no annotated point is better than this


@dataclass(frozen=True)
class Points:
    """Points of an object and where an image shows them.

    :param component: (n,) number of the component that bears each.
    :param place, normal: (n, 3) in the component's frame; the normal leaves the surface on which the point lies.
    :param pixel: (n, 2).
    """

    component: NDArray[np.int64]
    place: Array
    normal: Array
    pixel: Array


@dataclass(frozen=True)
class PointFit:
    """:param R, t: the object's frame in the camera's; q: (J,) joints; q_noise: (J,) their standard deviation.
    :param rms_px: root mean square distance of the points from where they should be.
    """

    R: Array
    t: Array
    q: Array
    q_noise: Array
    rms_px: float


@dataclass(frozen=True)
class _State:
    """H hypotheses; cost is the sum of squared distances, pixels."""

    R: Array
    t: Array
    q: Array
    cost: Array
    damping: Array

    def take(self, index: NDArray[np.int64]) -> _State:
        return _State(self.R[index], self.t[index], self.q[index], self.cost[index], self.damping[index])


def fit_points(kin: Kinematics, camera: Camera, points: Points) -> PointFit | None:
    """The pose and joints that bring the points to their pixels, all of them seen from in front; None: there is none.

    :param points: four or more; with fewer numbers than unknowns a fit is one of many.
    """
    if len(points.component) < 4:
        return None
    state = _starts(kin, camera, points, np.random.default_rng(0))
    for _ in range(_STEPS):
        state = _step(kin, camera, points, state)
    state = state.take(np.argsort(state.cost, kind="stable")[:_KEPT])
    for _ in range(_LAST_STEPS):
        state = _step(kin, camera, points, state)
    frames = kin.forward(state.R, state.t, state.q)
    cost = np.where((_facing(frames, points) > 0).all(axis=1), state.cost, np.inf)
    best = int(np.argmin(cost))
    if not np.isfinite(cost[best]):
        return None
    one = state.take(np.array([best]))
    rms = float(np.sqrt(one.cost[0] / len(points.component)))
    normal, _ = _normal_equations(kin, camera, points, one)
    variance = np.diag(np.linalg.pinv(normal[0] + 1e-9 * np.eye(normal.shape[1])))[6:]
    noise = max(rms, _LEAST_PX) * np.sqrt(np.maximum(variance, 0.0))
    return PointFit(one.R[0], one.t[0], one.q[0], noise, rms)


def _facing(frames: Frames, points: Points) -> Array:
    """(H, n) cosine of the angle under which each point's surface is seen."""
    X = _place(frames, points)
    normal = np.einsum("hnij,nj->hni", frames.R[:, points.component], points.normal)
    return -np.sum(normal * X, axis=-1) / np.maximum(np.linalg.norm(X, axis=-1), 1e-9)


def _place(frames: Frames, points: Points) -> Array:
    """(H, n, 3) the points in the camera's frame."""
    turned: Array = np.einsum("hnij,nj->hni", frames.R[:, points.component], points.place)
    return turned + frames.t[:, points.component]


def _starts(kin: Kinematics, camera: Camera, points: Points, rng: np.random.Generator) -> _State:
    """Orientations from which the points' sides are seen, at the depth and place that fit the points' spread."""
    turns = rng.normal(size=(_TURNS, 4))
    R = np.array([rotation_from_quaternion(v / np.linalg.norm(v)) for v in turns])
    q = np.tile(kin.middle, (_TURNS, 1))
    far = np.tile([0.0, 0.0, 1e6], (_TURNS, 1))  # all lines of sight alike
    frames = kin.forward(R, far, q)
    best = np.argsort(-_facing(frames, points).mean(axis=1), kind="stable")[:_STARTS]
    X = (_place(frames, points) - far[:, None])[best]
    f = camera.focal_px
    spread_px = float(np.sqrt(points.pixel.var(axis=0).sum()))
    spread_m = np.sqrt(X[..., :2].var(axis=1).sum(axis=1))
    depth = f * np.maximum(spread_m, 1e-6) / max(spread_px, 1e-6)
    centre = (points.pixel.mean(axis=0) - camera.matrix[:2, 2]) / np.diag(camera.matrix)[:2]
    t = np.column_stack([centre[0] * depth, centre[1] * depth, depth]) - X.mean(axis=1)
    state = _State(R[best], t, q[best], np.full(len(best), np.inf), np.full(len(best), 1e-2))
    return _State(state.R, state.t, state.q, _cost(kin, camera, points, state), state.damping)


def _cost(kin: Kinematics, camera: Camera, points: Points, s: _State) -> Array:
    X = _place(kin.forward(s.R, s.t, s.q), points)
    cost: Array = np.sum((project(camera, X) - points.pixel) ** 2, axis=(1, 2))
    return np.where((X[..., 2] > 0).all(axis=1), cost, np.inf)


def _normal_equations(kin: Kinematics, camera: Camera, points: Points, s: _State) -> tuple[Array, Array]:
    """(H, p, p) and (H, p): unknowns are a turn about the object's origin, a shift, and the joints."""
    frames = kin.forward(s.R, s.t, s.q)
    X = _place(frames, points)  # (H, n, 3)
    n_h, n = X.shape[:2]
    motion = np.zeros((n_h, n, 3, 6 + kin.n_joints))
    motion[..., :3] = -skew(X - s.t[:, None])
    motion[..., 3:6] = np.eye(3)
    for j in range(kin.n_joints):
        axis = np.broadcast_to(frames.axis[:, j, None], X.shape)
        moved = np.cross(axis, X - frames.origin[:, j, None]) if kin.revolute[j] else axis
        motion[..., 6 + j] = moved * kin.moves[points.component, j, None]
    jacobian = (projection_jacobian(camera, X) @ motion).reshape(n_h, 2 * n, -1)
    residual = (project(camera, X) - points.pixel).reshape(n_h, 2 * n, 1)
    transposed = jacobian.transpose(0, 2, 1)
    return transposed @ jacobian, (transposed @ residual)[..., 0]


def _step(kin: Kinematics, camera: Camera, points: Points, s: _State) -> _State:
    normal, gradient = _normal_equations(kin, camera, points, s)
    scale = np.einsum("hii->hi", normal)
    damped = normal + np.einsum("hi,ij->hij", s.damping[:, None] * scale + 1e-9, np.eye(normal.shape[1]))
    delta = -np.linalg.solve(damped, gradient[..., None])[..., 0]
    R = rotation_from_rotvec(delta[:, :3]) @ s.R
    tried = _State(R, s.t + delta[:, 3:6], kin.bound(s.q + delta[:, 6:]), s.cost, s.damping)
    cost = _cost(kin, camera, points, tried)
    better = cost < s.cost
    return _State(
        np.where(better[:, None, None], tried.R, s.R),
        np.where(better[:, None], tried.t, s.t),
        np.where(better[:, None], tried.q, s.q),
        np.where(better, cost, s.cost),
        np.clip(np.where(better, s.damping / 3, s.damping * 4), 1e-8, 1e6),
    )
