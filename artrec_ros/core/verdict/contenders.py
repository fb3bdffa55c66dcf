"""Candidates of one target that contend for pixels: which of these each owns, and which it looks at."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.transforms import Array
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from .claims import corners_of

_ROUNDED_PX = 1.0  # a pixel that is looked up, and one that an owner's silhouette fills, are rounded


@dataclass(frozen=True, eq=False)
class Contenders:
    """One target's H hypotheses.

    :param corners: (H, n, 2) pixels of the corners of all boxes and markers.
    :param boxes: (H, 2, 2) least and greatest x, y of all pixels that the votes for each look at: those of its corners,
        of the rings around its contours, and what a lens bends out.
    """

    finder: WholeObjectFinder
    poses: Poses
    corners: Array
    boxes: Array

    @property
    def may_swell(self) -> bool:
        """Whether its markers may look larger than they are; in crowds nobody has the time to look."""
        facing = self.finder.config.facing
        few = len(self.poses) <= facing.rivals * facing.swollen_most
        return self.finder.facing and few and len(self.finder.swollen) > 0

    @classmethod
    def of(cls, finder: WholeObjectFinder, poses: Poses, camera: Camera) -> Contenders:
        corners = corners_of(finder.surface, camera, poses)
        low, high = corners.min(axis=1), corners.max(axis=1)
        margin = finder.surface.votes.ring_px + _ROUNDED_PX + finder.config.facing.swollen_px * finder.facing
        if camera.bent:  # what lies between corners is moved otherwise, by no more than they differ
            plain = replace(camera, distortion=np.zeros(0))
            moved = np.subtract(corners, corners_of(finder.surface, plain, poses))
            margin = margin + np.linalg.norm(np.ptp(moved, axis=1), axis=1, keepdims=True)
        return cls(finder, poses, corners, np.stack([low - margin, high + margin], axis=1))

    def hulls(self, row: int) -> list[NDArray[np.float32]]:
        """As `silhouette` has them."""
        corners = self.corners[row].astype(np.float32)
        return [corners[first:last] for first, last in pairwise(self.finder.surface.hulls.starts)]
