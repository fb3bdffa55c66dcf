"""Closed polygons (n, 2): their measures, and their plane in space."""

from __future__ import annotations

import numpy as np

from .transforms import Array


def signed_area(outline: Array) -> float:
    """Greater than 0 where x to the right and y up it runs counter-clockwise: the shoelace formula."""
    x, y = outline.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)


def perimeter(outline: Array) -> float:
    return float(np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum())


def distance_to_outline(points: Array, outline: Array) -> Array:
    """(m,) distance of points (m, d) to the nearest side of a closed polygon (n, d), in the plane or in space."""
    a, b = outline, np.roll(outline, -1, axis=0)
    side = b - a  # (n, 2)
    rel = points[:, None] - a  # (m, n, 2)
    along = np.einsum("mnd,nd->mn", rel, side) / np.maximum(np.einsum("nd,nd->n", side, side), 1e-30)
    off = rel - np.clip(along, 0, 1)[..., None] * side
    return np.asarray(np.sqrt(np.min(np.einsum("mnd,mnd->mn", off, off), axis=1)))


def in_space(points: Array) -> Array:
    """(n, 3) the same points in the plane z = 0."""
    return np.column_stack([points, np.zeros(len(points))])
