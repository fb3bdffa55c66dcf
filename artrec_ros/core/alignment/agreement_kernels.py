"""How placed outlines agree with contours, exactly: sub-pixel distances and normals at every point."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import jit, melted
from .refinement_kernels import agrees, look_up


@melted
def _note_seen(x: Any, y: Any, width: int, height: int, blank: Any, seen: Any) -> int:
    """Fill which points are in view; how many."""
    # The last row of pixels tells nothing of an edge there: a blob cut by the border ends on it too.
    for i in range(len(x)):
        seen[i] = (x[i] > 0.5) & (x[i] < width - 1.5) & (y[i] > 0.5) & (y[i] < height - 1.5)
    for n in range(0, len(blank), 4):
        left, top = blank[n] - 1.5, blank[n + 1] - 1.5
        right, bottom = left + 2 + blank[n + 2], top + 2 + blank[n + 3]
        for i in range(len(x)):
            seen[i] &= (x[i] < left) | (x[i] > right) | (y[i] < top) | (y[i] > bottom)
    return seen.sum()


@melted
def _match(index: Any, off: Any, nx: Any, ny: Any, seen: Any, tolerance: float, agreement: float, matched: Any) -> Any:
    """Fill the contour point that each point matches; (hits, worth) of those in view."""
    hits, worth, tolerance2 = 0, 0.0, tolerance * tolerance
    off_x, off_y, normal_x, normal_y = off[0], off[1], off[2], off[3]
    for i in range(len(index)):
        off2 = off_x[i] * off_x[i] + off_y[i] * off_y[i]
        good = (off2 <= tolerance2) & agrees(nx[i], ny[i], normal_x[i], normal_y[i], agreement)
        matched[i] = index[i] if good else -1
        hits += good & seen[i]
        worth += 1 - 0.5 * off2 / tolerance2 if good & seen[i] else 0.0
    return hits, worth


@jit
def evidence(
    contours: Any, shapes: Any, t: Any, z: Any, w: Any, shape: Any, slot: Any, tolerance: Any, agreement: float,
    size: Any, blank: Any,
) -> Any:  # fmt: skip
    """(share, score, visible, matched) as in `Evidence`."""
    count, samples = len(t), shapes.points.shape[1]
    share, score, visible = np.zeros(count), np.zeros(count), np.zeros(count)
    matched = np.empty((count, samples), np.int32)
    nearest, width, height, edge = contours.nearest.ravel(), contours.nearest.shape[1], contours.height, contours.edge
    all_nx, all_ny = shapes.normals.real.copy(), shapes.normals.imag.copy()
    x, y, nx, ny = np.empty(samples), np.empty(samples), np.empty(samples), np.empty(samples)
    seen, index, off = np.empty(samples, np.bool_), np.empty(samples, np.int32), np.empty((4, samples))
    for h in range(count):
        px, py, pnx, pny = shapes.x[shape[h]], shapes.y[shape[h]], all_nx[shape[h]], all_ny[shape[h]]
        # z p + w conj(p), and z n - w conj(n)
        across, along, cross = z[h].real + w[h].real, z[h].real - w[h].real, w[h].imag - z[h].imag
        lift = z[h].imag + w[h].imag
        for i in range(samples):
            x[i], y[i] = t[h].real + across * px[i] + cross * py[i], t[h].imag + lift * px[i] + along * py[i]
            nx[i], ny[i] = along * pnx[i] - lift * pny[i], across * pny[i] - cross * pnx[i]
        in_view = _note_seen(x, y, size[0], size[1], blank, seen)
        x -= contours.left
        y -= contours.top
        look_up(nearest, width, slot[h] * height, height, edge, x, y, index, off)
        hits, worth = _match(index, off, nx, ny, seen, tolerance[h], agreement, matched[h])
        share[h], score[h], visible[h] = hits / max(in_view, 1), worth / max(in_view, 1), in_view / samples
    return share, score, visible, matched


@jit
def stretches(index: Any, blob: Any, first: Any, count: Any, longest: int) -> Any:
    """`ContourMap.stretches`; contours are those of blobs that start at `first` and have `count` points."""
    held = np.zeros(len(blob), np.bool_)
    for i in range(len(index)):
        here, after = index[i], index[(i + 1) % len(index)]
        if here < 0:
            continue
        held[here] = True
        b = blob[here]
        if after < 0 or blob[after] != b:
            continue
        between = (after - here) % count[b]
        for step in range(1, between if between <= longest else 0):
            held[first[b] + (here - first[b] + step) % count[b]] = True
    return np.flatnonzero(held).astype(np.int32)
