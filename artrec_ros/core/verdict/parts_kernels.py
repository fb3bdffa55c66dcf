"""Which of an object's markers lie on each other in the image, an object at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import jit, lean, melted
from ..geometry.pixel_kernels import LabelView, project
from ..model.chain_kernels import Chain, place_seen
from ..pose.covering_kernels import contains
from ..pose.surface_kernels import Surface


@melted
def place_one(A: Any, b: Any, x: float, y: float, z: float, view: LabelView) -> tuple[float, float]:
    """Pixel of a point x, y, z under A X + b."""
    return project(
        A[0, 0] * x + A[0, 1] * y + A[0, 2] * z + b[0],
        A[1, 0] * x + A[1, 1] * y + A[1, 2] * z + b[1],
        A[2, 0] * x + A[2, 1] * y + A[2, 2] * z + b[2],
        view,
    )


@lean
def fill_places(s: Surface, p: int, A: Any, b: Any, view: LabelView, inside: Any, outline: Any, box: Any) -> None:
    """Pixels of a marker's points (n, 2) and of its outline (m, 2), and the outline's bounding box (4,)."""
    first, m = s.starts[p], s.marker_of[p]
    for i in range(s.count[p]):
        x, y, z = s.points[0, first + i], s.points[1, first + i], s.points[2, first + i]
        inside[i, 0], inside[i, 1] = place_one(A, b, x, y, z, view)
    box[0], box[1], box[2], box[3] = np.inf, np.inf, -np.inf, -np.inf
    for i in range(len(outline)):
        x, y = place_one(A, b, s.contour[m, 0, i], s.contour[m, 1, i], s.contour[m, 2, i], view)
        outline[i, 0], outline[i, 1] = x, y
        box[0], box[1], box[2], box[3] = min(box[0], x), min(box[1], y), max(box[2], x), max(box[3], y)


@jit
def shares_alone(
    s: Surface, chain: Chain, view: LabelView, R: Any, t: Any, q: Any, shown: Any, votes: Any, alike: Any, out: Any
) -> None:
    """Fill out (H, C) with the share of what shows each component that is not on a sibling's of its class with more
    votes; 1 where nothing shows it.

    :param shown: (H, C) patches, -1: none. :param votes: (H, C) of each component. :param alike: (P, P) bool: patches
        that may be of one class.
    """
    n_c, m, most = len(chain.parent), s.contour.shape[2], 0
    for p in range(len(s.count)):
        most = max(most, s.count[p])
    frames_R, frames_t, scratch = np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((3, 3, 3))
    joints = np.empty((2, q.shape[1], 3))
    inside, outline, box = np.empty((n_c, most, 2)), np.empty((n_c, m, 2)), np.empty((n_c, 4))
    for h in range(len(R)):
        place_seen(chain, R[h], t[h], q[h], frames_R, frames_t, joints[0], joints[1], scratch)
        for c in range(n_c):
            out[h, c] = 1.0
            if shown[h, c] >= 0:
                fill_places(s, shown[h, c], frames_R[c], frames_t[c], view, inside[c], outline[c], box[c])
        for c in range(n_c):
            if shown[h, c] < 0:
                continue
            covered, n = 0, s.count[shown[h, c]]
            for i in range(n):
                x, y = inside[c, i, 0], inside[c, i, 1]
                for o in range(n_c):
                    if o == c or shown[h, o] < 0 or not alike[shown[h, c], shown[h, o]]:
                        continue
                    if votes[h, o] < votes[h, c] or (votes[h, o] == votes[h, c] and o > c):
                        continue
                    near = box[o, 0] <= x <= box[o, 2] and box[o, 1] <= y <= box[o, 3]
                    if near and contains(outline[o].T, x, y):
                        covered += 1
                        break
            out[h, c] = 1.0 - covered / n
