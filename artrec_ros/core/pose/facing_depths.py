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

    def of(self, frame: ImageFrame, poses: Poses) -> tuple[float, float]:
        """The least and the greatest of all poses' places."""
        near, far = self._of_required(frame, poses)
        return float(np.min(near)) + self._nearer_m, float(np.max(far)) + self._nearer_m

    def kept(self, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
        """Poses with required components in the image where they are, at depths in these limits; and which lie on one
        of them."""
        near, far = self._of_required(frame, poses)
        depth = self._required.anchors(poses)[:, 2]
        at = np.flatnonzero((depth <= near * (1 + _ROUNDING)) | (depth >= far * (1 - _ROUNDING)))
        if not len(at):
            return poses, at
        farther = np.minimum(np.maximum(depth, near), far) / depth - 1
        return Poses(poses.R, poses.t + self._required.anchors(poses) * farther[:, None], poses.q), at

    def _of_required(self, frame: ImageFrame, poses: Poses) -> tuple[Array, Array]:
        """() or (H,) between which depths required components are."""
        limits = np.array(self._limits, float)
        if frame.scene.plane is not None:
            known = frame.scene.scale_limits(project(frame.camera, self._required.anchors(poses)))
            # beyond the horizon nothing has a scale, and is refused for that
            limits = np.where(known[:, 1:] > 0, np.clip(known, limits[0], limits[1]), limits)
        with np.errstate(divide="ignore"):
            far, near = (frame.camera.focal_px / limits).T
        return near, far
