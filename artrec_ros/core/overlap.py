"""Which instances lay claim to the same pixels."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from .alignment import Placements
from .compiled.jit import COMPILED
from .compiled.pair_checks import Rasters, overlaps
from .shapes import Shape
from .transforms import Array

_CELLS = 96  # across a shape's raster


@lru_cache(maxsize=8)
def _rasters(shapes: tuple[Shape, ...]) -> Rasters:
    """Shapes drawn once, to ask many points whether they lie inside."""
    masks, lows, cells = [], [], []
    for shape in shapes:
        low = shape.outline.min(axis=0)
        cell = float((shape.outline.max(axis=0) - low).max()) / (_CELLS - 4)
        mask = np.zeros((_CELLS, _CELLS), np.uint8)
        cv2.fillPoly(mask, [np.rint((shape.outline - low) / cell + 2).astype(np.int32)], 1)
        masks.append(mask)
        lows.append(low)
        cells.append(cell)
    return Rasters(
        np.stack(masks),
        np.stack(lows),
        np.array(cells),
        np.array([np.abs(s.outline @ np.array([1, 1j])).max() for s in shapes]),
        np.concatenate([s.inside for s in shapes]),
        np.cumsum([0] + [len(s.inside) for s in shapes]),
    )


def overlap_matrix(shapes: list[Shape], placed: Placements, labels: np.ndarray) -> Array:
    """(K, K) share of the smaller one's area in common; 0 between classes: a sticker lies on its part."""
    rasters = _rasters(tuple(shapes))
    if COMPILED:
        return overlaps(rasters, placed.t, placed.z, placed.w, placed.shape, labels)
    count = len(placed)
    inside = np.zeros((count, count))  # inside[i, j]: share of i that lies in j
    reach = rasters.reach[placed.shape] * placed.scale
    for j in range(count):
        near = (labels == labels[j]) & (np.abs(placed.t - placed.t[j]) < reach + reach[j])
        for s in np.unique(placed.shape):
            mine = np.flatnonzero(near & (placed.shape == s))
            where = placed.take(mine).where(shapes[s].inside) - placed.t[j]
            points = _undo(where, placed.z[j], placed.w[j])
            inside[mine, j] = _holds(rasters, int(placed.shape[j]), points).mean(axis=1)
    return np.maximum(inside, inside.T)


def _holds(rasters: Rasters, s: int, points: np.ndarray) -> NDArray[np.bool_]:
    """Whether complex points of a shape's frame lie inside it."""
    x = np.clip((points.real - rasters.low[s, 0]) / rasters.cell[s] + 2.5, 0, _CELLS - 1).astype(np.intp)
    y = np.clip((points.imag - rasters.low[s, 1]) / rasters.cell[s] + 2.5, 0, _CELLS - 1).astype(np.intp)
    return rasters.mask[s, y, x] > 0


def _undo(offset: np.ndarray, z: complex, w: complex) -> np.ndarray:
    """The points p with z p + w conj(p) = offset."""
    return (np.conj(z) * offset - w * np.conj(offset)) / (abs(z) ** 2 - abs(w) ** 2)
