"""Points and turns spread evenly, the same ones each time."""

from __future__ import annotations

import numpy as np

from .transforms import Array, rotation_from_quaternion

_GOLDEN_RAD = np.pi * (3 - 5**0.5)


def spread(n: int, dimensions: int) -> Array:
    """(n, d) evenly spread points of the unit cube: multiples of the powers of Roberts' generalised golden ratio."""
    ratio = 2.0
    for _ in range(40):
        ratio = (1 + ratio) ** (1 / (dimensions + 1))
    return np.asarray((0.5 + np.arange(n)[:, None] * ratio ** -np.arange(1.0, dimensions + 1)) % 1, np.float64)


def all_turns(n: int) -> Array:
    """(n, 3, 3) evenly spread over all turns."""
    return turns_at(spread(n, 3))


def turns_at(even: Array) -> Array:
    """(n, 3, 3) spread as evenly over all turns as (n, 3) points are over the unit cube (Shoemake, 1992)."""
    share, a, b = even[:, 0], 2 * np.pi * even[:, 1], 2 * np.pi * even[:, 2]
    near, far = np.sqrt(1 - share), np.sqrt(share)
    quaternions = np.column_stack([near * np.sin(a), near * np.cos(a), far * np.sin(b), far * np.cos(b)])
    return np.stack([rotation_from_quaternion(q) for q in quaternions])


def all_around(n: int) -> Array:
    """(n, 3) directions, evenly spread: those of Fibonacci's lattice on the sphere."""
    height = 1 - (2 * np.arange(n) + 1) / n
    radius, around = np.sqrt(1 - height**2), _GOLDEN_RAD * np.arange(n)
    return np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=1)
