"""Angles and rigid motions of space.

Conventions. Image: a pixel's centre has integer coordinates, x to the right, y down; an angle goes
from +x towards +y. Space: right-handed, metres; the camera's optical frame looks along +z (REP-103).
`T_target_source` maps source coordinates to target coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def wrap_angle(angle: ArrayLike, period: float = 2 * np.pi) -> Array:
    """Angle modulo `period`, in [-period/2, period/2)."""
    return (np.asarray(angle, float) + period / 2) % period - period / 2


def short_way(bent: Array, endless: NDArray[np.bool_]) -> Array:
    """Differences (..., J) of joints' values; of those that turn without limit (J,) the short way round."""
    return np.where(endless, wrap_angle(bent), bent)


def readonly(values: ArrayLike) -> Array:
    """A float64 copy of `values` that cannot be written to."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def numbers_of(index: NDArray | list[int]) -> NDArray:
    """Of the rows that an index asks for."""
    index = np.array(index, np.intp) if isinstance(index, list) else index
    return index.nonzero()[0] if index.dtype == np.bool_ else index


def rows_of(index: NDArray | list[int] | slice, *values: NDArray) -> tuple[NDArray, ...]:
    """Rows of arrays, each as `values[index]`, which takes three times as long where there are few."""
    if isinstance(index, slice):
        return tuple([v[index] for v in values])
    rows = numbers_of(index)
    return tuple([v.take(rows, 0) for v in values])


def rotation_from_rotvec(rotvec: ArrayLike) -> Array:
    """Rodrigues' formula on a batch: (..., 3) rotation vectors to (..., 3, 3) matrices."""
    v = np.asarray(rotvec, float)
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    safe = np.where(angle < 1e-12, 1.0, angle)
    K = skew(v)
    # Taylor values of sin(a)/a and (1-cos a)/a^2 near zero
    s = np.where(angle < 1e-6, 1.0 - angle**2 / 6, np.sin(angle) / safe)
    c = np.where(angle < 1e-6, 0.5 - angle**2 / 24, (1 - np.cos(angle)) / safe**2)
    return np.eye(3) + s * K + c * (K @ K)


def rotvec_from_rotation(R: Array) -> Array:
    """(..., 3) rotation vectors of rotations (..., 3, 3); of half a turn, whose sense is not known, one of both."""
    axis = (
        np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]], axis=-1) / 2
    )
    sine = np.sqrt((axis**2).sum(axis=-1))
    angle = np.arctan2(sine, (np.trace(R, axis1=-2, axis2=-1) - 1) / 2)
    unit = axis / np.maximum(sine, 1e-9)[..., None]
    half = (sine < 1e-6) & (angle > 1)  # the axis is what half a turn leaves in place
    if half.any():
        kept = (R[half] + np.eye(3)) / 2
        column = kept[np.arange(len(kept)), :, np.argmax(np.diagonal(kept, axis1=1, axis2=2), axis=1)]
        unit[half] = column / np.linalg.norm(column, axis=1, keepdims=True)
    return np.asarray(unit * angle[..., None], np.float64)


def skew(v: Array) -> Array:
    """Cross-product matrices: (..., 3) to (..., 3, 3)."""
    zero = np.zeros_like(v[..., 0])
    rows = [zero, -v[..., 2], v[..., 1], v[..., 2], zero, -v[..., 0], -v[..., 1], v[..., 0], zero]
    return np.stack(rows, axis=-1).reshape(*v.shape[:-1], 3, 3)


def rotation_from_rpy(rpy: ArrayLike) -> Array:
    """Fixed-axis roll, pitch, yaw as in URDF: R = Rz(yaw) Ry(pitch) Rx(roll)."""
    r, p, y = np.asarray(rpy, float)
    cr, sr, cp, sp, cy, sy = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(y), np.sin(y)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def quaternion_from_rotation(R: ArrayLike) -> Array:
    """Unit quaternion (x, y, z, w), w >= 0, of a (3, 3) rotation matrix."""
    m = np.asarray(R, float)
    # The eigenvector of the largest eigenvalue is stable for every rotation (Bar-Itzhack 2000).
    K = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], 0],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    q = np.linalg.eigh(K)[1][:, -1]
    return -q if q[3] < 0 else q


def rotation_from_quaternion(q: ArrayLike) -> Array:
    """(3, 3) rotation matrix of a quaternion (x, y, z, w) of any length but zero."""
    x, y, z, w = np.asarray(q, float) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@dataclass(frozen=True)
class Pose:
    """A rigid motion T_target_source: x_target = rotation @ x_source + position (metres)."""

    rotation: Array
    position: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotation", readonly(self.rotation).reshape(3, 3))
        object.__setattr__(self, "position", readonly(self.position).reshape(3))

    @classmethod
    def identity(cls) -> Pose:
        return cls(np.eye(3), np.zeros(3))

    @classmethod
    def from_xyz_rpy(cls, xyz: ArrayLike, rpy: ArrayLike = (0.0, 0.0, 0.0)) -> Pose:
        """URDF's `origin`: translation in metres, fixed-axis roll, pitch, yaw in radians."""
        return cls(rotation_from_rpy(rpy), np.asarray(xyz, float))

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(self.rotation @ other.rotation, self.rotation @ other.position + self.position)

    def inverse(self) -> Pose:
        return Pose(self.rotation.T, -self.rotation.T @ self.position)

    def apply(self, points: ArrayLike) -> Array:
        """(n, 3) source points to (n, 3) target points."""
        return np.asarray(points, float) @ self.rotation.T + self.position

    @property
    def quaternion(self) -> Array:
        return quaternion_from_rotation(self.rotation)
