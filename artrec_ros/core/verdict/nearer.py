"""What of told objects others hide that are nearer.

A fit to contours would take the border of what lies before a marker for the marker's own. Where another told object is
known to lie before it no edge is looked for, and no label speaks for or against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .acceptance import Verdict
from .claims import corners_m, widened

_OFF_PX = 2.0  # a silhouette of a candidate, with the seam around what is seen of it


def behind_others(verdicts: Sequence[Verdict], among: Sequence[Verdict], frame: ImageFrame) -> list[ImageFrame]:
    """For each of some objects the frame in which what others hide of it is theirs; the frame itself where that is
    nothing. :param among: all objects of the frame."""
    if len(among) < 2:
        return [frame] * len(verdicts)
    solids = {v: _Solids.of(v, frame.camera) for v in {*among, *verdicts}}
    out = []
    for verdict in verdicts:
        mine, others = solids[verdict], [solids[v] for v in among if v.claim is not verdict.claim]
        before = [widened(hull, _OFF_PX) for other in others for hull in other.before(mine)]
        out.append(frame.without(before, nearer=True))
    return out


@dataclass(frozen=True, eq=False)
class _Solids:
    """The n boxes and markers of one object.

    :param corners: pixels; convex hulls of them cover it. :param low, high: (n, 2) least and greatest x, y of each.
    :param depth: (n,) of their middles along the optical axis.
    """

    corners: list[NDArray[np.float32]]
    low: Array
    high: Array
    depth: Array

    @classmethod
    def of(cls, verdict: Verdict, camera: Camera) -> _Solids:
        surface = verdict.claim.finder.surface
        X, starts = corners_m(surface, verdict.claim.poses), surface.hulls.starts
        pixels, first = project(camera, X)[0].astype(np.float32), starts[:-1]
        low, high = np.minimum.reduceat(pixels, first), np.maximum.reduceat(pixels, first)
        depth = np.add.reduceat(X[0, :, 2], first) / np.diff(starts)
        corners = [pixels[begin:end] for begin, end in pairwise(starts)]
        return cls(corners, low - _OFF_PX, high + _OFF_PX, depth)

    def before(self, other: _Solids) -> list[NDArray[np.float32]]:
        """Those that lie before all of the other object's that they meet in the image."""
        meet = ((self.low[:, None] <= other.high) & (other.low <= self.high[:, None])).all(axis=2)
        nearer = self.depth[:, None] < other.depth
        before = np.any(meet, axis=1) & np.all(nearer | ~meet, axis=1)
        return [self.corners[k] for k in np.flatnonzero(before)]
