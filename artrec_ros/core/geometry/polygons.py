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


def in_space(points: Array) -> Array:
    """(n, 3) the same points in the plane z = 0."""
    return np.column_stack([points, np.zeros(len(points))])
