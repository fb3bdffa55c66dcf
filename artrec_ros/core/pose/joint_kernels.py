"""Search of joints' values, one after the other, a hypothesis at a time, with what cannot win left out."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base.jit import jit, melted
from ..geometry.pixel_kernels import LabelView, locate
from ..model.chain_kernels import Chain, copy_frame, place, see
from .surface_kernels import (
    LEAST_DEPTH_M,
    MOST_LENGTH,
    MOST_WEIGHT,
    Room,
    Surface,
    SurfaceLimits,
    aspect,
    count_for,
    is_near,
    is_turned_here,
    points_of,
    room_of,
    weigh_points,
)
from .vote_kernels import ring_px2, ring_votes


@melted
def patch_bound(
    s: Surface, p: int, A: Any, b: Any, view: LabelView, limits: SurfaceLimits, wanted: float, room: Room
) -> float:
    """Votes of a patch that nothing hides; where these stay below `wanted`, any value below it."""
    cosine, _, _, mz = aspect(s, p, A, b)
    f2 = view.K[0, 0] * view.K[1, 1]
    if not (is_turned_here(s, p, cosine, mz, f2, limits.least_cosine) and mz > LEAST_DEPTH_M):
        return 0.0
    size, total, k = s.area[p] * f2 / mz**2 * cosine, 0.0, s.marker_of[p]
    count = count_for(s, p, size, limits)
    on = points_of(s, p, count)
    ring = ring_px2(s, k, cosine, mz, f2, limits) if k >= 0 else 0.0
    share, near = size / count, is_near(s, p, mz)
    up = (s.best[s.ring_role[k]] + s.best[s.rim_role[k]]) * (MOST_LENGTH if near else 1.0) if k >= 0 else 0.0
    most = ring * up
    role, best = s.table[s.role[p]], s.best[s.role[p]] * (MOST_WEIGHT if near else 1.0)
    if size * best + most < wanted:
        return size * best + most
    locate(A, b, on, view, room.at[0])
    if near:
        weigh_points(A, b, on, mz, room.weight)
    for i in range(count):
        total += (room.weight[i] if near else 1.0) * role[view.padded[room.at[0, i]]]
    if total * share + most < wanted or k < 0:
        return total * share + most
    mean, parted = ring_votes(s, k, s.own[s.role[p]], A, b, mz, near, False, view, limits, room)
    return (total * share * parted if total > 0.0 else total * share) + mean * ring


@melted
def best_joint(
    s: Surface, chain: Chain, c: int, patches: Any, R: Any, t: Any, grid: Any, view: LabelView, limits: SurfaceLimits,
    most: Any, scratch: Any, room: Room,
) -> float:  # fmt: skip
    """Joint value of component `c` that the labels like best; R, t (C, ...) of one hypothesis get its frame there.

    :param grid: values to try; NaN ends them.
    :param most: (P,) upper bounds of each patch's votes, filled here.
    :param scratch: (4, 3, 3).
    """
    f2 = view.K[0, 0] * view.K[1, 1]
    best_value, best_votes, A, b = grid[0], -np.inf, scratch[3], scratch[2, 2]
    for value in grid:
        if math.isnan(value):
            break
        place(chain, c, R, t, value, scratch[2, 0], scratch[2, 1], scratch[0], scratch[1])
        see(chain, c, R, t, A, b)
        rest = 0.0
        for p in patches:  # what the labels could say at most
            cosine, _, _, mz = aspect(s, p, A, b)
            most[p], k = 0.0, s.marker_of[p]
            if is_turned_here(s, p, cosine, mz, f2, limits.least_cosine) and mz > LEAST_DEPTH_M:
                near = is_near(s, p, mz)
                weight = MOST_WEIGHT if near else 1.0
                most[p] = max(s.area[p] * f2 / mz**2 * cosine * weight * s.best[s.role[p]], 0.0)
                if k >= 0:
                    up = (s.best[s.ring_role[k]] + s.best[s.rim_role[k]]) * (MOST_LENGTH if near else 1.0)
                    most[p] += ring_px2(s, k, cosine, mz, f2, limits) * up
            rest += most[p]
        told, last, stack = 0.0, 0.0, -1  # of a stack the best one counts
        for p in patches:
            rest -= most[p]
            wanted = best_votes - (told + last) - rest if s.stack[p] < 0 else -np.inf
            said = patch_bound(s, p, A, b, view, limits, wanted, room)
            if s.stack[p] >= 0 and s.stack[p] == stack:
                last = max(last, said)
            else:
                told, last, stack = told + last, said, s.stack[p]
            if told + (last if stack < 0 else max(last, 0.0)) + rest < best_votes:
                break
        else:
            if told + last > best_votes:
                best_value, best_votes = value, told + last
    place(chain, c, R, t, best_value, scratch[2, 0], scratch[2, 1], scratch[0], scratch[1])
    return best_value


@melted
def search_one(
    s: Surface, chain: Chain, order: Any, starts: Any, R_object: Any, t_object: Any, q: Any, grids: Any,
    view: LabelView, limits: SurfaceLimits, R: Any, t: Any, most: Any, scratch: Any, room: Room,
) -> None:  # fmt: skip
    """Fill the joints q (J,) and the frames R (C, 3, 3), t (C, 3) of one hypothesis (3, 3), (3,).

    :param order: (P,) patches by component, those of `c` from starts[c] to starts[c + 1].
    """
    for c in range(len(chain.parent)):
        j = chain.joint_of[c]
        if chain.parent[c] < 0:
            copy_frame(R_object, t_object, R[c], t[c])
        elif j >= 0:
            mine = order[starts[c] : starts[c + 1]]
            q[j] = best_joint(s, chain, c, mine, R, t, grids[j], view, limits, most, scratch, room)
        else:
            place(chain, c, R, t, 0.0, scratch[2, 0], scratch[2, 1], scratch[0], scratch[1])


@jit
def search_joints(
    s: Surface, chain: Chain, order: Any, starts: Any, R: Any, t: Any, q: Any, grids: Any, view: LabelView,
    limits: SurfaceLimits,
) -> None:  # fmt: skip
    """Fill q (H, J) of hypotheses R (H, 3, 3), t (H, 3) with the values in `grids` (J, n; NaN ends a row) at which the
    labels like each component best, parents first; order and starts as in `search_one`."""
    n_c = len(chain.parent)
    frames_R, frames_t = np.empty((n_c, 3, 3)), np.empty((n_c, 3))
    most, scratch, room = np.empty(len(s.area)), np.empty((4, 3, 3)), room_of(s)
    for h in range(len(R)):
        search_one(
            s, chain, order, starts, R[h], t[h], q[h], grids, view, limits, frames_R, frames_t, most, scratch, room
        )
