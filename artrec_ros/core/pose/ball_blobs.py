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
from .poses import Poses
from .surface_kernels import LEAST_DEPTH_M
from .surface_model import SpatialModel
from .through_middles import Middles

_SIZE = 0.04  # a blob by such a share, and so many pixels, larger or smaller than its ball beside the others is another
_SIZE_PX = 0.35  # size than noise makes it; all may be larger, by a segmenter's fringes or by the file
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
        frames, patches = self._kin.seen(pose.R, pose.t, pose.q), np.array(shown, np.int64)
        of, balls = surface.component[patches], surface.sides.balls
        places = surface.place(frames, middle[patches], of)[0]
        at, scale = project(camera, places), camera.focal_px / np.maximum(places[:, 2], LEAST_DEPTH_M)
        on = [_beneath(at[n], surface.labels[c], blobs) if c in balls else None for n, c in enumerate(of.tolist())]
        rows = [n for n, blob in enumerate(on) if blob is not None]
        if not rows:
            return None
        found = [blob for blob in on if blob is not None]
        there, own = centres(found), np.sqrt(np.array([blob.area_px for blob in found]) / area[patches[rows]])
        radius_px = np.sqrt(area[patches[rows]] / np.pi) * scale[rows]
        larger = np.log(own / scale[rows])
        unlike = np.abs(larger - np.median(larger)) > np.maximum(_SIZE, _SIZE_PX / radius_px)
        aside = np.linalg.norm(there - at[rows], axis=1) > _OFF * radius_px
        at[rows], scale[rows] = there, own
        return Middles(patches, at, scale) if (unlike | aside).any() else None


def _beneath(at: np.ndarray, labels: Sequence[int], blobs: Sequence[Blob]) -> Blob | None:
    """The blob of a class in which a place lies."""
    point = float(at[0]), float(at[1])
    return next((b for b in blobs if b.label in labels and cv2.pointPolygonTest(b.polygon, point, False) >= 0), None)
