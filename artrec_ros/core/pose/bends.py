"""Where the joints that carry a component may have taken it, and so where an object may be of which it shows."""

from __future__ import annotations

import numpy as np

from ..geometry.transforms import Array, rotation_from_quaternion
from .surface_model import Poses, SpatialModel


class Bends:
    """D ways to bend an object: joints mid-range, and then spread over the range of those that carry one component.

    :ivar q: (D, J). :ivar R, t: (D, 3, 3), (D, 3) the component's frames in the object's.
    """

    def __init__(self, surface: SpatialModel, component: int, draws: int) -> None:
        """:param draws: ways besides the first one, where a joint carries the component."""
        kin = surface.kinematics
        path = np.flatnonzero(kin.moves[component])
        self.q = np.tile(kin.middle, (1 + draws * bool(len(path)), 1))
        self.q[1:, path] = kin.lower[path] + spread(len(self) - 1, len(path)) * (kin.upper - kin.lower)[path]
        frames = kin.in_object(self.q)
        self.R, self.t = frames.R[:, component], frames.t[:, component]

    def __len__(self) -> int:
        return len(self.q)

    def of(self, poses: Poses) -> Poses:
        """(H * D) poses of an object that leave the component where it is under each of H, joints mid-range."""
        R_c, t_c = poses.R @ self.R[0], np.einsum("hij,j->hi", poses.R, self.t[0]) + poses.t
        R = R_c[:, None] @ self.R.transpose(0, 2, 1)
        t = t_c[:, None] - np.einsum("hdij,dj->hdi", R, self.t)
        return Poses(R.reshape(-1, 3, 3), t.reshape(-1, 3), np.tile(self.q, (len(poses), 1)))


def spread(n: int, dimensions: int) -> Array:
    """(n, d) evenly spread points of the unit cube: multiples of the powers of Roberts' generalised golden ratio."""
    ratio = 2.0
    for _ in range(40):
        ratio = (1 + ratio) ** (1 / (dimensions + 1))
    return np.asarray((0.5 + np.arange(n)[:, None] * ratio ** -np.arange(1.0, dimensions + 1)) % 1, np.float64)


def all_turns(n: int) -> Array:
    """(n, 3, 3) evenly spread over all turns."""
    return turns_at(spread(n, 3))


def turns_at(even: Array) -> Array:
    """(n, 3, 3) spread as evenly over all turns as (n, 3) points are over the unit cube (Shoemake, 1992)."""
    share, a, b = even[:, 0], 2 * np.pi * even[:, 1], 2 * np.pi * even[:, 2]
    near, far = np.sqrt(1 - share), np.sqrt(share)
    quaternions = np.column_stack([near * np.sin(a), near * np.cos(a), far * np.sin(b), far * np.cos(b)])
    return np.stack([rotation_from_quaternion(q) for q in quaternions])
