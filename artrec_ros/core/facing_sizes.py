"""At which sizes objects that face the camera are tried about small components."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray

from .base.config import RecognizerConfig
from .geometry.projection import project
from .geometry.range_limits import ScaleLimits
from .geometry.transforms import Array
from .image.image_frame import ImageFrame
from .pose.finder import WholeObjectFinder
from .pose.ranked import Ranked, first_of_each
from .pose.surface_model import Poses


class FacingSizes:
    """A small marker looks larger than it is where the lens blurs it, the ink runs, or what is around it is dark: by a
    pixel all around, a patch of 12 px looks a sixth larger. Its own pixels then want a scale at which no other component
    is where it should be, while a wrong turn may lay one on another's pixels. So a smaller scale is tried for the whole
    object as well, with markers that look as large as they are and with such that look larger.

    :ivar finders: of markers that look as large as they are, and of such that look larger.
    """

    def __init__(self, finder: WholeObjectFinder, config: RecognizerConfig) -> None:
        self.finders = finder, finder.swollen[-1]
        self._apart = len(finder.target.model.components) > 1  # else nothing but its own pixels tells its scale
        self._ratio = config.facing.scale_ratio

    def of(
        self, frame: ImageFrame, poses: Poses, small: NDArray[np.bool_], limits: ScaleLimits
    ) -> tuple[Ranked, NDArray[np.int64]]:
        """Hypotheses with their joints and votes, each at its best scale, and which of `finders` sees it so (H,).

        :param small: (H,) whose component has few pixels. :param limits: of the scale.
        """
        finder, every = self.finders[0], np.arange(len(poses))
        smaller, there = self._smaller(frame, poses, limits)
        less = every[small & there & (self._apart and not frame.deadline.expired)]
        tried = [(n, smaller[less], less) for n in range(len(self.finders) * (len(less) > 0))]
        tried = [(0, poses, every), *tried]
        found = [_judged(self.finders[n], frame, these) for n, these, _ in tried]
        size = np.concatenate([np.full(len(rows), n) for n, _, rows in tried])
        ranked = reduce(add, found)
        best = first_of_each(np.concatenate([rows for _, _, rows in tried]), ranked.votes, 1)
        return ranked[best], size[best]

    def each(self, size: NDArray[np.int64], do: Callable[[WholeObjectFinder, NDArray[np.int64]], Ranked]) -> Ranked:
        """What is done with hypotheses by the finder that sees them best: one finder's after the other's.

        :param size: (H,) which of `finders`.
        """
        return reduce(add, (do(finder, np.flatnonzero(size == n)) for n, finder in enumerate(self.finders)))

    def _smaller(self, frame: ImageFrame, poses: Poses, limits: ScaleLimits) -> tuple[Poses, NDArray[np.bool_]]:
        """The same a step of the scale smaller, about the required component, and whether the scale may be so (H,)."""
        anchors = self.finders[0].required.anchors(poses)
        scale = frame.camera.focal_px / (anchors[:, 2] * self._ratio)
        least: Array = np.full(len(poses), limits.least)
        if frame.scene:
            least = np.maximum(least, frame.scene.scale_limits(project(frame.camera, anchors))[:, 0])
        return Poses(poses.R, poses.t + anchors * (self._ratio - 1), poses.q), np.asarray(scale >= least)


def _judged(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Ranked:
    """The same with joints at which the labels like the other components best, and their votes."""
    if poses.q.shape[1]:
        poses = finder.surface.search_joints(frame, poses, finder.first_grids)
    return Ranked(poses, finder.votes(frame, poses, occlusion=True))
