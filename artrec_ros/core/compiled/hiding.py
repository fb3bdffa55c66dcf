"""Points that boxes hide from the camera: twin of `occlusion.Boxes.hidden`."""

from __future__ import annotations

from typing import Any

from .geometry import turned
from .jit import lean


@lean
def hidden(R: Any, eye: Any, half: Any, X: Any, ignored: Any, end: float, out: Any) -> None:
    """Fill out (H, n) with which of the points X (H, n, 3) one of B boxes hides (slab test).

    :param R: (H, B, 3, 3) of the boxes, transposed; eye: (H, B, 3) the camera's centre in their frames; half: (B, 3).
    :param ignored: (n, B) boxes that cannot hide a point.
    :param end: share of the way to a point beyond which a box no longer hides it.
    """
    for h in range(len(X)):
        for i in range(X.shape[1]):
            out[h, i] = False
            for b in range(len(half)):
                if ignored[i, b] or out[h, i]:
                    continue
                ray = turned(R[h, b], X[h, i])
                enter, leave = 0.0, end
                for axis in range(3):
                    along = 1.0 / (ray[axis] if abs(ray[axis]) >= 1e-9 else 1e-9)
                    near, far = (-half[b, axis] - eye[h, b, axis]) * along, (half[b, axis] - eye[h, b, axis]) * along
                    enter, leave = max(enter, min(near, far)), min(leave, max(near, far))
                out[h, i] = enter < leave
