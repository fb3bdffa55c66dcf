"""Weighted set packing: the best choice of groups that may stand together (paper, step 8, for all at once)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .deadline import Deadline
from .transforms import Array


def pack(weight: Array, conflict: NDArray[np.bool_], node_limit: int, deadline: Deadline) -> tuple[list[int], bool]:
    """The heaviest choice of groups of which no two conflict.

    Branch and bound, exact for each set of groups that hang together by conflicts. Where the node limit or the
    deadline ends it, the best choice so far stands, which is never lighter than the greedy one.

    :param weight: (G,) positive; conflict: (G, G) symmetric.
    :return: indices, ascending, and whether the choice is proven to be the best.
    """
    chosen: list[int] = []
    exact = True
    for part in connected_parts(conflict):
        best, proven = _pack_part(sorted(part, key=lambda g: -weight[g]), weight, conflict, node_limit, deadline)
        chosen += best
        exact &= proven
    return sorted(chosen), exact


def connected_parts(conflict: NDArray[np.bool_]) -> list[list[int]]:
    """Connected parts of a graph given as (G, G) adjacency."""
    left = set(range(len(conflict)))
    parts = []
    while left:
        front = [left.pop()]
        part = list(front)
        while front:
            near = [int(n) for n in np.flatnonzero(conflict[front.pop()]) if int(n) in left]
            left.difference_update(near)
            front += near
            part += near
        parts.append(part)
    return parts


def _greedy(order: list[int], conflict: NDArray[np.bool_]) -> list[int]:
    chosen: list[int] = []
    for g in order:
        if not conflict[g, chosen].any():
            chosen.append(g)
    return chosen


def _pack_part(
    order: list[int], weight: Array, conflict: NDArray[np.bool_], node_limit: int, deadline: Deadline
) -> tuple[list[int], bool]:
    best = _greedy(order, conflict)
    best_weight = float(weight[best].sum())
    nodes = 0
    # depth first; each entry: groups still free, chosen so far, its weight
    stack: list[tuple[list[int], list[int], float]] = [(order, [], 0.0)]
    while stack:
        free, chosen, value = stack.pop()
        nodes += 1
        if nodes > node_limit or (nodes % 64 == 0 and deadline.expired):
            return best, False
        if value > best_weight + 1e-12:
            best, best_weight = chosen, value
        if not free or value + _bound(free, weight, conflict) <= best_weight + 1e-12:
            continue
        first = free[0]
        stack.append((free[1:], chosen, value))
        stack.append(([g for g in free[1:] if not conflict[first, g]], [*chosen, first], value + weight[first]))
    return best, True


def _bound(free: list[int], weight: Array, conflict: NDArray[np.bool_]) -> float:
    """At most one group of each clique: cliques are gathered greedily, the heaviest of each counts."""
    cliques: list[list[int]] = []
    total = 0.0
    for g in free:  # by weight, descending
        home = next((c for c in cliques if conflict[g, c].all()), None)
        if home is None:
            cliques.append([g])
            total += float(weight[g])
        else:
            home.append(g)
    return total
