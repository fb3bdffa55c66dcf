"""Distances to, and nearest points of, contours, all of a frame at once.

OpenCV's chamfer distance of 5 x 5 neighbours (Borgefors, *Distance transformations in digital images*, 1986), with its
lengths and its order of comparisons: it gives the values of `cv2.distanceTransformWithLabels`, in less time.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import jit
from ..image.contour_kernels import merge_boxes

_UNIT = 65536  # of the distances while they are summed
_STRAIGHT, _DIAGONAL, _KNIGHT = (np.float32(round(d * _UNIT)) for d in (1.0, 1.4, 2.1969))  # exact up to 256 px
_FAR = np.float32(2.0**30)


@jit
def bounding_boxes(pixels: Any, first: Any, margin: int) -> Any:
    """(B, 4) left, top, right, bottom (ends excluded) of blobs whose contours start at `first`, with a margin."""
    boxes = np.empty((len(first) - 1, 4), np.int64)
    for b in range(len(boxes)):
        left, top = int(pixels[first[b], 0]), int(pixels[first[b], 1])
        right, bottom = left, top
        for i in range(first[b] + 1, first[b + 1]):
            x, y = int(pixels[i, 0]), int(pixels[i, 1])
            left, top, right, bottom = min(left, x), min(top, y), max(right, x), max(bottom, y)
        boxes[b, 0], boxes[b, 1] = left - margin, top - margin
        boxes[b, 2], boxes[b, 3] = right + margin + 1, bottom + margin + 1
    return boxes


@jit
def hull(boxes: Any) -> Any:
    """(1, 4) the box around all of (n, 4)."""
    around = boxes[:1].copy()
    for box in boxes:
        for c in range(2):
            around[0, c] = min(around[0, c], box[c])
            around[0, c + 2] = max(around[0, c + 2], box[c + 2])
    return around


@jit
def _from_rows(best: Any, label: Any, one: Any, one_label: Any, two: Any, two_label: Any, step: int) -> None:
    """Spread the row before and the one before that to a row; `step`: 1 rightwards and down, -1 leftwards and up."""
    for i in range(len(best) - 4):
        t, of = best[i + 2], label[i + 2]
        for n in range(7):
            length = _STRAIGHT if n == 4 else _DIAGONAL if n == 3 or n == 5 else _KNIGHT
            at = np.uint32(i + 2 + step * (2 * n - 1 if n < 2 else n - 4))
            sum_n, label_n = (two[at], two_label[at]) if n < 2 else (one[at], one_label[at])
            sum_n += length
            nearer = sum_n < t
            t = sum_n if nearer else t
            of = label_n if nearer else of
        best[i + 2], label[i + 2] = t, of


@jit
def _along_row(best: Any, label: Any, start: int, end: int, step: int) -> None:
    t, of = best[start], label[start]
    for j in range(start + step, end, step):
        t += _STRAIGHT
        nearer = t < best[j]
        t, of = (t, of) if nearer else (best[j], label[j])
        best[j], label[j] = t, of


@jit
def chamfer(sums: Any, labels: Any) -> None:
    """Spread sums (float32) and labels (int32), both (h + 4, w + 4) with two rows and columns of padding, from where
    sums are 0."""
    rows, columns = sums.shape
    for i in range(2, rows - 2):
        _from_rows(sums[i], labels[i], sums[i - 1], labels[i - 1], sums[i - 2], labels[i - 2], 1)
        _along_row(sums[i], labels[i], 2, columns - 2, 1)
    for i in range(rows - 3, 1, -1):
        _from_rows(sums[i], labels[i], sums[i + 1], labels[i + 1], sums[i + 2], labels[i + 2], -1)
        _along_row(sums[i], labels[i], columns - 3, 1, -1)


@jit
def _fill_box(
    pixels: Any, cut: Any, first: Any, mine: Any, box: Any, steps_per_px: float, distance: Any, nearest: Any
) -> None:
    """Write one box of a slot from the contours of blobs `mine`; box and pixels have the slot's origin."""
    left, top, right, bottom = box
    sums = np.full((bottom - top + 4, right - left + 4), _FAR, np.float32)
    labels = np.zeros(sums.shape, np.int32)
    filled = False
    for b in mine:
        for i in range(first[b], first[b + 1]):
            x, y = pixels[i, 0] - left + 2, pixels[i, 1] - top + 2
            if not cut[i]:
                sums[y, x], labels[y, x] = 0.0, i
                filled = True
    if not filled:
        return
    chamfer(sums, labels)
    unit = np.float32(steps_per_px / _UNIT)
    for y in range(bottom - top):
        far, into = sums[y + 2, 2:-2], distance[top + y, left:right]
        for x in range(right - left):
            into[x] = np.uint8(min(np.rint(far[x] * unit), np.float32(255.0)))
        nearest[top + y, left:right] = labels[y + 2, 2:-2]


@jit
def fill_atlas(
    pixels: Any, cut: Any, first: Any, slot: Any, boxes: Any, steps_per_px: float, most_boxes: int, distance: Any,
    nearest: Any,
) -> None:  # fmt: skip
    """Write distances and nearest points of blobs whose contours start at `first`.

    :param slot: (B,) of each blob. :param boxes: (B, 4) around them. Boxes and pixels have the atlas' origin.
    :param most_boxes: that are looked at one by one. :param distance, nearest: (slots, h, w).
    """
    for s in range(len(distance)):
        own = np.flatnonzero(slot == s)
        apart = merge_boxes(boxes[own]) if len(own) <= most_boxes else hull(boxes[own])
        for box in apart:
            mine = [b for b in own if box[0] <= boxes[b, 0] < box[2] and box[1] <= boxes[b, 1] < box[3]]
            _fill_box(pixels, cut, first, mine, box, steps_per_px, distance[s], nearest[s])
