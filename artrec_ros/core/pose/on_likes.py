"""Poses of an object with joints that lay its required component where it has a like one, all joints sought anew.

One place off along a row of like parts, or from a chain's other end, joints bend the others to where they are seen for
all that: a search that comes to such a pose finds nothing better near it.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..image.image_frame import ImageFrame
from .exchanges import OFF, may_be_taken_for
from .lookalikes import Lookalikes
from .poses import Poses

if TYPE_CHECKING:
    from .finder import WholeObjectFinder


class OnLikes:
    """Those of one object. :ivar any: whether there are."""

    def __init__(self, finder: WholeObjectFinder, lookalikes: Lookalikes) -> None:
        """:param lookalikes: the object's."""
        surface, config = finder.surface, finder.config
        self._finder, self._lookalikes = finder, lookalikes.on_others()
        self.any = surface.kinematics.n_joints > 0 and len(self._lookalikes) > 0
        self._grids = surface.kinematics.grids(config.search.joint_step)
        self._most = config.facing.rivals if finder.facing else config.search.flip_keep
        self._size = np.sqrt(surface.area[surface.markers])

    def begun(self, frame: ImageFrame, pose: Poses) -> Poses:
        """A few of a pose, the best first, as they are before a climb."""
        finder = self._finder
        poses = finder.standing(frame, self._lookalikes.of(pose))
        poses = finder.surface.search_joints(frame, poses, self._grids)
        return finder.ranked(frame, poses).best(self._most, finder.config.search).poses

    def of(self, frame: ImageFrame, pose: Poses, seen: Collection[int]) -> Poses:
        """A few after a climb, that differ; where all components are seen those alone that look the same throughout,
        for others lack one of them.

        :param seen: components that are.
        """
        begun = self.begun(frame, pose)
        if len(seen) == len(self._finder.target.model.components):
            begun = begun[np.flatnonzero(self.same(frame.camera, pose, begun))]
        if not len(begun):
            return begun
        return self._finder.looked_again(frame, begun).best(self._most, self._finder.config.search).poses

    @cached_property
    def _like(self) -> NDArray[np.bool_]:
        """(M, M) which markers may be taken for each other."""
        return may_be_taken_for(self._finder.surface, self._finder.surface.markers)

    def same(self, camera: Camera, pose: Poses, others: Poses) -> NDArray[np.bool_]:
        """(K,) whether others have each marker, seen or not, on a like one of a pose: nothing hidden tells these from
        it."""
        at = self._finder.through_middles.places(Poses.concatenate([pose, others]), self._finder.surface.markers)
        pixels, size_px = project(camera, at), self._size * camera.focal_px / at[..., 2]
        off = np.linalg.norm(pixels[1:, :, None] - pixels[0], axis=3)  # (K, M, M)
        near = off < OFF * np.minimum(size_px[1:, :, None], size_px[0])
        return np.asarray((near & self._like).any(axis=2).all(axis=1))
