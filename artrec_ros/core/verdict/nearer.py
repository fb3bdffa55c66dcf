"""What of told objects others hide that are nearer.

A fit to contours would take the border of what lies before a marker for the marker's own. Where another told object is
known to lie before it no edge is looked for, and no label speaks for or against it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .claims import Solids, widened
from .nearer_kernels import meet_boxes
from .verdicts import Verdict

_PARALLEL = 1e-9  # metres: a ray that goes along a side
_OFF_PX = 2.0  # a silhouette of a candidate, with the seam around what is seen of it


def behind_others(verdicts: Sequence[Verdict], among: Sequence[Verdict], frame: ImageFrame) -> list[ImageFrame]:
    """For each of some objects the frame in which what others hide of it is theirs; the frame itself where that is
    nothing. :param among: all objects of the frame."""
    if len(among) < 2:
        return [frame] * len(verdicts)
    out = []
    for verdict in verdicts:
        mine, others = verdict.claim.solids, [v.claim.solids for v in among if v.claim is not verdict.claim]
        before = [widened(hull, _OFF_PX) for other in others for hull in _before(other, mine)]
        out.append(frame.without(before, nearer=True))
    return out


def met_by_each(verdicts: Sequence[Verdict], among: Sequence[Verdict], points: Array) -> Array:
    """(N, H, n) at which share of the way to points of H objects each of all N lies; inf: it is not before or behind.

    :param among: all objects of the frame. :param points: (H, n, 3) in the camera's frame.
    """
    share, seen = np.full((len(among), *points.shape[:2]), np.inf), [_box_of(X) for X in points]
    for other, theirs in zip(among, share, strict=True):
        surface, poses, frames = other.claim.finder.surface, other.claim.poses, None
        box = _box_of(other.claim.solids.at)
        for h, verdict in enumerate(verdicts):
            if verdict.claim is not other.claim and (box[0] <= seen[h][1]).all() and (seen[h][0] <= box[1]).all():
                frames = frames or surface.kinematics.seen(poses.R, poses.t, poses.q)
                meet_boxes(surface.opaque, frames.R[0], frames.t[0], points[h], _PARALLEL, theirs[h])
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


def _before(solids: Solids, other: Solids) -> list[NDArray[np.float32]]:
    """Corners of those that lie before all of the other object's that they meet in the image."""
    low, high = solids.low - _OFF_PX, solids.high + _OFF_PX
    meet = (low[:, None] <= other.high + _OFF_PX) & (other.low - _OFF_PX <= high[:, None])
    both = np.all(meet, axis=2)
    if not both.any():
        return []
    nearer = solids.depth[:, None] < other.depth
    before = np.any(both, axis=1) & np.all(nearer | ~both, axis=1)
    return [solids.corners[k] for k in np.flatnonzero(before)]
