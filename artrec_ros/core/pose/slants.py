"""Lone flat markers that are seen at a slant, before a camera that they are taken to face.

Turned out of the image plane by twenty degrees an outline is squeezed by a sixteenth. Of a plate that is less than what
is looked at beside its edges; of what is open and thin it is more than it is wide, and no similarity lies on all of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.transforms import rotation_from_rotvec
from ..image.image_frame import ImageFrame
from .pose_fit import Fit
from .poses import Poses
from .surface_model import SpatialModel

_WAYS = 4  # axes about which it is slanted to begin with, of half a turn: to and fro looks the same from afar


class Slants:
    """Those of one target."""

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        most = np.radians(config.covariance.flat_tilt_deg)
        axes = np.pi / _WAYS * np.arange(_WAYS)
        self._begun = np.stack([rotation_from_rotvec([most / 2 * np.cos(a), most / 2 * np.sin(a), 0.0]) for a in axes])
        self._least_cosine = float(np.cos(most))
        self._fit, self._reach_px = Fit(surface, config.fit, facing=False), config.fit.coarse_reach_px * 2

    def of(self, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
        """Poses as they fit at a slant, those that are slanted no more than objects may be, and whose each is."""
        of = np.repeat(np.arange(len(poses)), _WAYS)
        begun = Poses(np.tile(self._begun, (len(poses), 1, 1)) @ poses.R[of], poses.t[of], poses.q[of])
        fitted = self._fit.of(frame, begun, np.ones((len(of), 1), bool), self._reach_px)
        kept = np.flatnonzero(np.abs(fitted.R[:, 2, 2]) >= self._least_cosine)
        return fitted[kept], of[kept]
