"""Similarities of a marker's views made poses in space."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base.jit import jit
from ..geometry.pixel_kernels import turned
from ..model.chain_kernels import about_axis, multiply


@jit
def lift(flips: Any, view: Any, T: Any, rays: Any, focal: float, origin: Any, R: Any, t: Any) -> None:
    """Fill R (F, H, 3, 3), t (F, H, 3) with the poses of similarities of views.

    The flat image plane of the weak perspective stands across the viewing ray, not across the optical axis.

    :param flips: (F, V, 3, 3); view: (H,); T: (H, 4); rays: (H, 2) of the similarities' centres, at depth 1.
    :param origin: (3,).
    """
    axis, roll, tilt, both = np.zeros(3), np.zeros((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    roll[2, 2] = 1.0
    for h in range(len(T)):
        x, y, depth = rays[h, 0], rays[h, 1], focal / T[h, 3]
        c, s = math.cos(T[h, 2]), math.sin(T[h, 2])
        roll[0, 0], roll[0, 1], roll[1, 0], roll[1, 1] = c, -s, s, c
        angle = math.sqrt(x * x + y * y)
        axis[0], axis[1] = (-y / angle, x / angle) if angle > 1e-12 else (1.0, 0.0)
        about_axis(axis, angle, tilt)
        multiply(tilt, roll, both)
        for k in range(flips.shape[0]):
            multiply(both, flips[k, view[h]], R[k, h])
            dx, dy, dz = turned(R[k, h], origin)
            t[k, h, 0], t[k, h, 1], t[k, h, 2] = depth * x + dx, depth * y + dy, depth + dz
