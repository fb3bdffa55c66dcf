"""At which sizes objects with small markers that face the camera are tried."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .base.config import RecognizerConfig
from .geometry.projection import project
from .geometry.range_limits import ScaleLimits
from .geometry.transforms import Array
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .pose.climber import Climb
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .pose.ranked import Ranked, first_of_each


class FacingSizes:
    """A small marker looks larger than it is where the lens blurs it, ink runs, or what is around it is dark: by a
    pixel all around, a patch of 12 px looks a sixth larger. Its own pixels then want a scale at which no other
    component is where it should be, while a wrong turn may lay one on another's pixels. So the whole object is tried at
    a smaller scale as well, with markers that look larger than they are.
    """

    def __init__(self, finder: WholeObjectFinder, config: RecognizerConfig) -> None:
        self._plain, self._swollen = finder, finder.swollen[-1] if finder.swollen else finder
        model = finder.target.model
        # else nothing but its own pixels tells its scale
        self._apart = len(model.components) > 1 and len(finder.swollen) > 0
        self._ratio, self._small_px = config.facing.scale_ratio, config.guesses.small_px
        areas = [m.area for component in model.components for m in component.markers]
        self._least_area = min(areas)
        self._least_share = self._least_area / max(m.area for m in model.required.markers)

    def matter(self, blob: Blob) -> bool:
        """Whether an object whose required component made a blob has small markers, be they others."""
        return self._apart and self._least_share * blob.area_px < self._small_px

    def of(
        self, frame: ImageFrame, poses: Poses, small: NDArray[np.bool_], limits: ScaleLimits
    ) -> tuple[Ranked, NDArray[np.bool_]]:
        """Hypotheses with their joints and votes, each at the better of its scales, and whether that is the one at
        which markers look larger than they are (H,).

        :param small: (H,) those for which sizes `matter`. :param limits: of the scale.
        """
        found = with_joints(self._plain, frame, poses)
        if not small.any() or frame.deadline.expired:
            return found, np.zeros(len(poses), bool)
        smaller, there = self._smaller(frame, poses, limits)
        less = np.flatnonzero(small & there)
        found += with_joints(self._swollen, frame, smaller[less])
        best = first_of_each(np.concatenate([np.arange(len(poses)), less]), found.votes, 1)
        return found[best], best >= len(poses)

    def each(self, swollen: NDArray[np.bool_], do: Callable[[WholeObjectFinder, NDArray[np.int64]], Ranked]) -> Ranked:
        """What is done with hypotheses, first those with markers as large as they are, then the others.

        :param swollen: (H,) which look larger. :param do: takes a finder of markers that look so, and indices.
        """
        if not swollen.any():  # as of most objects
            return do(self._plain, np.arange(len(swollen)))
        return do(self._plain, np.flatnonzero(~swollen)) + do(self._swollen, np.flatnonzero(swollen))

    def larger(self, frame: ImageFrame, few: Ranked, climb: Climb) -> Ranked:
        """Hypotheses with small markers, after a climb and a fit to the contours with markers that look larger than
        they are. About a disc so many directions are tried that nobody has time to try each at two scales before."""
        area = self._least_area * (frame.camera.focal_px / self._plain.required.anchors(few.poses)[:, 2]) ** 2
        rows = np.flatnonzero(area < self._small_px)
        if not self._apart or not len(rows) or frame.deadline.expired:
            return few[:0]
        return self._swollen.polished(frame, few[rows], climb)

    def _smaller(self, frame: ImageFrame, poses: Poses, limits: ScaleLimits) -> tuple[Poses, NDArray[np.bool_]]:
        """The same a step of the scale smaller, about the required component, and whether the scale may be so (H,)."""
        anchors = self._plain.required.anchors(poses)
        scale = frame.camera.focal_px / (anchors[:, 2] * self._ratio)
        least: Array = np.full(len(poses), limits.least)
        if frame.scene:
            least = np.maximum(least, frame.scene.scale_limits(project(frame.camera, anchors))[:, 0])
        return Poses(poses.R, poses.t + anchors * (self._ratio - 1), poses.q), np.asarray(scale >= least)


def with_joints(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Ranked:
    """The same with joints at which the labels like the other components best, and their votes."""
    if poses.q.shape[1]:
        poses = finder.surface.search_joints(frame, poses, finder.first_grids)
    return finder.ranked(frame, poses)
