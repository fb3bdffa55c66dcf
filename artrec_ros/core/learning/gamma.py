"""Whether a camera's values are light or its root, by where somebody has marked the outlines of what is there."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import LearningConfig
from ..geometry.transforms import Array

_LEARNING = LearningConfig()
_CAMERA = 2.2  # what most cameras deliver (IEC 61966-2-1, about)
_BESIDE_PX = 0.5  # to either side of an outline: how steep an edge is there
_CLIPPED = 250  # values of which nobody knows how bright they are
_LEAST = 100  # values: fewer have no median worth the name

Outlined = tuple[NDArray[np.uint8], list[Array]]


def gamma_of(images: Iterable[Outlined]) -> float:
    """2.2 where this puts half of the light at marked outlines, and 1 puts it elsewhere; else 1.

    A lens blends light. Of bright paint on a dark ground a value of half is less than half of its light, and lies
    outside of the outline: patches look larger than they are, by the blur's deviation or nearly.

    :param images: colour images (H, W, 3) and outlines (n, 2) of markers in each, as exact as axes tell them.
    """
    values = [v for image, outlines in images for o in outlines if len(v := _across(image, o))]
    across = np.concatenate(values) if values else np.zeros((0, 5, 3))
    bright = (across[:, 0] - across[:, -1] > 255 * _LEARNING.edge_step) & (across[:, 0] < _CLIPPED)
    if np.count_nonzero(bright) < _LEAST:
        return 1.0
    inside = np.moveaxis(across, 2, 1)[bright] / 255  # (n, 5)
    off_px = {gamma: abs(_beyond_px(inside**gamma)) for gamma in (1.0, _CAMERA)}
    return _CAMERA if off_px[_CAMERA] + _LEARNING.gamma_gain_px < off_px[1.0] else 1.0


def _beyond_px(light: Array) -> float:
    """How far outside of outlines half of the light is, pixels. :param light: (n, 5) as `_across`."""
    step = light[:, 0] - light[:, -1]
    level, slope = ((v / step) for v in (light[:, 2] - light[:, -1], light[:, 1] - light[:, 3]))
    return float((np.median(level) - 0.5) * 2 * _BESIDE_PX / max(np.median(slope), 1e-3))


def _across(image: NDArray[np.uint8], outline: Array) -> Array:
    """(n, 5, 3) values at points of an outline: inside, a little inside, on it, a little outside, outside."""
    closed = np.asarray(outline, np.float32)
    area, length = cv2.contourArea(closed, oriented=True), cv2.arcLength(closed, True)
    reach = min(_LEARNING.edge_reach_px, 1.2 * abs(area) / max(length, 1e-6))  # of a circle within, .6 of its radius
    if reach < 2 * _BESIDE_PX:
        return np.zeros((0, 5, 3))
    points, outward = [], []
    for begin, end in zip(closed, np.roll(closed, -1, axis=0), strict=True):
        way, size = end - begin, float(np.hypot(*(end - begin)))
        if size < 1e-6:
            continue
        share = (np.arange(max(int(size), 1)) + 0.5) / max(int(size), 1)
        if size > 2 * reach:  # corners are rounded
            share = share[np.minimum(share, 1 - share) * size > reach / 2]
        points.append(begin + share[:, None] * way)
        outward.append(np.tile(np.sign(area) * np.array([way[1], -way[0]]) / size, (len(share), 1)))
    off = np.array([-reach, -_BESIDE_PX, 0.0, _BESIDE_PX, reach])
    at = np.concatenate(points)[:, None] + off[:, None] * np.concatenate(outward)[:, None]
    x, y = np.ascontiguousarray(np.moveaxis(at.astype(np.float32), 2, 0))
    return np.asarray(cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.float64)
