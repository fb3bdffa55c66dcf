"""Poses and joints through the middles of markers, a hypothesis at a time (Levenberg and Marquardt)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, lean, melted
from ..geometry.pixel_kernels import Lens, project
from ..model.chain_kernels import Chain, copy_frame, place_seen, turn_by
from .fit_kernels import solve
from .placed_kernels import Joints
from .surface_kernels import LEAST_DEPTH_M

_BEYOND, _WEAK = 20.0, 0.1  # what a joint beyond its limits costs, of a radian, and one at its limit
_STEPS = 14  # of a fit
_DAMPED, _LESS, _MORE = 1e-2, 0.3, 4.0  # Marquardt: at first, and how it changes after steps that help or do not
_LEAST = 1e-6  # of the normal equations' diagonal: what nothing determines stays
_LONGEST = 1.0  # step: of the depth, in radians and units of joints
_ASIDE = 1e-5  # of the depth, for derivatives of pixels, which a lens bends


class Wanted(NamedTuple):
    """Where n markers are to be seen, and how that weighs."""

    component: Any  # (n,)
    middle: Any  # (n, 3) metres, in the components' frames
    at: Any  # (n, 2) pixels
    scale: Any  # (n,) pixels per metre
    place_px: float  # deviations
    size_share: float
    focal_px: float


class Room(NamedTuple):
    """Scratch arrays of one hypothesis."""

    R: Any  # (C, 3, 3) frames of its components
    frame_t: Any  # (C, 3)
    axis: Any  # (J, 3)
    origin: Any  # (J, 3)
    scratch: Any  # (3, 3, 3)
    A: Any  # (6 + J, 6 + J) normal equations
    b: Any
    damped: Any  # (6 + J, 6 + J) the same with what keeps steps short
    x: Any  # (6 + J,) a step
    first: Any  # (6 + J,) int64
    row: Any  # (3, 6 + J) derivatives of a middle's u, v and size
    point: Any  # (3,)


@lean
def _middle(w: Wanted, n: int, room: Room) -> None:
    """Fill `room.point` with where the middle of marker `n` is, before the camera."""
    A, b, m = room.R[w.component[n]], room.frame_t[w.component[n]], w.middle[n]
    for i in range(3):
        room.point[i] = b[i] + A[i, 0] * m[0] + A[i, 1] * m[1] + A[i, 2] * m[2]
    room.point[2] = max(room.point[2], LEAST_DEPTH_M)


@lean
def _off(w: Wanted, n: int, lens: Lens, point: Any) -> tuple[float, float, float]:
    """By how many deviations a middle's place and size are not as they are to be."""
    u, v = project(point[0], point[1], point[2], lens)
    size = math.log(w.focal_px / point[2] / w.scale[n]) / w.size_share
    return (u - w.at[n, 0]) / w.place_px, (v - w.at[n, 1]) / w.place_px, size


@lean
def _bent(joints: Joints, j: int, q: float) -> tuple[float, float]:
    """What joint `j` costs at `q`, as a residual, and by how much more for each of its units."""
    if joints.endless[j]:
        return 0.0, 0.0
    most, off = max((joints.upper[j] - joints.lower[j]) / 2, 1e-9), q - (joints.upper[j] + joints.lower[j]) / 2
    cost, slope = _WEAK * off / most, _WEAK * joints.unit[j] / most
    if abs(off) > most:
        cost += _BEYOND * (abs(off) - most) / joints.unit[j]
        slope += math.copysign(_BEYOND, off)
    return cost, slope


@melted
def _cost(w: Wanted, chain: Chain, joints: Joints, lens: Lens, R: Any, t: Any, q: Any, room: Room) -> float:
    """Sum of squares of one hypothesis, whose frames are filled in."""
    place_seen(chain, R, t, q, room.R, room.frame_t, room.axis, room.origin, room.scratch)
    cost = 0.0
    for n in range(len(w.component)):
        _middle(w, n, room)
        du, dv, size = _off(w, n, lens, room.point)
        cost += du * du + dv * dv + size * size
    for j in range(len(q)):
        bent, _ = _bent(joints, j, q[j])
        cost += bent * bent
    return cost


