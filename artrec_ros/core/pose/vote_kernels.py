"""Votes of the label image for a surface under many hypotheses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base.jit import inlined, jit, lean
from ..geometry.pixel_kernels import LabelView, locate, outline_pixels, padded_pixel, turned
from ..model.chain_kernels import Chain, place_all
from .hiding_kernels import boxes_in_camera, boxes_in_front, hide
from .surface_kernels import LEAST_DEPTH_M, Room, Surface, SurfaceLimits, aspect, points_of, room_of


@inlined
def ring_votes(
    s: Surface, k: int, own: Any, A: Any, b: Any, view: LabelView, limits: SurfaceLimits, room: Room
) -> tuple[float, float]:
    """Mean vote of what lies just inside and just outside the contour of marker `k`, and the share of the contour
    within the image that does not lie amid its class; 0 where none is.

    :param own: (256,) how far each code is of its class.
    """
    outline_pixels(A, b, s.contour[k], s.contour_along[k], view, room.outline)
    u, v, nu, nv = room.outline[0], room.outline[1], room.outline[2], room.outline[3]
    outer, inner, ring_px = room.at[0], room.at[1], limits.ring_px
    out, into = s.table[s.ring_role[k]], s.table[s.rim_role[k]]
    m, ring, seen, amid, is_open = len(u), 0.0, 0, 0.0, s.open_ring[k]
    for i in range(m):
        outer[i] = padded_pixel(u[i] + ring_px * nu[i], v[i] + ring_px * nv[i], view)
        inner[i] = padded_pixel(u[i] - ring_px * nu[i], v[i] - ring_px * nv[i], view)
    for i in range(m):
        beyond = view.padded[outer[i]]
        if beyond != limits.outside:  # else not the marker ends there but the image
            ring += is_open[i] * out[beyond] + into[view.padded[inner[i]]]
            seen += 1
            amid += is_open[i] * own[beyond]
    return ring / m, (seen - amid) / max(seen, 1)


@jit
def score_patches(
    s: Surface, chain: Chain, R: Any, t: Any, q: Any, patches: Any, view: LabelView, limits: SurfaceLimits,
    occlusion: bool, votes: Any, area_px: Any, agree: Any,
) -> None:  # fmt: skip
    """Fill votes, area_px, agree (H, P) of hypotheses R (H, 3, 3), t (H, 3), q (H, J): see `spatial.PatchScores`."""
    room, scratch, n_c = room_of(s), np.empty((3, 3, 3)), len(chain.parent)
    frames_R, frames_t, joints = np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((2, q.shape[1], 3))
    for h in range(len(R)):
        place_all(chain, R[h], t[h], q[h], frames_R, frames_t, joints[0], joints[1], scratch)
        score_hypothesis(s, frames_R, frames_t, patches, view, limits, occlusion, room, votes[h], area_px[h], agree[h])


@lean
def score_hypothesis(
    s: Surface, R: Any, t: Any, patches: Any, view: LabelView, limits: SurfaceLimits, occlusion: bool, room: Room,
    votes: Any, area_px: Any, agree: Any,
) -> None:  # fmt: skip
    """The same for one hypothesis: (C, 3, 3), (C, 3), and (P,) each to fill."""
    blocked = occlusion and len(s.half) > 0
    f2 = view.K[0, 0] * view.K[1, 1]
    if blocked:
        boxes_in_camera(s, R, t, room.box_rotation, room.eye, room.middle)
    for column in range(len(patches)):
        p = patches[column]
        A, b = R[s.component[p]], t[s.component[p]]
        cosine, mx, my, mz = aspect(s, p, A, b)
        votes[column] = area_px[column] = agree[column] = 0.0
        if not (cosine > limits.least_cosine and mz > LEAST_DEPTH_M):
            continue
        n_near = boxes_in_front(s, p, turned(A, s.normal[p]), (mx, my, mz), room) if blocked else 0
        total, seen, same, role, own = 0.0, 0, 0.0, s.table[s.role[p]], s.own[s.role[p]]
        on, count = points_of(s, p), s.count[p]
        locate(A, b, on, view, room.at[0])
        if n_near:
            hide(s, A, b, on, room, n_near, limits.behind)
        for i in range(count):
            if n_near and room.hidden[i]:
                continue
            found = view.padded[room.at[0, i]]
            if found == limits.owned:
                continue
            seen += 1
            total += role[found]
            same += own[found]
        size, visible = s.area[p] * f2 / mz**2 * cosine, seen / count
        value, k = total / count * size, s.marker_of[p]
        if k >= 0 and visible > limits.ring_visible:
            ring, parted = ring_votes(s, k, own, A, b, view, limits, room)
            value = value * parted if value > 0.0 else value  # amid its class there is nothing to tell a marker by
            value += ring * ring_px2(s, k, cosine, mz, f2, limits)
        votes[column] = value
        area_px[column] = size * visible
        agree[column] = same / max(visible * count, 1.0)


@inlined
def ring_px2(s: Surface, k: int, cosine: float, depth: float, f2: float, limits: SurfaceLimits) -> float:
    """Pixels that a marker's ring stands for."""
    return s.perimeter[k] * (1 + min(cosine, 1.0)) / 2 * math.sqrt(f2) / depth * limits.ring_width_px
