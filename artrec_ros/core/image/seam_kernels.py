"""Gaps between a class and the next."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import lean

ENDS, SILENT, UNTOLD = range(3)  # what a label means to a gap: it ends it, is passed over, or leaves the pixel out


@lean
def gaps_px(
    padded: Any, width: int, height: int, reach: int, mine: Any, label: int, means: Any, rows: Any, columns: Any,
    gap_px: Any, out: Any,
) -> int:  # fmt: skip
    """Fill the first of out with the gaps, infinite where none is in reach, and say how many there are.

    :param padded: labels with a border of one pixel, flat.
    :param reach: pixels nearer to the image's border have no gap.
    :param mine: (n,) flat indices, without that border, of the pixels of class `label`.
    :param means: (256,) what each label means.
    :param rows, columns, gap_px: (m,) where to look around a pixel, nearest first.
    """
    count = 0
    for i in mine:
        y, x = i // width, i % width
        if y < reach or x < reach or y >= height - reach or x >= width - reach:
            continue
        at = (y + 1) * (width + 2) + x + 1
        inner = True
        for n in range(1, 9):
            inner &= padded[at + rows[n] * (width + 2) + columns[n]] == label
        if inner:
            continue
        out[count], told = np.inf, 1
        for n in range(1, len(rows)):
            what = means[padded[at + rows[n] * (width + 2) + columns[n]]]
            if what != SILENT:
                out[count], told = gap_px[n], 1 if what == ENDS else 0
                break
        count += told
    return count
