"""Forward kinematics, a hypothesis at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, lean, melted

_LEAST_NEARER = 0.01  # of a ball that the camera is in


class Chain(NamedTuple):
    """A model's joints as arrays over its C components, parents first."""

    parent: Any  # (C,), -1: the object's frame itself
    joint_of: Any  # (C,) index into the joint vector, -1: fixed
    R: Any  # (C, 3, 3) joint frame in the parent
    t: Any  # (C, 3)
    axis: Any  # (C, 3)
    revolute: Any  # (C,) bool
    moves: Any  # (J, C) bool: components that a joint carries
    ball: Any  # (C,) radius of those that are balls, metres; 0: it is none
    middle: Any  # (C, 3) of these, in their own frames


@lean
def about_axis(axis: Any, angle: float, out: Any) -> None:
    """Rotation matrix of an angle about a unit axis (Rodrigues)."""
    s, c = math.sin(angle), math.cos(angle)
    x, y, z = axis[0], axis[1], axis[2]
    k = 1 - c
    out[0, 0], out[0, 1], out[0, 2] = c + x * x * k, x * y * k - z * s, x * z * k + y * s
    out[1, 0], out[1, 1], out[1, 2] = y * x * k + z * s, c + y * y * k, y * z * k - x * s
    out[2, 0], out[2, 1], out[2, 2] = z * x * k - y * s, z * y * k + x * s, c + z * z * k


@lean
def multiply(A: Any, B: Any, out: Any) -> None:
    """A B of 3 by 3 matrices; `out` is neither."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@lean
def copy_rotation(R: Any, out: Any) -> None:
    """Copy (3, 3) without room for the case that both overlap."""
    for i in range(3):
        for j in range(3):
            out[i, j] = R[i, j]


@lean
def turn_by(x: float, y: float, z: float, R: Any, scratch: Any) -> None:
    """Turn R (3, 3) by a rotation vector of the camera's axes; scratch (3, 3, 3)."""
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < 1e-12:
        return
    axis = scratch[2, 0]
    axis[0], axis[1], axis[2] = x / angle, y / angle, z / angle
    about_axis(axis, angle, scratch[0])
    multiply(scratch[0], R, scratch[1])
    copy_rotation(scratch[1], R)


@lean
def copy_frame(R: Any, t: Any, R_out: Any, t_out: Any) -> None:
    """Copy a rotation (3, 3) and a place (3,)."""
    copy_rotation(R, R_out)
    for i in range(3):
        t_out[i] = t[i]


@melted
def place(chain: Chain, c: int, R: Any, t: Any, value: float, axis: Any, origin: Any, turn: Any, rest: Any) -> None:
    """Frame of component `c` at a joint value, from its parent's; R (C, 3, 3), t (C, 3) of one hypothesis.

    :param axis, origin: (3,) filled with the joint's place in the camera.
    :param turn, rest: (3, 3) scratch.
    """
    A, b = R[chain.parent[c]], t[chain.parent[c]]
    multiply(A, chain.R[c], rest)
    for i in range(3):
        axis[i] = rest[i, 0] * chain.axis[c, 0] + rest[i, 1] * chain.axis[c, 1] + rest[i, 2] * chain.axis[c, 2]
        origin[i] = b[i] + A[i, 0] * chain.t[c, 0] + A[i, 1] * chain.t[c, 1] + A[i, 2] * chain.t[c, 2]
        t[c, i] = origin[i]
    if chain.joint_of[c] >= 0 and chain.revolute[c]:
        about_axis(chain.axis[c], value, turn)
        multiply(rest, turn, R[c])
    else:
        for i in range(3):
            for j in range(3):
                R[c, i, j] = rest[i, j]
            if chain.joint_of[c] >= 0:
                t[c, i] += axis[i] * value


@melted
def place_all(
    chain: Chain, R_object: Any, t_object: Any, q: Any, R: Any, t: Any, axis: Any, origin: Any, scratch: Any
) -> None:
    """Fill the frames R (C, 3, 3), t (C, 3) and joints (J, 3) of one hypothesis (3, 3), (3,), (J,).

    :param scratch: (3, 3, 3).
    """
    for c in range(len(chain.parent)):
        j = chain.joint_of[c]
        if chain.parent[c] < 0:
            copy_frame(R_object, t_object, R[c], t[c])
        elif j >= 0:
            place(chain, c, R, t, q[j], axis[j], origin[j], scratch[0], scratch[1])
        else:
            place(chain, c, R, t, 0.0, scratch[2, 0], scratch[2, 1], scratch[0], scratch[1])