@lean
def _slopes(w: Wanted, n: int, lens: Lens, t: Any, joints: Joints, room: Room) -> None:
    """Fill `room.row` with how the place and size of the middle in `room.point` change with each parameter."""
    x, y, z = room.point[0], room.point[1], room.point[2]
    u, v = project(x, y, z, lens)
    h = _ASIDE * z
    ux, vx = project(x + h, y, z, lens)
    uy, vy = project(x, y + h, z, lens)
    uz, vz = project(x, y, z + h, lens)
    k, c = 1.0 / (h * w.place_px), w.component[n]
    depth, sx, sy, sz = max(t[2], LEAST_DEPTH_M), x - t[0], y - t[1], z - t[2]
    for i in range(len(room.x)):
        dx, dy, dz = 0.0, 0.0, 0.0
        if i < 3:
            dx, dy, dz = (depth if i == 0 else 0.0), (depth if i == 1 else 0.0), (depth if i == 2 else 0.0)
        elif i == 3:
            dy, dz = -sz, sy
        elif i == 4:
            dx, dz = sz, -sx
        elif i == 5:
            dx, dy = -sy, sx
        elif joints.moves[c, i - 6]:
            j = i - 6
            a, o, unit = room.axis[j], room.origin[j], joints.unit[j]
            dx, dy, dz = a[0] * unit, a[1] * unit, a[2] * unit
            if joints.revolute[j]:
                px, py, pz = x - o[0], y - o[1], z - o[2]
                dx, dy, dz = dy * pz - dz * py, dz * px - dx * pz, dx * py - dy * px
        room.row[0, i] = k * ((ux - u) * dx + (uy - u) * dy + (uz - u) * dz)
        room.row[1, i] = k * ((vx - v) * dx + (vy - v) * dy + (vz - v) * dz)
        room.row[2, i] = -dz / z / w.size_share


@melted
def _equations(w: Wanted, joints: Joints, lens: Lens, free: Any, t: Any, q: Any, room: Room) -> None:
    """Fill the normal equations of one hypothesis, whose frames are there; what is not free (6 + J,) stays."""
    A, b, row = room.A, room.b, room.row
    A[:], b[:] = 0.0, 0.0
    for n in range(len(w.component)):
        _middle(w, n, room)
        off = _off(w, n, lens, room.point)
        _slopes(w, n, lens, t, joints, room)
        for e in range(3):
            for i in range(len(b)):
                b[i] += row[e, i] * off[e]
                for k in range(i + 1):
                    A[i, k] += row[e, i] * row[e, k]
    for j in range(len(q)):
        bent, slope = _bent(joints, j, q[j])
        A[6 + j, 6 + j] += slope * slope
        b[6 + j] += slope * bent
    for i in range(len(b)):
        if not free[i]:
            A[i, :], A[:, i], A[i, i], b[i] = 0.0, 0.0, 1.0, 0.0


@lean
def _step(damped: float, room: Room) -> None:
    """Fill `room.x` with the step."""
    for i in range(len(room.b)):
        for k in range(i + 1):
            room.damped[i, k] = room.A[i, k]
        room.damped[i, i] += damped * room.A[i, i] + _LEAST
    solve(room.damped, room.b, room.x, room.first)
    for i in range(len(room.x)):
        room.x[i] = -min(max(room.x[i], -_LONGEST), _LONGEST)


@lean
def _take(joints: Joints, R: Any, t: Any, q: Any, R_next: Any, t_next: Any, q_next: Any, room: Room) -> None:
    """Fill R_next (3, 3), t_next (3,), q_next (J,) with a hypothesis after the step."""
    copy_frame(R, t, R_next, t_next)
    turn_by(room.x[3], room.x[4], room.x[5], R_next, room.scratch)
    depth = max(t[2], LEAST_DEPTH_M)
    for i in range(3):
        t_next[i] += depth * room.x[i]
    for j in range(len(q)):
        q_next[j] = q[j] + joints.unit[j] * room.x[6 + j]


@jit
def room_for(n_components: int, n_joints: int) -> Room:
    n = 6 + n_joints
    return Room(
        np.empty((n_components, 3, 3)), np.empty((n_components, 3)), np.empty((n_joints, 3)), np.empty((n_joints, 3)),
        np.empty((3, 3, 3)), np.empty((n, n)), np.empty(n), np.empty((n, n)), np.empty(n), np.empty(n, np.int64),
        np.empty((3, n)), np.empty(3),
    )  # fmt: skip


@jit
def go_through(
    w: Wanted, chain: Chain, joints: Joints, lens: Lens, free: Any, R: Any, t: Any, q: Any, cost: Any
) -> None:  # fmt: skip
    """Bring hypotheses R (H, 3, 3), t (H, 3), q (H, J), in place, to where their markers' middles are to be seen, with
    joints about their limits, and fill cost (H,).

    :param free: (6 + J,) parameters, as of `placed_kernels`: those that are moved.
    """
    room = room_for(len(chain.parent), q.shape[1])
    R_next, t_next, q_next = np.empty((3, 3)), np.empty(3), np.empty(q.shape[1])
    for h in range(len(R)):
        damped, is_new = _DAMPED, True
        cost[h] = _cost(w, chain, joints, lens, R[h], t[h], q[h], room)
        for _ in range(_STEPS):
            if is_new:
                _equations(w, joints, lens, free, t[h], q[h], room)
            _step(damped, room)
            _take(joints, R[h], t[h], q[h], R_next, t_next, q_next, room)
            less = _cost(w, chain, joints, lens, R_next, t_next, q_next, room)
            is_new = less < cost[h]
            if is_new:
                copy_frame(R_next, t_next, R[h], t[h])
                q[h] = q_next
                cost[h] = less
            damped *= _LESS if is_new else _MORE
