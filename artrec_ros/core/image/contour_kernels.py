"""Chains of boundary pixels made into contours, all of a frame at once.

A chain runs through pixel centres, so a shape is measured too small. Its true edge is off by half a pixel along the
axis on which the edge is steeper: 0.5 max(|nx|, |ny|) along the normal.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import jit, melted


@melted
def wrapped(i: int, n: int) -> int:
    """The index of a closed contour's point, less than once around from where it begins: a division takes longer."""
    return i - n if i >= n else (i + n if i < 0 else i)


@jit
def _outline(
    chain: Any, width: int, height: int, blank: Any, pixels: Any, contour: Any, normals: Any, cut: Any
) -> None:
    n = len(chain)
    doubled = 0
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        doubled += int(chain[i, 0]) * int(chain[j, 1]) - int(chain[j, 0]) * int(chain[i, 1])
    for i in range(n):
        pixels[i] = chain[i] if doubled >= 0 else chain[n - 1 - i]
    reach = min(max(n // 12, 1), 5)  # differences over several spans smooth the staircase of a chain code
    for i in range(n):
        x, y = pixels[i, 0], pixels[i, 1]
        dx, dy = 0, 0
        for s in range(1, reach + 1):
            after, before = wrapped(i + s, n), wrapped(i - s, n)
            dx += pixels[after, 0] - pixels[before, 0]
            dy += pixels[after, 1] - pixels[before, 1]
        length = np.sqrt(float(dx * dx + dy * dy))
        if length > 0:
            normals[i, 0], normals[i, 1] = dy / length, -dx / length
        half = 0.5 * max(abs(normals[i, 0]), abs(normals[i, 1]))
        after, before = wrapped(i + 1, n), wrapped(i - 1, n)
        for c in range(2):
            # The nearest of a staircase's points is one of its outer steps; smoothed, it lies on the mean again.
            smooth = 0.25 * pixels[before, c] + 0.5 * pixels[i, c] + 0.25 * pixels[after, c]
            contour[i, c] = smooth + half * normals[i, c]
        cut[i] = x == 0 or y == 0 or x == width - 1 or y == height - 1
        for r in range(len(blank)):
            left, top, w, h = blank[r]
            cut[i] = cut[i] or (left - 1 <= x <= left + w and top - 1 <= y <= top + h)


@jit
def outlines(chains: Any, first: Any, width: int, height: int, blank: Any) -> Any:
    """(pixels, contour, normals, cut) as in `Blob`, of several blobs one after another.

    :param chains: (n, 2); each blob's starts at `first`. :param blank: (r, 4) rectangles.
    """
    n = len(chains)
    pixels, contour, normals = np.empty((n, 2), np.int32), np.empty((n, 2)), np.zeros((n, 2))
    cut = np.zeros(n, np.bool_)
    for b in range(len(first) - 1):
        i, j = first[b], first[b + 1]
        _outline(chains[i:j], width, height, blank, pixels[i:j], contour[i:j], normals[i:j], cut[i:j])
    return pixels, contour, normals, cut


@jit
def merge_boxes(boxes: Any) -> Any:
    """(m, 4) boxes (left, top, right, bottom; ends excluded) that do not overlap and hold all of (n, 4)."""
    merged = boxes.copy()
    n, changed = len(merged), True
    while changed:
        changed = False
        i = 0
        while i < n:
            j = i + 1
            while j < n:
                a, b = merged[i], merged[j]
                if a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]:
                    for c in range(2):
                        merged[i, c] = min(a[c], b[c])
                        merged[i, c + 2] = max(a[c + 2], b[c + 2])
                    merged[j] = merged[n - 1]
                    n -= 1
                    changed = True
                else:
                    j += 1
            i += 1
    return merged[:n]
