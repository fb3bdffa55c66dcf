"""A picture of what images showed of markers, with the outlines that were drawn and those that are measured."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from .outline_map import Traced

_CELL_PX, _CAPTION_PX, _COLUMNS = 360, 40, 4
_DRAWN, _SEEN, _INK = (200, 120, 0), (0, 0, 220), (40, 40, 40)  # BGR


def outlines_picture(traced: Sequence[Traced]) -> NDArray[np.uint8]:
    """(H, W, 3) BGR what was seen of each shape."""
    cells = [_cell(t) for t in traced] or [np.full((_CELL_PX, _CELL_PX, 3), 255, np.uint8)]
    wide = min(len(cells), _COLUMNS)
    cells += [np.full_like(cells[0], 255)] * (-len(cells) % wide)
    return np.vstack([np.hstack(cells[i : i + wide]) for i in range(0, len(cells), wide)])


def _cell(t: Traced) -> NDArray[np.uint8]:
    height, width = t.level.shape
    zoom = (_CELL_PX - _CAPTION_PX) / max(height, width)
    grey = cv2.cvtColor(cv2.resize(255 - t.level // 3, None, fx=zoom, fy=zoom), cv2.COLOR_GRAY2BGR)
    for outline, colour in ((t.drawn.outline, _DRAWN), (t.outline, _SEEN)):
        at = ((outline - t.corner) * (1, -1) * t.zoom + 0.5) * zoom - 0.5
        cv2.polylines(grey, [(at * 16).round().astype(np.int32)], True, colour, 1, cv2.LINE_AA, 4)
    cell = np.full((_CELL_PX, _CELL_PX, 3), 255, np.uint8)
    cell[_CAPTION_PX : _CAPTION_PX + grey.shape[0], : grey.shape[1]] = grey
    note = f"{t.drawn.name}: {1e3 * t.off_m:.1f} mm off, {t.images} images"
    cv2.putText(cell, note, (8, _CAPTION_PX - 14), cv2.FONT_HERSHEY_SIMPLEX, 0.45, _INK, 1, cv2.LINE_AA)
    return cell
