"""What all pixels say of an object that is one marker: votes look at a few points of it, and of a notch that alone
tells one end from the other at one or at none.

Between two hypotheses those tell alone that lie in one of both outlines and not in the other: of the rest both say the
same, be the outline drawn as it is or not.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..image.label_field import LabelField
from .finder import WholeObjectFinder
from .poses import Poses
from .surface_model import SpatialModel
from .turn_evidence import evidence

_ZOOM = 2  # pixels of a mask along one of the image's
_APART = np.ones((3, 3), np.uint8)  # half a pixel all around: what lies nearer to either outline tells of how it rests
_BITS = 4  # of a pixel's fractions


def odds_among(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Array:
    """(H - 1,) log odds against the first one of H poses at rest, of which one is the true one, that another is it.

    The pixels in which two differ tell those two apart, and what they say of two and two contradicts itself: so each
    has its odds against all. Votes, and how near to contours edges lie, tell more of small ones.
    """
    by_pixels, weights = differing_odds(finder, frame, poses).mean(axis=1), finder.config.verdict.differing_odds
    others = poses[1:]
    found = evidence(finder, frame, poses[np.zeros(len(others), int)], others)
    return by_pixels[1:] - by_pixels[0] + found.log_odds((0.0, *weights[2:]))


def differing_odds(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Array:
    """(H, H) log odds of each of H poses, of which one is the true one, against each, by the pixels in which these two
    differ."""
    weight, least_px, *_ = finder.config.verdict.differing_odds
    outlines = outlines_of(finder.surface, frame, poses)
    speaks = differing_px(worth_of(finder.surface), frame, [[outline] for outline in outlines]) + least_px
    return np.asarray(weight * np.log(speaks / speaks.T), np.float64)


def differing_px(worth: NDArray[np.float32], frame: ImageFrame, shapes: Sequence[Sequence[Array]]) -> Array:
    """(H, H) pixels in which two of H shapes of a class differ that speak for the first one.

    :param worth: (256,) how far codes say that a pixel is of the class, -1 to 1. :param shapes: outlines (n, 2) of
        each.
    """
    (width, height), points = frame.size, np.concatenate([outline for shape in shapes for outline in shape])
    low = np.clip(np.floor(points.min(axis=0)).astype(int) - 1, 0, (width, height))
    high = np.clip(np.ceil(points.max(axis=0)).astype(int) + 2, 0, (width, height))
    if (low >= high).any():
        return np.zeros((len(shapes), len(shapes)))
    rows, columns = (_ZOOM * (high - low)[::-1]).tolist()
    sides = [_sides([outline - low for outline in shape], (rows, columns)) for shape in shapes]
    ever_in, ever_off = (np.logical_or.reduce(masks) for masks in zip(*sides, strict=True))
    at = np.flatnonzero(ever_in & ever_off)
    inside, outside = (np.array([mask.ravel()[at] for mask in m], np.float32) for m in zip(*sides, strict=True))
    codes = _codes(frame)[low[1] : high[1], low[0] : high[0]]
    said = cv2.resize(worth[codes], (columns, rows), interpolation=cv2.INTER_NEAREST).ravel()[at] / _ZOOM**2
    speaks = (inside * np.maximum(said, 0)) @ outside.T + (outside * np.maximum(-said, 0)) @ inside.T
    return np.asarray(speaks, np.float64)


class MarkerPixels:
    """How many pixels speak for poses of an object that is one marker."""

    def __init__(self, surface: SpatialModel) -> None:
        self._surface = surface
        self._known: tuple[LabelField, NDArray[np.float32]] | None = None

    def own(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H,) pixels in the outline that are the marker's, less those that are not: as far as it reaches in the middle
        of each row."""
        (width, height), out, left_of = frame.size, np.zeros(len(poses)), self._left_of(frame)
        outlines = outlines_of(self._surface, frame, poses)
        x0, y0 = outlines.reshape(-1, 2).T
        x1, y1 = np.roll(outlines, -1, axis=1).reshape(-1, 2).T
        first, last = (np.clip(np.ceil(y), 0, height).astype(int) for y in (np.minimum(y0, y1), np.maximum(y0, y1)))
        count = last - first
        side = np.repeat(np.arange(len(count)), count)  # of an outline, once for each row whose middle it crosses
        row = np.arange(len(side)) + np.repeat(first + count - np.cumsum(count), count)
        slope = ((x1 - x0) / np.where(count > 0, y1 - y0, 1.0))[side]
        x = np.clip(x0[side] + (row - y0[side]) * slope + 0.5, 0.0, width)
        i = np.minimum(x.astype(int), width - 1)
        left = left_of[row, i] + (x - i) * (left_of[row, i + 1] - left_of[row, i])
        np.add.at(out, side // outlines.shape[1], np.sign(y1 - y0)[side] * left)
        x, y = np.moveaxis(outlines - outlines[:, :1], 2, 0)
        return out * np.sign((x[:, :-1] * y[:, 1:] - y[:, :-1] * x[:, 1:]).sum(axis=1))

    def _left_of(self, frame: ImageFrame) -> NDArray[np.float32]:
        """(height, width + 1) the same of what lies left of each pixel in its row; made once for an image."""
        if self._known is None or self._known[0] is not frame.field:
            left_of = np.zeros((frame.size[1], frame.size[0] + 1), np.float32)
            np.cumsum(worth_of(self._surface)[_codes(frame)], axis=1, out=left_of[:, 1:])
            self._known = frame.field, left_of
        return self._known[1]


def outlines_of(surface: SpatialModel, frame: ImageFrame, poses: Poses, marker: int = 0) -> Array:
    """(H, n, 2) pixels: of one of the markers at each pose."""
    row = int(surface.markers[marker])
    drawn = surface.patches[row].drawn[3:]
    frames = surface.kinematics.seen(poses.R, poses.t, poses.q)
    X = surface.place(frames, drawn, np.full(len(drawn), surface.component[row]))
    return project(frame.camera, X.reshape(-1, 3)).reshape(len(poses), len(drawn), 2)


def _codes(frame: ImageFrame) -> NDArray[np.uint8]:
    """(height, width)"""
    width, height = frame.size
    return frame.field.padded.reshape(height + 2, width + 2)[1:-1, 1:-1]


def worth_of(surface: SpatialModel) -> NDArray[np.float32]:
    """(256,) how far codes say that a pixel is the marker's, -1 to 1."""
    role = surface.table[surface.role[surface.markers[0]]] - surface.table[surface.ring_role[0]]
    return np.asarray(role / np.abs(role).max(), np.float32)


def _sides(outlines: Sequence[Array], size: tuple[int, int]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(2,) masks of what lies in some outlines and of what lies outside, but for what is near to them."""
    inside = np.zeros(size, np.uint8)
    for outline in outlines:
        at = ((outline + 0.5) * _ZOOM - 0.5) * (1 << _BITS)
        cv2.fillPoly(inside, [at.round().astype(np.int32)], 1, shift=_BITS)
    return cv2.erode(inside, _APART) > 0, cv2.dilate(inside, _APART) == 0