@melted
def face_camera(chain: Chain, R: Any, t: Any) -> None:
    """Turn the frames (C, 3, 3), (C, 3) of components that are balls so that their discs look like them: square to the
    line of sight, and as much nearer as a ball's outline is, which the rays that touch it draw."""
    for c in range(len(chain.ball)):
        if chain.ball[c] > 0.0:
            face_camera_alone(chain.ball[c], chain.middle[c], R[c], t[c])


@melted
def see(chain: Chain, c: int, R: Any, t: Any, A: Any, b: Any) -> None:
    """Fill A (3, 3), b (3,) with the frame of component `c` as the camera sees it, of R (C, 3, 3), t (C, 3)."""
    copy_frame(R[c], t[c], A, b)
    if chain.ball[c] > 0.0:
        face_camera_alone(chain.ball[c], chain.middle[c], A, b)


@lean
def face_camera_alone(radius: float, m: Any, A: Any, b: Any) -> None:
    """`face_camera` of one ball, its middle m (3,) in its own frame A (3, 3), b (3,)."""
    x, y, z = (
        b[0] + A[0, 0] * m[0] + A[0, 1] * m[1] + A[0, 2] * m[2],
        b[1] + A[1, 0] * m[0] + A[1, 1] * m[1] + A[1, 2] * m[2],
        b[2] + A[2, 0] * m[0] + A[2, 1] * m[1] + A[2, 2] * m[2],
    )
    far = max(math.sqrt(x * x + y * y + z * z), 1e-9)
    nearer = math.sqrt(max(1.0 - (radius / far) ** 2, _LEAST_NEARER))
    x, y, z = x / far, y / far, z / far
    along = max(math.sqrt(1.0 - x * x), 1e-9)  # of the image's x axis, square to the line of sight
    A[0, 0], A[1, 0], A[2, 0] = along, -x * y / along, -x * z / along
    A[0, 2], A[1, 2], A[2, 2] = -x, -y, -z
    A[0, 1] = A[1, 2] * A[2, 0] - A[2, 2] * A[1, 0]
    A[1, 1] = A[2, 2] * A[0, 0] - A[0, 2] * A[2, 0]
    A[2, 1] = A[0, 2] * A[1, 0] - A[1, 2] * A[0, 0]
    for i in range(3):
        b[i] = -nearer * far * A[i, 2] - A[i, 0] * m[0] - A[i, 1] * m[1] - A[i, 2] * m[2]


@melted
def place_seen(
    chain: Chain, R_object: Any, t_object: Any, q: Any, R: Any, t: Any, axis: Any, origin: Any, scratch: Any
) -> None:
    """As `place_all`; balls as the camera sees them: `face_camera`."""
    place_all(chain, R_object, t_object, q, R, t, axis, origin, scratch)
    face_camera(chain, R, t)


@lean
def place_points(R: Any, t: Any, points: Any, component: Any, out: Any) -> None:
    """Fill out (H, n, 3) with the camera coordinates of points (n, 3) on components (n,) whose frames are given."""
    for h in range(len(R)):
        for n in range(len(points)):
            c, x, y, z = component[n], points[n, 0], points[n, 1], points[n, 2]
            for i in range(3):
                out[h, n, i] = t[h, c, i] + R[h, c, i, 0] * x + R[h, c, i, 1] * y + R[h, c, i, 2] * z


@jit
def face_cameras(chain: Chain, R: Any, t: Any) -> None:
    """`face_camera` of hypotheses' frames (H, C, 3, 3), (H, C, 3)."""
    for h in range(len(R)):
        face_camera(chain, R[h], t[h])


@jit
def forward(chain: Chain, R_object: Any, t_object: Any, q: Any, R: Any, t: Any, axis: Any, origin: Any) -> None:
    """Fill the frames R (H, C, 3, 3), t (H, C, 3) and joints (H, J, 3) of hypotheses (H, 3, 3), (H, 3), (H, J)."""
    scratch = np.empty((3, 3, 3))
    for h in range(len(R)):
        place_all(chain, R_object[h], t_object[h], q[h], R[h], t[h], axis[h], origin[h], scratch)
