"""The best of every place, modulo symmetry."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import jit, melted


@melted
def symmetry_order(residual: Any, scale: float, ambiguous_px: float) -> int:
    """`Symmetry.order`; 0: any angle."""
    if residual[0] * scale <= ambiguous_px:
        return 0
    order = 1
    for n in range(2, len(residual)):
        if residual[n] * scale <= ambiguous_px:
            order = n
    return order


@melted
def squared_pose_distance(
    t: complex, z: complex, t0: complex, z0: complex, radius: float, order: int, enough: float
) -> float:
    """Mean squared distance in pixels between a shape placed by (t, z) and by (t0, z0), modulo its symmetry.

    For points p about the centroid with rms radius r: |t - t0|^2 + r^2 |z - z0|^2; the first term alone where that is
    above `enough`.
    """
    dx, dy = t.real - t0.real, t.imag - t0.imag
    place = dx * dx + dy * dy
    if place > enough:
        return place
    a, b = z.real * z.real + z.imag * z.imag, z0.real * z0.real + z0.imag * z0.imag
    if order == 0:
        turn = (np.sqrt(a) - np.sqrt(b)) ** 2
    else:
        re = z.real * z0.real + z.imag * z0.imag
        im = z.imag * z0.real - z.real * z0.imag
        best = re
        for n in range(1, order):
            angle = 2 * np.pi * n / order
            best = max(best, re * np.cos(angle) + im * np.sin(angle))
        turn = a + b - 2 * best
    return place + radius * radius * max(turn, 0.0)


@jit
def thin_out(t: Any, z: Any, quota: int, radius: float, residual: Any, symmetry_px: float, same_place: float) -> Any:
    """Indices of the best of each place, at most `quota`: `refinement.suppress` for one group, best first."""
    kept = np.empty(min(quota, len(t)), np.int64)
    order, reach2 = np.empty(len(kept), np.int64), np.empty(len(kept))
    n = 0
    for i in range(len(t)):
        if n == len(kept):
            break
        near = False
        for j in range(n):
            if squared_pose_distance(t[i], z[i], t[kept[j]], z[kept[j]], radius, order[j], reach2[j]) <= reach2[j]:
                near = True
                break
        if not near:
            k = abs(z[i])
            order[n] = symmetry_order(residual, k, symmetry_px)
            reach2[n] = max(1.0, same_place * radius * k) ** 2
            kept[n] = i
            n += 1
    return kept[:n]


@jit
def suppress(
    order: Any, group: Any, t: Any, z: Any, w: Any, shape: Any, quota: Any, shapes: Any, symmetry_px: float,
    same_place: float,
) -> Any:  # fmt: skip
    """`refinement.suppress`; `order` sorts by group and then by score."""
    kept, n = np.empty(len(order), np.int64), 0
    first, before = 0, -1  # of the group
    for i in order:
        if group[i] != before:
            first, before = n, group[i]
        if n - first >= quota[i]:
            continue
        near, radius = False, shapes.radius[shape[i]]
        for j in kept[first:n]:
            k = abs(z[j]) + abs(w[j])
            reach2 = max(1.0, same_place * radius * k) ** 2
            turns = symmetry_order(shapes.residual[shape[i]], k, symmetry_px)
            squeezed = radius * (abs(w[i]) - abs(w[j]))
            if squared_pose_distance(t[i], z[i], t[j], z[j], radius, turns, reach2) + squeezed**2 <= reach2:
                near = True
                break
        if not near:
            kept[n] = i
            n += 1
    return kept[:n]
