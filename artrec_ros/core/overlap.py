"""Which instances lay claim to the same pixels."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .alignment import Placements
from .shapes import Shape
from .transforms import Array

_CELLS = 96  # across a shape's raster


class _Raster:
    """A shape drawn once, to ask many points whether they lie inside it."""

    def __init__(self, shape: Shape) -> None:
        self._low = shape.outline.min(axis=0)
        self._cell = float((shape.outline.max(axis=0) - self._low).max()) / (_CELLS - 4)
        self._mask = np.zeros((_CELLS, _CELLS), np.uint8)
        polygon = np.rint((shape.outline - self._low) / self._cell + 2).astype(np.int32)
        cv2.fillPoly(self._mask, [polygon], 1)

    def holds(self, points: np.ndarray) -> NDArray[np.bool_]:
        """Complex points in the shape's frame."""
        x = np.clip((points.real - self._low[0]) / self._cell + 2.5, 0, _CELLS - 1).astype(np.intp)
        y = np.clip((points.imag - self._low[1]) / self._cell + 2.5, 0, _CELLS - 1).astype(np.intp)
        return self._mask[y, x] > 0


def overlap_matrix(shapes: list[Shape], placed: Placements, labels: np.ndarray) -> Array:
    """(K, K) share of the smaller one's area in common; 0 between classes: a sticker lies on its part."""
    count = len(placed)
    rasters = {int(s): _Raster(shapes[s]) for s in np.unique(placed.shape)}
    inside = np.zeros((count, count))  # inside[i, j]: share of i that lies in j
    reach = np.array([np.abs(s.outline @ np.array([1, 1j])).max() for s in shapes])[placed.shape] * placed.scale
    for j in range(count):
        near = (labels == labels[j]) & (np.abs(placed.t - placed.t[j]) < reach + reach[j])
        raster = rasters[int(placed.shape[j])]
        for s in rasters:
            mine = np.flatnonzero(near & (placed.shape == s))
            where = placed.take(mine).where(shapes[s].inside) - placed.t[j]
            inside[mine, j] = raster.holds(_undo(where, placed.z[j], placed.w[j])).mean(axis=1)
    return np.maximum(inside, inside.T)


def _undo(offset: np.ndarray, z: complex, w: complex) -> np.ndarray:
    """The points p with z p + w conj(p) = offset."""
    return (np.conj(z) * offset - w * np.conj(offset)) / (abs(z) ** 2 - abs(w) ** 2)
