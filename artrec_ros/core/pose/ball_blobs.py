"""Where blobs say that balls are, and how large: of a ball's place that says all.

A ball that is told smaller than its blob lies within it, and all of its pixels are right: by votes alone a link that
leans towards the camera may lean away from it as well. Its size tells which.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..image.blobs import Blob, centres
from .surface_kernels import LEAST_DEPTH_M
from .surface_model import Poses, SpatialModel
from .through_middles import Middles

_SIZE = 1.12  # a blob so many times larger or smaller than its ball is another size than noise makes it
_OFF = 0.3  # of its radius: a ball whose middle is so far from its blob's is not on it


class BallBlobs:
    """Those of one object."""

    def __init__(self, surface: SpatialModel) -> None:
        self._surface, self._kin = surface, surface.kinematics

    def under(self, camera: Camera, pose: Poses, shown: Sequence[int], blobs: Sequence[Blob]) -> Middles | None:
        """Where the blobs beneath the balls that are seen say they are, and where the pose has all else that is; None:
        the pose agrees with these blobs.

        :param pose: one. :param shown: markers by which components are seen: patches of the surface.
        """
        surface, middle, area = self._surface, *self._surface.sides.blobs
        frames, patches = self._kin.forward(pose.R, pose.t, pose.q), np.array(shown, np.int64)
        places = surface.place(frames, middle[patches], surface.component[patches])[0]
        at, scale = project(camera, places), camera.focal_px / np.maximum(places[:, 2], LEAST_DEPTH_M)
        agrees = True
        for n, p in enumerate(shown):
            c = surface.component[p]
            blob = _beneath(at[n], surface.labels[c], blobs) if c in surface.sides.balls else None
            if blob is None:
                continue
            there, own = centres([blob])[0], float(np.sqrt(blob.area_px / area[p]))
            radius_px = np.sqrt(area[p] / np.pi) * scale[n]
            unlike = max(own / scale[n], scale[n] / own)
            agrees &= bool(unlike < _SIZE and np.linalg.norm(there - at[n]) < _OFF * radius_px)
            at[n], scale[n] = there, own
        return None if agrees else Middles(patches, at, scale)


def _beneath(at: np.ndarray, labels: Sequence[int], blobs: Sequence[Blob]) -> Blob | None:
    """The blob of a class in which a place lies."""
    point = float(at[0]), float(at[1])
    return next((b for b in blobs if b.label in labels and cv2.pointPolygonTest(b.polygon, point, False) >= 0), None)
