"""How likely pixels on markers are with each class that these may have."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import jit, melted
from ..geometry.pixel_kernels import LabelView, locate, turned
from ..model.chain_kernels import Chain, place_seen
from .hiding_kernels import ALL_BOXES, boxes_in_camera, boxes_in_front, hide
from .surface_kernels import LEAST_DEPTH_M, Room, Surface, SurfaceLimits, aspect, points_of, room_of, surface_share


@melted
def fill_likelihoods(
    s: Surface, p: int, A: Any, b: Any, says: Any, view: LabelView, limits: SurfaceLimits, room: Room, out: Any
) -> None:
    """Fill out (L,) with those of all pixels on marker `p` in a frame (3, 3), (3,).

    :param says: (L, 256) of each code.
    """
    n, f2 = s.count[p], view.K[0, 0] * view.K[1, 1]
    on = points_of(s, p, n)
    cosine, mx, my, mz = aspect(s, p, A, b)
    for k in range(len(out)):
        out[k] = 0.0
    if cosine <= limits.least_cosine or mz <= LEAST_DEPTH_M:
        return
    locate(A, b, on, view, room.at[0])
    n_near = boxes_in_front(s, p, A, turned(A, s.normal[p]), (mx, my, mz), room, ALL_BOXES)
    if n_near:
        hide(s, A, b, on, room, n_near, surface_share(s, p, mz, limits.behind))
    each_px = s.area[p] * f2 / mz**2 * cosine / n
    for i in range(n):
        code = view.padded[room.at[0, i]]
        if (n_near and room.hidden[i]) or code == limits.outside or code == limits.owned:
            continue
        for k in range(len(out)):
            out[k] += each_px * says[k, code]


@jit
def likelihoods(
    s: Surface, chain: Chain, R: Any, t: Any, q: Any, patches: Any, says: Any, view: LabelView, limits: SurfaceLimits,
    out: Any,
) -> None:  # fmt: skip
    """Fill out (H, M, L) with the logarithms of the likelihoods of all pixels on markers `patches` (M,) with each of L
    classes, under hypotheses R (H, 3, 3), t (H, 3), q (H, J); what is out of sight, or another's, says nothing.

    :param says: (M, L, 256) of each code.
    """
    room, scratch, n_c = room_of(s), np.empty((3, 3, 3)), len(chain.parent)
    frames_R, frames_t, joints = np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((2, q.shape[1], 3))
    for h in range(len(R)):
        place_seen(chain, R[h], t[h], q[h], frames_R, frames_t, joints[0], joints[1], scratch)
        boxes_in_camera(s, frames_R, frames_t, room.box_rotation, room.eye, room.middle)
        for m in range(len(patches)):
            c = s.component[patches[m]]
            fill_likelihoods(s, patches[m], frames_R[c], frames_t[c], says[m], view, limits, room, out[h, m])
