"""Gaps between a class and the next."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import lean

ENDS, SILENT, UNTOLD = range(3)  # what a label means to a gap: it ends it, is passed over, or leaves the pixel out


@lean
def gaps_px(padded: Any, mine: Any, means: Any, around: Any, gap_px: Any, out: Any) -> int:
    """Fill the first of out with the gaps, infinite where none is in reach, and say how many there are.

    :param padded: labels with a border, flat.
    :param mine: (n,) indices of pixels at a class' border, all of whose surroundings are in the image.
    :param means: (256,) what each label means.
    :param around, gap_px: (m,) where to look from a pixel on, nearest first, and how far off that is.
    """
    count = 0
    for at in mine:
        out[count], told = np.inf, 1
        for n in range(1, len(around)):
            what = means[padded[at + around[n]]]
            if what != SILENT:
                out[count], told = gap_px[n], 1 if what == ENDS else 0
                break
        count += told
    return count


@lean
def marked(flags: Any, words: Any, out: Any) -> None:
    """Fill out with the indices of the bytes of flags that are not 0, in their order.

    :param words: eight bytes at a time, as far as they fill some: most are 0 together.
    """
    count = 0
    for w in range(len(words)):
        if words[w] != 0:
            for i in range(8 * w, 8 * w + 8):
                if flags[i] != 0:
                    out[count] = i
                    count += 1
    for i in range(8 * len(words), len(flags)):
        if flags[i] != 0:
            out[count] = i
            count += 1
