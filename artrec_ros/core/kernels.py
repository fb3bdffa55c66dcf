"""Compiled twin of `SpatialModel.score`, used where numba is installed; cached on disk after its first run.

The numpy code in `spatial.py` says what is computed; this says the same a hypothesis and a point at a time, and
passes over patches that turn away. Sums are taken in another order, so votes agree to rounding.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

try:
    import numba
except ImportError:  # the numpy twin does the work
    numba = None

COMPILED = numba is not None


def _jit(function: Any) -> Any:
    if numba is None:
        return function
    try:
        return numba.njit(cache=True, nogil=True)(function)
    except RuntimeError:  # no folder that the cache could be written to: compiled anew in each process
        return numba.njit(nogil=True)(function)


@_jit
def _turned(A: Any, q: Any) -> tuple[float, float, float]:
    return (
        A[0, 0] * q[0] + A[0, 1] * q[1] + A[0, 2] * q[2],
        A[1, 0] * q[0] + A[1, 1] * q[1] + A[1, 2] * q[2],
        A[2, 0] * q[0] + A[2, 1] * q[1] + A[2, 2] * q[2],
    )


@_jit
def _pixel(px: float, py: float, width: int, height: int) -> int:
    """Index into the padded labels of the nearest pixel."""
    column = int(round(min(max(px, -1.0), float(width)))) + 1
    row = int(round(min(max(py, -1.0), float(height)))) + 1
    return row * (width + 2) + column


@_jit
def _project(x: float, y: float, z: float, K: Any, d: Any, bent: bool) -> tuple[float, float]:
    z = max(z, 1e-3)
    u, v = x / z, y / z
    if bent:
        r2 = min(u * u + v * v, 4.0)
        radial = (1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) / (1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])))
        u, v = (
            u * radial + 2 * d[2] * u * v + d[3] * (r2 + 2 * u * u),
            v * radial + d[2] * (r2 + 2 * v * v) + 2 * d[3] * u * v,
        )
    return K[0, 0] * u + K[0, 1] * v + K[0, 2], K[1, 1] * v + K[1, 2]


@_jit
def _is_hidden(x: float, y: float, z: float, box_R: Any, eye: Any, half: Any, surface: float) -> bool:
    """Slab test of the ray from the camera to a point against every box (B, 3, 3), (B, 3), (B, 3)."""
    for b in range(len(half)):
        enter, leave = 0.0, surface
        for i in range(3):
            ray = x * box_R[b, 0, i] + y * box_R[b, 1, i] + z * box_R[b, 2, i]
            if abs(ray) < 1e-9:
                ray = 1e-9
            near, far = (-half[b, i] - eye[b, i]) / ray, (half[b, i] - eye[b, i]) / ray
            if near > far:
                near, far = far, near
            enter, leave = max(enter, near), min(leave, far)
            if enter >= leave:
                break
        if enter < leave:
            return True
    return False


@_jit
def score_patches(
    R: Any, t: Any, patches: Any, starts: Any, points: Any, roles: Any, component: Any, normal: Any, centre: Any,
    area: Any, label: Any, marker_of: Any, contour: Any, contour_normal: Any, ring_role: Any, rim_role: Any,
    perimeter: Any, table: Any, padded: Any, width: int, height: int, K: Any, d: Any, bent: bool,
    box_R: Any, eye: Any, half: Any, occlusion: bool,
    least_cosine: float, ring_px: float, ring_width_px: float, surface: float,
    votes: Any, area_px: Any, agree: Any,
) -> None:  # fmt: skip
    """Fill votes, area_px and agree (H, P) as `SpatialModel.score` does.

    :param box_R, eye: (H, B, 3, 3) boxes in the camera and (H, B, 3) the camera's centre in the boxes' frames.
    """
    f2 = K[0, 0] * K[1, 1]
    f = math.sqrt(f2)
    for h in range(len(R)):
        for column in range(len(patches)):
            p = patches[column]
            A, b = R[h, component[p]], t[h, component[p]]
            nx, ny, nz = _turned(A, normal[p])
            mx, my, mz = _turned(A, centre[p])
            mx, my, mz = mx + b[0], my + b[1], mz + b[2]
            cosine = -(nx * mx + ny * my + nz * mz) / max(math.sqrt(mx * mx + my * my + mz * mz), 1e-9)
            votes[h, column] = area_px[h, column] = agree[h, column] = 0.0
            if not (cosine > least_cosine and mz > 0.02):
                continue
            total, seen, same = 0.0, 0, 0
            for i in range(starts[p], starts[p + 1]):
                x, y, z = _turned(A, points[i])
                x, y, z = x + b[0], y + b[1], z + b[2]
                if occlusion and _is_hidden(x, y, z, box_R[h], eye[h], half, surface):
                    continue
                seen += 1
                px, py = _project(x, y, z, K, d, bent)
                found = padded[_pixel(px, py, width, height)]
                total += table[roles[i], found]
                same += found == label[p]
            count = starts[p + 1] - starts[p]
            size = area[p] * f2 / mz**2 * cosine
            visible = seen / count
            value = total / count * size
            k = marker_of[p]
            if k >= 0 and visible > 0.5:
                ring = 0.0
                for i in range(contour.shape[1]):
                    x, y, z = _turned(A, contour[k, i])
                    x, y, z = x + b[0], y + b[1], z + b[2]
                    gx, gy, gz = _turned(A, contour_normal[k, i])
                    s = 1e-3 * max(z, 1e-3)
                    u0, v0 = _project(x, y, z, K, d, bent)
                    u1, v1 = _project(x + s * gx, y + s * gy, z + s * gz, K, d, bent)
                    length = max(math.sqrt((u1 - u0) ** 2 + (v1 - v0) ** 2), 1e-12)
                    du, dv = ring_px * (u1 - u0) / length, ring_px * (v1 - v0) / length
                    ring += table[ring_role[k], padded[_pixel(u0 + du, v0 + dv, width, height)]]
                    ring += table[rim_role[k], padded[_pixel(u0 - du, v0 - dv, width, height)]]
                squeeze = (1 + min(cosine, 1.0)) / 2
                value += ring / contour.shape[1] * perimeter[k] * squeeze * f / mz * ring_width_px
            votes[h, column] = value
            area_px[h, column] = size * visible
            agree[h, column] = same / max(visible * count, 1.0)


def empty_scores(n_hypotheses: int, n_patches: int) -> tuple[Any, Any, Any]:
    """Arrays that `score_patches` fills."""
    return tuple(np.empty((n_hypotheses, n_patches)) for _ in range(3))  # type: ignore[return-value]
