"""Between which depths objects that face the camera are: at scales that are looked for, and that the scene's plane has,
within its tolerance, where their required components are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.projection import project
from ..geometry.range_limits import scale_limits
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .poses import Poses
from .required_place import RequiredPlace
from .surface_model import SpatialModel

_ROUNDING = 1e-9


class FacingDepths:
    """Those of one object."""

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._required, self._nearer_m = RequiredPlace(surface.model, surface), surface.nearer_m
        self._limits = scale_limits(config, None)

    def of(self, frame: ImageFrame, poses: Poses) -> tuple[Array, Array]:
        """(H,) least and greatest of each pose's place."""
        near, far = self._of_anchors(frame, self._required.anchors(poses))
        return near + self._nearer_m, far + self._nearer_m

    def kept(self, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
        """Poses with required components in the image where they are, at depths in these limits; and which lie on one
        of them."""
        anchors = self._required.anchors(poses)
        depth, (near, far) = anchors[:, 2], self._of_anchors(frame, anchors)
        at = np.flatnonzero((depth <= near * (1 + _ROUNDING)) | (depth >= far * (1 - _ROUNDING)))
        if not len(at):
            return poses, at
        farther = np.minimum(np.maximum(depth, near), far) / depth - 1
        return Poses(poses.R, poses.t + anchors * farther[:, None], poses.q), at

    def _of_anchors(self, frame: ImageFrame, anchors: Array) -> tuple[Array, Array]:
        limits: Array = np.tile(np.array(self._limits, float), (len(anchors), 1))
        if frame.scene.plane is not None:
            known = frame.scene.scale_limits(project(frame.camera, anchors))
            # beyond the horizon nothing has a scale, and is refused for that
            limits = np.where(known[:, 1:] > 0, np.clip(known, limits[:, :1], limits[:, 1:]), limits)
        with np.errstate(divide="ignore"):
            far, near = (frame.camera.focal_px / limits).T
        return near, far
