"""Other values of joints at which the labels like a hypothesis as well as where a climb has left it.

A climb goes uphill. A marker that comes out from behind its own object, as a drawer's side does, covers more of its
class on its way, be it another marker's, and stops beside its place; a hinged part comes to rest on its neighbour's
labels. Where a part leaves some of its labels unexplained, the votes along all of its joint's range tell of other
places: those are fitted to the contours, and the best of all is the one that counts.
"""

from __future__ import annotations

import numpy as np

from ..geometry.transforms import Array, short_way
from ..image.image_frame import ImageFrame
from .climb_kernels import Value
from .poses import Poses
from .profile_kernels import profile
from .ranked import Ranked
from .surface_model import SpatialModel

_APART = 1.0  # steps from where a joint is: what is nearer a climb has looked at


class OtherJoints:
    """Of one object."""

    def __init__(self, surface: SpatialModel, value: Value, step: float, most: int, plain: float, least: float) -> None:
        """:param step: between values, see `Kinematics.grids`. :param most: poses that are given, the best ones.
        :param least: share of an object's votes that a part must bring where it is.
        :param plain: mean vote of a marker's pixel from which on all of it is explained.
        """
        kin = surface.kinematics
        self._surface, self._value, self._most, self._plain, self._least = surface, value, most, plain, least
        self._grids = kin.grids(step)
        steps = np.diff(self._grids[:, :2], axis=1) if self._grids.shape[1] > 1 else np.zeros((kin.n_joints, 1))
        self._apart = _APART * np.nan_to_num(steps)  # (J, 1)

    def of(self, frame: ImageFrame, poses: Poses, votes: float) -> Ranked:
        """The first hypothesis with one joint elsewhere, where its votes have a peak that is no less than half as high
        as its own; the best first. :param votes: its own."""
        along, surface, q = np.empty(self._grids.shape), self._surface, poses.q[0]
        profile(
            surface.compiled, surface.kinematics.chain, frame.view, surface.limits, self._value,
            surface.kinematics.carried, self._plain, self._grids, poses.R[0], poses.t[0], q, along,
        )  # fmt: skip
        joint, at = np.nonzero(self._peaks(along, q, votes))
        if not len(joint):
            return Ranked(poses[:0], np.zeros(0))
        best = np.argsort(-along[joint, at], kind="stable")[: self._most]
        others = poses[np.zeros(len(best), int)]
        bent = others.q.copy()
        bent[np.arange(len(best)), joint[best]] = self._grids[joint[best], at[best]]
        return Ranked(Poses(others.R, others.t, bent), along[joint[best], at[best]])

    def _peaks(self, along: Array, q: Array, votes: float) -> np.ndarray:
        """(J, n) bool."""
        if not along.size:
            return np.zeros(along.shape, bool)
        beside = np.full((len(along), along.shape[1] + 2), -np.inf)
        beside[:, 1:-1] = along
        peak = (along >= beside[:, :-2]) & (along > beside[:, 2:])
        without = np.where(np.isfinite(along), along, np.inf).min(axis=1, keepdims=True)
        away = short_way(self._grids - q[:, None], self._surface.kinematics.endless[:, None])
        far = np.abs(away) > self._apart
        return np.asarray(peak & far & (along > (without + votes) / 2) & (along > without + self._least * votes))
