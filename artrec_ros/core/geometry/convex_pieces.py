"""Outlines as convex pieces: what is no convex shape covers less than its convex hull."""

from __future__ import annotations

import cv2
import numpy as np

from .polygons import signed_area
from .transforms import Array

_NOTCH = 0.05  # of the root of an outline's area: notches less deep are filled, as few images show as much


def convex_pieces(outline: Array) -> list[Array]:
    """Polygons (m, 2) whose convex hulls together cover a simple closed polygon (n, 2) and hardly more; of one that is
    all but convex itself."""
    outline = outline[(outline != np.roll(outline, 1, axis=0)).any(axis=1)]  # a corner that is given twice is one
    area = signed_area(outline)
    return _pieces(outline if area > 0 else outline[::-1], _NOTCH * float(np.sqrt(abs(area))))


def _pieces(outline: Array, notch: float) -> list[Array]:
    """Cut at the deepest notch, to the corner that leaves the shallowest ones. :param outline: counter-clockwise."""
    depth, inwards = _depths(outline), _turns(outline) < 0
    if not inwards.any() or depth[inwards].max() <= notch:
        return [outline]
    corner = int(np.argmax(np.where(inwards, depth, -1.0)))
    ways = [_cut(outline, corner, end) for end in range(len(outline)) if _within(outline, corner, end)]
    if not ways:  # a polygon that touches itself
        return [outline]
    one, other = min(ways, key=lambda two: max(_deepest(part) for part in two))
    return [*_pieces(one, notch), *_pieces(other, notch)]


def _cut(outline: Array, start: int, end: int) -> tuple[Array, Array]:
    a, b = sorted((start, end))
    return outline[a : b + 1], np.concatenate([outline[b:], outline[: a + 1]])


def _deepest(outline: Array) -> float:
    return float(np.where(_turns(outline) < 0, _depths(outline), 0.0).max())


def _turns(outline: Array) -> Array:
    """(n,) greater than 0 where a counter-clockwise polygon bulges."""
    before, after = outline - np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0) - outline
    return np.asarray(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])


def _depths(outline: Array) -> Array:
    """(n,) how far corners lie within the convex hull."""
    hull = cv2.convexHull(outline.astype(np.float32))
    return np.array([cv2.pointPolygonTest(hull, (float(x), float(y)), True) for x, y in outline])


def _within(outline: Array, start: int, end: int) -> bool:
    """Whether the way from a corner to another one runs inside of a counter-clockwise polygon."""
    n = len(outline)
    if (end - start) % n in (0, 1, n - 1):
        return False
    p, q, a, b = outline[start], outline[end], outline, np.roll(outline, -1, axis=0)
    apart = ~np.isin(np.arange(n), [start, end, (start - 1) % n, (end - 1) % n])  # sides that do not begin or end there
    one, other = _side(p, q, a), _side(p, q, b)
    crossed = (one * other <= 0) & (_side(a, b, p) * _side(a, b, q) <= 0)
    crossed &= (one != 0) | (other != 0)  # a side along the way is reached by others
    x, y = (p + q) / 2
    return not (crossed & apart).any() and cv2.pointPolygonTest(outline.astype(np.float32), (x, y), False) > 0


def _side(p: Array, q: Array, of: Array) -> Array:
    """Greater than 0 to the left of the line from p to q."""
    return np.asarray((q - p)[..., 0] * (of - p)[..., 1] - (q - p)[..., 1] * (of - p)[..., 0])
