"""Which instances lay claim to the same pixels."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from ..base.deadline import Deadline
from ..geometry.transforms import Array
from .overlap_kernels import Rasters, overlaps
from .placements import Placements
from .shapes import Shape

_CELLS = 96  # across a shape's raster
_ROWS_BETWEEN_LOOKS = 16  # at the clock: some 10 ms, of a thousand instances


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


def overlap_matrix(
    shapes: list[Shape], placed: Placements, labels: np.ndarray, deadline: Deadline | None = None
) -> Array:
    """(K, K) share of the smaller one's area in common; 0 between classes: a sticker lies on its part.

    :param deadline: where it ends the work, the matrix is of the first placements alone.
    """
    count, done = len(placed), 0
    out = np.zeros((count, count))
    for rows in (deadline or Deadline()).parts(count, _ROWS_BETWEEN_LOOKS):
        args = placed.t, placed.z, placed.w, placed.shape, labels
        overlaps(_rasters(tuple(shapes)), *args, out, rows.start, rows.stop)
        done = rows.stop
    return out if done == count else out[:done, :done].copy()
