"""Where the rays to points meet the boxes of another object."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import jit


@jit
def meet_boxes(boxes: Any, R: Any, t: Any, points: Any, parallel: float, out: Any) -> None:
    """Fill out (n,) with the least share of the way to points (n, 3) at which one of some boxes begins, be it behind
    them; inf: the ray meets none.

    :param boxes: see `occlusion.Opaque`.
    :param R, t: (C, 3, 3), (C, 3) frames of the components in the camera, as the points are.
    :param parallel: metres: a ray that goes less along an axis of a box goes along its side.
    """
    axes, eye = np.empty((3, 3)), np.empty(3)
    out[:] = np.inf
    for k in range(len(boxes.half)):
        A, b, half = R[boxes.component[k]], t[boxes.component[k]], boxes.half[k]
        for j in range(3):
            eye[j] = 0.0
            for i in range(3):
                axes[i, j] = A[i, 0] * boxes.R[k, 0, j] + A[i, 1] * boxes.R[k, 1, j] + A[i, 2] * boxes.R[k, 2, j]
                middle = b[i] + A[i, 0] * boxes.t[k, 0] + A[i, 1] * boxes.t[k, 1] + A[i, 2] * boxes.t[k, 2]
                eye[j] -= middle * axes[i, j]
        for n in range(len(points)):
            enter, leave = 0.0, np.inf
            for j in range(3):
                ray = points[n, 0] * axes[0, j] + points[n, 1] * axes[1, j] + points[n, 2] * axes[2, j]
                ray = ray if abs(ray) > parallel else parallel
                low, high = (-half[j] - eye[j]) / ray, (half[j] - eye[j]) / ray
                enter, leave = max(enter, min(low, high)), min(leave, max(low, high))
            if enter < leave:
                out[n] = min(out[n], enter)
