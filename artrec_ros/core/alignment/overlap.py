"""Which instances lay claim to the same pixels."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from ..geometry.transforms import Array
from .overlap_kernels import Rasters, overlaps
from .placements import Placements
from .shapes import Shape

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
    return overlaps(_rasters(tuple(shapes)), placed.t, placed.z, placed.w, placed.shape, labels)
