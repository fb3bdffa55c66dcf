"""Search of all joints of a hypothesis together: several ways to bend it side by side, parents first."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, lean, melted
from ..geometry.pixel_kernels import LabelView
from ..model.chain_kernels import Chain, copy_frame, place, see
from .joint_kernels import patch_bound
from .surface_kernels import LEAST_DEPTH_M, Room, Surface, SurfaceLimits, aspect, is_turned_here, room_of

_ALL = -np.inf  # of the votes that are wanted: none is left out
_HALVED = 2  # times, the step at which a peak's place is looked for


class Branches(NamedTuple):
    """The order in which components are looked at."""

    line: Any  # (C,) each branch from its root to its ends, then the next
    begins: Any  # (C,) bool: a branch that hangs on what no joint moves
    patches: Any  # (P,) by component
    starts: Any  # (C + 1,) of each component's patches in these


class Ways(NamedTuple):
    """W ways to bend an object."""

    R: Any  # (W, C, 3, 3)
    t: Any  # (W, C, 3)
    q: Any  # (W, J)
    votes: Any  # (W,)


class Best(NamedTuple):
    """The W best of what comes next, best first: their votes, of which way each is, and its joint."""

    votes: Any  # (W,)
    way: Any  # (W,)
    value: Any  # (W,)


class Bench(NamedTuple):
    """Where a component is tried."""

    said: Any  # (2, n) its votes at each value of its joint, and what they count
    axes: Any  # (3, 3)
    turns: Any  # (3, 3, 3)
    room: Room


@melted
def said_of_component(
    s: Surface, patches: Any, A: Any, b: Any, view: LabelView, limits: SurfaceLimits, hidden_cost: float, room: Room
) -> tuple[float, float]:
    """Votes of a component at a frame, and what they count: as hidden, at a price, where it speaks against itself."""
    votes, area, last, last_px, stack, f2 = 0.0, 0.0, 0.0, 0.0, -1, view.K[0, 0] * view.K[1, 1]
    for p in patches:
        said, size = patch_bound(s, p, A, b, view, limits, _ALL, room), 0.0
        cosine, _, _, depth = aspect(s, p, A, b)
        here = is_turned_here(s, p, cosine, depth, f2, limits.least_cosine)
        if s.marker_of[p] >= 0 and here and depth > LEAST_DEPTH_M:
            size = s.area[p] * f2 / depth**2 * cosine
        if s.stack[p] < 0 or s.stack[p] != stack:
            votes, area, last, last_px, stack = votes + last, area + last_px, said, size, s.stack[p]
        elif said > last:  # of a stack the best one counts
            last, last_px = said, size
    votes, area = votes + last, area + last_px
    return votes, max(votes, -hidden_cost * area)


@lean
def said_at(
    s: Surface, chain: Chain, c: int, patches: Any, R: Any, t: Any, value: float, view: LabelView,
    limits: SurfaceLimits, hidden_cost: float, bench: Bench,
) -> tuple[float, float]:  # fmt: skip
    """`said_of_component` c at a value of its joint, where it is put: R (C, 3, 3), t (C, 3) of one way."""
    place(chain, c, R, t, value, bench.axes[0], bench.axes[1], bench.turns[0], bench.turns[1])
    A, b = bench.turns[2], bench.axes[2]
    see(chain, c, R, t, A, b)
    return said_of_component(s, patches, A, b, view, limits, hidden_cost, bench.room)


@lean
def insert(votes: float, way: int, value: float, n: int, best: Best) -> int:
    """Put one among the `n` best so far; how many they are then."""
    k = min(n, len(best.votes) - 1)
    if n == len(best.votes) and votes <= best.votes[k]:
        return n
    while k > 0 and best.votes[k - 1] < votes:
        best.votes[k], best.way[k], best.value[k] = best.votes[k - 1], best.way[k - 1], best.value[k - 1]
        k -= 1
    best.votes[k], best.way[k], best.value[k] = votes, way, value
    return min(n + 1, len(best.votes))


@lean
def follow(
    s: Surface, chain: Chain, c: int, patches: Any, ways: Ways, w: int, grid: Any, ends: Any, view: LabelView,
    limits: SurfaceLimits, hidden_cost: float, bench: Bench, n: int, best: Best,
) -> int:  # fmt: skip
    """Put one way's peaks of the votes of component `c` along its joint among the `n` best; how many they are then."""
    R, t, votes, counted, m = ways.R[w], ways.t[w], bench.said[0], bench.said[1], 0
    while m < len(grid) and not math.isnan(grid[m]):
        votes[m], counted[m] = said_at(s, chain, c, patches, R, t, grid[m], view, limits, hidden_cost, bench)
        m += 1
    for i in range(m):
        if (i > 0 and votes[i] < votes[i - 1]) or (i < m - 1 and votes[i] < votes[i + 1]):
            continue  # where nothing is seen of it all values are as good
        value, most, counts, step = grid[i], votes[i], counted[i], (grid[1] - grid[0]) / 2
        for _ in range(_HALVED):
            middle = value
            for side in (-step, step):
                at = min(max(middle + side, ends[0]), ends[1])
                said = said_at(s, chain, c, patches, R, t, at, view, limits, hidden_cost, bench)
                if said[0] > most:
                    value, most, counts = at, said[0], said[1]
            step /= 2
        n = insert(ways.votes[w] + counts, w, value, n, best)
    return n


