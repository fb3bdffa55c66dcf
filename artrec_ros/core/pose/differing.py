"""Which of two turns of a lone marker its pixels bear out: those alone that lie in one of both outlines and not in the
other.

Of the rest both say the same, be the outline drawn as it is or not, and votes look at a few points of it: of a notch
that alone tells one end from the other, at one or at none.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .poses import Poses
from .surface_model import SpatialModel

_ZOOM = 2  # pixels of a mask along one of the image's
_APART = np.ones((3, 3), np.uint8)  # half a pixel all around: what lies nearer to either outline tells of how it rests
_BITS = 4  # of a pixel's fractions


def differing_odds(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, others: Poses) -> Array:
    """(H,) log odds that the others are the true ones, of an object that is one marker."""
    weight, least_px = finder.config.verdict.differing_odds
    for_poses, for_others = differing_px(finder.surface, frame, poses, others)
    return np.asarray(weight * np.log((for_others + least_px) / (for_poses + least_px)), np.float64)


def differing_px(surface: SpatialModel, frame: ImageFrame, poses: Poses, others: Poses) -> tuple[Array, Array]:
    """(H,) pixels in which the two differ that speak for a pose, and (H,) for the other one."""
    role = surface.table[surface.role[surface.markers[0]]] - surface.table[surface.ring_role[0]]
    worth = (role / np.abs(role).max()).astype(np.float32)
    outlines = zip(_outlines(surface, frame, poses), _outlines(surface, frame, others), strict=True)
    found = np.array([_differing(frame, worth, mine, its) for mine, its in outlines]).reshape(-1, 2)
    return found[:, 0], found[:, 1]


def _outlines(surface: SpatialModel, frame: ImageFrame, poses: Poses) -> Array:
    """(H, n, 2) pixels."""
    (row,) = surface.markers.tolist()
    drawn = surface.patches[row].drawn[3:]
    frames = surface.kinematics.seen(poses.R, poses.t, poses.q)
    X = surface.place(frames, drawn, np.full(len(drawn), surface.component[row]))
    return project(frame.camera, X.reshape(-1, 3)).reshape(len(poses), -1, 2)


def _differing(frame: ImageFrame, worth: NDArray[np.float32], mine: Array, its: Array) -> tuple[float, float]:
    """Of one of them. :param worth: (256,) how far codes say that a pixel is the marker's, -1 to 1."""
    (width, height), both = frame.size, np.concatenate([mine, its])
    low = np.clip(np.floor(both.min(axis=0)).astype(int) - 1, 0, (width, height))
    high = np.clip(np.ceil(both.max(axis=0)).astype(int) + 2, 0, (width, height))
    if (low >= high).any():
        return 0.0, 0.0
    rows, columns = (_ZOOM * (high - low)[::-1]).tolist()
    (in_mine, off_mine), (in_its, off_its) = (_sides(outline - low, (rows, columns)) for outline in (mine, its))
    codes = frame.field.padded.reshape(height + 2, width + 2)[low[1] + 1 : high[1] + 1, low[0] + 1 : high[0] + 1]
    said = cv2.resize(worth[codes], (columns, rows), interpolation=cv2.INTER_NEAREST)
    said = np.concatenate([said[in_mine & off_its], -said[in_its & off_mine]]) / _ZOOM**2
    return float(np.maximum(said, 0).sum()), float(np.maximum(-said, 0).sum())


def _sides(outline: Array, size: tuple[int, int]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(2,) masks of what lies in an outline and of what lies outside, but for what is near to it."""
    at = ((outline + 0.5) * _ZOOM - 0.5) * (1 << _BITS)
    inside = cv2.fillPoly(np.zeros(size, np.uint8), [at.round().astype(np.int32)], 1, shift=_BITS)
    return cv2.erode(inside, _APART) > 0, cv2.dilate(inside, _APART) == 0
