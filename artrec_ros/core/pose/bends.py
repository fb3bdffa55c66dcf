"""Where the joints that carry a component may have taken it, and so where an object may be of which it shows."""

from __future__ import annotations

import numpy as np

from ..geometry.spread import spread
from .poses import Poses
from .surface_model import SpatialModel


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
