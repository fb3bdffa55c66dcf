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
from .claims import corners_m, widened
from .verdicts import Verdict

_PARALLEL = 1e-9  # metres: a ray that goes along a side
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


def met_by_each(verdicts: Sequence[Verdict], among: Sequence[Verdict], points: Array) -> Array:
    """(N, H, n) at which share of the way to points of H objects each of all N lies; inf: it is not before or behind.

    :param among: all objects of the frame. :param points: (H, n, 3) in the camera's frame.
    """
    share, seen = np.full((len(among), *points.shape[:2]), np.inf), [_box_of(X) for X in points]
    for other, theirs in zip(among, share, strict=True):
        solid = None
        box = _box_of(corners_m(other.claim.finder.surface, other.claim.poses)[0])
        for h, verdict in enumerate(verdicts):
            if verdict.claim is not other.claim and (box[0] <= seen[h][1]).all() and (seen[h][0] <= box[1]).all():
                solid = solid or _InCamera.of(other)
                theirs[h] = solid.met_at(points[h])
    return share


def hidden_by_each(share: Array, owned: NDArray[np.bool_], slack: float) -> NDArray[np.bool_]:
    """(N, ...) which points each of N objects hides: what lies before it, and where that is not sure what another took.

    :param share: (N, ...) as of `met_by_each`. :param owned: (...) whose pixels are another's.
    :param slack: share of the range by which one must be nearer to be so.
    """
    return np.asarray((share < 1 - slack) | (owned & (share < 1 + slack)))


def _box_of(points: Array) -> tuple[Array, Array]:
    """Least and greatest x / z, y / z of points (n, 3) in the camera's frame; all where some lie behind it."""
    if (points[:, 2] <= _PARALLEL).any():
        return np.full(2, -np.inf), np.full(2, np.inf)
    at = points[:, :2] / points[:, 2:]
    return at.min(axis=0), at.max(axis=0)


@dataclass(frozen=True, eq=False)
class _InCamera:
    """The K opaque boxes of one object.

    :param axes: (K, 3, 3) theirs are the columns. :param eye: (K, 3) the camera's centre in their frames.
    :param half: (K, 3) half of their sizes.
    """

    axes: Array
    eye: Array
    half: Array

    @classmethod
    def of(cls, verdict: Verdict) -> _InCamera:
        surface, poses = verdict.claim.finder.surface, verdict.claim.poses
        frames, boxes = surface.kinematics.seen(poses.R, poses.t, poses.q), surface.opaque
        R, t = frames.R[0, boxes.component], frames.t[0, boxes.component]
        axes, middle = R @ boxes.R, (R @ boxes.t[..., None])[..., 0] + t
        return cls(axes, -(middle[:, None] @ axes)[:, 0], boxes.half)

    def met_at(self, points: Array) -> Array:
        """(n,) at which share of the way to points (n, 3) one of them lies before or behind it; inf: at none."""
        rays = points @ self.axes  # (K, n, 3)
        rays = np.where(np.abs(rays) > _PARALLEL, rays, _PARALLEL)
        low, high = ((side - self.eye)[:, None] / rays for side in (-self.half, self.half))
        enter, leave = np.maximum(np.minimum(low, high).max(axis=2), 0.0), np.maximum(low, high).min(axis=2)
        return np.asarray(np.where(enter < leave, enter, np.inf).min(axis=0, initial=np.inf))


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