@lean
def go_on(chain: Chain, c: int, now: Ways, n: int, best: Best, then: Ways, bench: Bench) -> None:
    """Fill `then` with the `n` best of what comes after `now`."""
    for k in range(n):
        w = best.way[k]
        for other in range(len(chain.parent)):
            copy_frame(now.R[w, other], now.t[w, other], then.R[k, other], then.t[k, other])
        for j in range(now.q.shape[1]):
            then.q[k, j] = now.q[w, j]
        then.q[k, chain.joint_of[c]], then.votes[k] = best.value[k], best.votes[k]
        place(
            chain, c, then.R[k], then.t[k], best.value[k], bench.axes[0], bench.axes[1], bench.turns[0], bench.turns[1]
        )


@jit
def bend(
    s: Surface, chain: Chain, branches: Branches, R: Any, t: Any, grids: Any, ends: Any, view: LabelView,
    limits: SurfaceLimits, hidden_cost: float, out: Any,
) -> int:  # fmt: skip
    """Fill out (W, J) with the joints at which the labels like the components of an object at R (3, 3), t (3,) best
    together; how many these are.

    Of each joint the peaks of its component's votes are followed on, W ways to bend the object at a time. Branches that
    hang on what no joint moves know nothing of each other: of each the best way stays.

    :param grids: (J, n) values of joints, evenly spaced; NaN ends a row. :param ends: (J, 2) their limits.
    """
    n_w, n_c, n_j = len(out), len(chain.parent), out.shape[1]
    now = Ways(np.zeros((n_w, n_c, 3, 3)), np.zeros((n_w, n_c, 3)), np.zeros((n_w, n_j)), np.zeros(n_w))
    then = Ways(np.zeros((n_w, n_c, 3, 3)), np.zeros((n_w, n_c, 3)), np.zeros((n_w, n_j)), np.zeros(n_w))
    best = Best(np.empty(n_w), np.empty(n_w, np.int64), np.empty(n_w))
    bench = Bench(np.empty((2, grids.shape[1])), np.empty((3, 3)), np.empty((3, 3, 3)), room_of(s))
    n = 1
    for c in branches.line:
        j, mine = chain.joint_of[c], branches.patches[branches.starts[c] : branches.starts[c + 1]]
        if branches.begins[c]:
            n = 1
        if j >= 0:
            found = 0
            for w in range(n):
                found = follow(
                    s, chain, c, mine, now, w, grids[j], ends[j], view, limits, hidden_cost, bench, found, best
                )  # fmt: skip
            go_on(chain, c, now, found, best, then, bench)
            now, then, n = then, now, found
            continue
        for w in range(n):
            if chain.parent[c] < 0:
                copy_frame(R, t, now.R[w, c], now.t[w, c])
            else:
                said = said_at(s, chain, c, mine, now.R[w], now.t[w], 0.0, view, limits, hidden_cost, bench)
                now.votes[w] += said[1]
    out[:n] = now.q[:n]
    return n
