"""Other bends for joints beyond which an object's parts are not where a hypothesis has them.

A limb that is seen under slant looks the same when it leans to the camera and away from it. Its own labels do not tell
which; what hangs on it does: with the wrong one it is nowhere. A search joint by joint has then chosen already.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .surface_model import Poses, SpatialModel


class Rebends:
    """Of one object."""

    def __init__(self, surface: SpatialModel, grids: Array) -> None:
        """:param grids: (J, n) values of joints, see `Kinematics.grids`."""
        kin = surface.kinematics
        self._surface, self._grids, self._moves = surface, grids, kin.moves
        self._carried = kin.moves[kin.carried].T & ~np.eye(kin.n_joints, dtype=bool)  # (J, J) joints each one moves
        self._own = np.array(kin.joint_of)[:, None] == np.arange(kin.n_joints)  # (C, J)

    @property
    def any(self) -> bool:
        """Whether a joint carries another one: else a climb finds all there is."""
        return bool(self._carried.any())

    def joints(self, lacking: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Joints that move some of the components (C,) and joints besides."""
        return np.flatnonzero((self._moves & ~self._own)[lacking].any(axis=0))

    def of(self, frame: ImageFrame, poses: Poses, joint: int) -> Poses:
        """The first hypothesis with this joint at all its values, and at each the joints that it moves where the labels
        like their components best."""
        q, values = poses.q[0], self._grids[joint]
        values = values[np.abs(values - q[joint]) > np.nanmin(np.diff(values))]  # the rest a climb has looked at
        grids = np.full_like(self._grids, np.nan)
        grids[:, 0] = q
        grids[self._carried[joint]] = self._grids[self._carried[joint]]
        found = []
        for value in values:
            grids[joint, 0] = value
            found.append(self._surface.search_joints(frame, poses[:1], grids))
        return Poses.concatenate([poses[:0], *found])
