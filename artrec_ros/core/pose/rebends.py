"""Other bends for an object whose joints carry joints.

A limb that is seen under slant looks the same when it leans to the camera and away from it. Its own labels do not tell
which; what hangs on it does: with the wrong one it is nowhere, or lies on its neighbours' labels, shifted by a link. A
search joint by joint has chosen by then; one that follows several ways to bend the object side by side has not.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..base.config import SearchConfig
from ..image.image_frame import ImageFrame
from .bend_kernels import Branches, bend
from .poses import Poses
from .surface_model import SpatialModel


class Rebends:
    """Of one object."""

    def __init__(self, surface: SpatialModel, search: SearchConfig, hidden_cost: float) -> None:
        """:param hidden_cost: of what speaks against itself, votes per pixel."""
        kin = surface.kinematics
        self._surface, self._hidden_cost = surface, float(hidden_cost)
        self._grids, self._ways = kin.grids(search.bend_step).copy(), search.bend_ways
        self._ends = np.stack([kin.lower, kin.upper], axis=1)
        self._ends[kin.endless] = -np.inf, np.inf
        last = np.isfinite(self._grids).sum(axis=1) - 1
        self._grids[kin.endless, last[kin.endless]] = np.nan  # is the first one again
        joint_of = np.array(kin.joint_of)
        self._branches = Branches(kin.line, (kin.moves.sum(axis=1) == 1) & (joint_of >= 0), *surface.by_component)
        self.any = bool((kin.moves.sum(axis=1) > 1).any())  # else a climb finds all there is

    @cached_property
    def first_parts(self) -> NDArray[np.bool_]:
        """(K, M) markers of the first half of the components from the root on, of the first fourth, and so on down to
        one component."""
        s, line = self._surface, self._branches.line
        numbers = [len(line) >> k for k in range(1, len(line).bit_length())]
        return np.stack([np.isin(s.component[s.markers], line[:n]) for n in numbers])

    def of(self, frame: ImageFrame, poses: Poses) -> Poses:
        """The first hypothesis with all joints where the labels like its components best together."""
        surface, found = self._surface, np.empty((self._ways, self._surface.kinematics.n_joints))
        n = bend(
            surface.compiled, surface.kinematics.chain, self._branches, poses.R[0], poses.t[0], self._grids, self._ends,
            frame.view, surface.limits, self._hidden_cost, found,
        )  # fmt: skip
        same = poses[np.zeros(n, int)]
        return Poses(same.R, same.t, surface.kinematics.bound(found[:n]))
