"""The term of a fit that keeps an object near the height, and as upright, as what stands on the scene's floor is."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted


class FloorTerm(NamedTuple):
    """What is known of a pose before the image is looked at. Both weights are 0 where no floor is known."""

    up: Any  # (3,) upwards, in the camera
    height_m: float  # above the camera, of the place of what stands there
    weight: Any  # (2,) of a metre above it; of a radian by which it leans, to either side


@melted
def add_floor(term: FloorTerm, R: Any, t: Any, A: Any, b: Any) -> None:
    """Add the equations of a pose R (3, 3), t (3,) to the lower half of A, and b.

    A turn leans what leans by a vector x (about the horizontal axis about which it does, as long as the angle) by as
    much less as it turns about that axis; and turns about what points upwards lean nothing.
    """
    of_height, of_leaning = term.weight[0], term.weight[1]
    if of_height > 0.0 or of_leaning > 0.0:
        u, v, w = term.up[0], term.up[1], term.up[2]
        off = t[0] * u + t[1] * v + t[2] * w - term.height_m
        x, y, z = R[1, 2] * w - R[2, 2] * v, R[2, 2] * u - R[0, 2] * w, R[0, 2] * v - R[1, 2] * u
        sine, cosine = math.sqrt(x * x + y * y + z * z), R[0, 2] * u + R[1, 2] * v + R[2, 2] * w
        longer = math.atan2(sine, cosine) / max(sine, 1e-9)
        b[3] -= of_leaning * longer * x
        b[4] -= of_leaning * longer * y
        b[5] -= of_leaning * longer * z
        for i in range(3):
            b[i] += of_height * off * term.up[i]
            A[3 + i, 3 + i] += of_leaning
            for j in range(i + 1):
                A[i, j] += of_height * term.up[i] * term.up[j]
                A[3 + i, 3 + j] -= of_leaning * term.up[i] * term.up[j]


@jit
def add_floor_each(term: FloorTerm, R: Any, t: Any, A: Any, b: Any) -> None:
    """Add the equations of poses R (H, 3, 3), t (H, 3) to A (H, n, n), all of it, and b (H, n)."""
    one = np.empty((6, 6))
    for h in range(len(R)):
        one[:] = 0.0
        add_floor(term, R[h], t[h], one, b[h])
        for i in range(6):
            for j in range(6):
                A[h, i, j] += one[max(i, j), min(i, j)]
