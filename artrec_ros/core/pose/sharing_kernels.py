"""Pixels that like markers of one hypothesis lie on together, of which each is explained once.

Of two legs of which one is hidden both find the other one's foot. What the labels say there counts for the one for
which more speaks. The other one is left what is its own: most often that says nothing of it, or that it is not there.
"""

from __future__ import annotations

import math
from typing import Any

from ..base.jit import lean, melted
from ..geometry.pixel_kernels import turned
from .surface_kernels import LEAST_DEPTH_M, Room, Surface, SurfaceLimits, aspect

_RIM = 0.05  # of a marker: what is less of it on another one is its rim
_EDGE_ON = 1e-9  # square pixels to the second: of what is seen from its edge nothing lies on anything


@melted
def spread_px2(s: Surface, k: int, A: Any, at: Any, focal_px: float) -> tuple[float, float, float]:
    """Second moments of marker `k` in the image: xx, xy, yy. :param at: its middle in the camera's frame."""
    x, y, z = at
    xx, xy, yy = 0.0, 0.0, 0.0
    for i in range(2):
        ax, ay, az = turned(A, s.spread[k, i])
        u, v = focal_px / z * (ax - x / z * az), focal_px / z * (ay - y / z * az)
        xx, xy, yy = xx + u * u, xy + u * v, yy + v * v
    return xx, xy, yy


@lean
def on_each_other(s: Surface, j: int, k: int, R: Any, t: Any, f2: float) -> tuple[float, float]:
    """About which share of marker `j` lies on marker `k`, and of `k` on `j`: as much as normal distributions overlap
    that are as wide as they (the square of Bhattacharyya's coefficient; 1 of what lies on its like). It costs little
    and is smooth, so that a climb comes from one to the other.

    :param R, t: (C, 3, 3), (C, 3). :param f2: square of the focal length, pixels.
    """
    p, o, focal_px = s.patch_of[j], s.patch_of[k], math.sqrt(f2)
    A, B = R[s.component[p]], R[s.component[o]]
    _, ax, ay, az = aspect(s, p, A, t[s.component[p]])
    _, bx, by, bz = aspect(s, o, B, t[s.component[o]])
    if min(az, bz) <= LEAST_DEPTH_M:
        return 0.0, 0.0
    u, v = focal_px * (ax / az - bx / bz), focal_px * (ay / az - by / bz)
    reach = focal_px * (s.radius[p] / az + s.radius[o] / bz)
    if u * u + v * v > reach * reach:
        return 0.0, 0.0
    axx, axy, ayy = spread_px2(s, j, A, (ax, ay, az), focal_px)
    bxx, bxy, byy = spread_px2(s, k, B, (bx, by, bz), focal_px)
    mine, other = axx * ayy - axy * axy, bxx * byy - bxy * bxy
    if min(mine, other) < _EDGE_ON:
        return 0.0, 0.0
    xx, xy, yy = (axx + bxx) / 2, (axy + bxy) / 2, (ayy + byy) / 2
    both = xx * yy - xy * xy
    far = (u * u * yy - 2 * u * v * xy + v * v * xx) / both
    alike, ratio = math.sqrt(mine * other) / both * math.exp(-far / 4), math.sqrt(other / mine)
    return min(alike * ratio, 1.0), min(alike / ratio, 1.0)


@melted
def seen_share(s: Surface, p: int, A: Any, b: Any, f2: float, area_px: float) -> float:
    """Share of a patch in a frame (3, 3), (3,) that is seen, of what faces the camera."""
    cosine, _, _, z = aspect(s, p, A, b)
    full_px = s.area[p] * f2 / max(z, LEAST_DEPTH_M) ** 2 * cosine
    return min(area_px / full_px, 1.0) if full_px > 0.0 else 0.0


@lean
def choose_of_stacks(s: Surface, column: Any, votes: Any, area_px: Any, agree: Any) -> None:
    """Of markers that lie on each other leave what labels say of the one that they like best: the others are not there.

    :param column: (P,) where patches are among those that are asked about, -1: nowhere.
    """
    best, stack = -1, -1
    for p in s.stacked:
        lost = column[p]
        if lost >= 0 and s.stack[p] == stack:
            if votes[lost] > votes[best]:
                best, lost = lost, best
            votes[lost] = area_px[lost] = agree[lost] = 0.0
        elif lost >= 0:
            best, stack = lost, s.stack[p]


@lean
def explain_once(
    s: Surface, R: Any, t: Any, f2: float, limits: SurfaceLimits, strict: bool, room: Room, votes: Any, area_px: Any,
    agree: Any,
) -> None:  # fmt: skip
    """Take from what labels say of the patches (P,) of one hypothesis (C, 3, 3), (C, 3) what they say of likelier ones
    of their class as well.

    :param f2: square of the focal length, pixels. :param strict: who lies on another one must show the rest of itself.
    """
    taken, some = room.taken, False
    for n in range(len(s.pairs)):
        j, k = s.pairs[n, 0], s.pairs[n, 1]
        p, o = s.patch_of[j], s.patch_of[k]
        if votes[p] <= 0.0 or votes[o] <= 0.0:
            continue
        share, other = on_each_other(s, j, k, R, t, f2)
        if votes[p] >= votes[o]:
            j, p, o, share = k, o, p, other
        if share <= _RIM:
            continue
        # what is hidden of either lies on neither, and what the likelier one has no label on is not explained by it
        mine = seen_share(s, p, R[s.component[p]], t[s.component[p]], f2, area_px[p])
        its = seen_share(s, o, R[s.component[o]], t[s.component[o]], f2, area_px[o])
        taken[j] = max(taken[j], min((share + mine + its - 2.0) / max(mine, 1e-9), 1.0) * agree[o])
        some = True
    for k in range(len(taken) if some else 0):
        if taken[k] > _RIM:
            p, left = s.patch_of[k], max(1.0 - taken[k], 1e-9)
            votes[p] -= taken[k] * s.best[s.role[p]] * area_px[p]
            area_px[p] *= left
            agree[p] = min(max((agree[p] - taken[k]) / left, 0.0), 1.0)
            if strict and taken[k] > limits.shared and agree[p] < limits.rest_agree:
                votes[p], agree[p] = min(votes[p], 0.0), 0.0
        taken[k] = 0.0
