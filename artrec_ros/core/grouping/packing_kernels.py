"""Branch and bound of `packing`, some nodes at a time so that its caller can look at the clock."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.jit import jit


@jit
def _bound(free: Any, weight: Any, conflict: Any, cliques: Any, sizes: Any) -> float:
    """The heaviest of each clique, gathered greedily; `cliques` and `sizes` are scratch."""
    count, total = 0, 0.0
    for g in free:
        home = -1
        for c in range(count):
            fits = True
            for i in range(sizes[c]):
                if not conflict[g, cliques[c, i]]:
                    fits = False
                    break
            if fits:
                home = c
                break
        if home < 0:
            home = count
            sizes[home] = 0
            count += 1
            total += weight[g]
        cliques[home, sizes[home]] = g
        sizes[home] += 1
    return total


@jit
def part_numbers(adjacency: Any) -> Any:
    """(n,) number of the connected part that each node of a graph belongs to, counted as they come up."""
    n = len(adjacency)
    part, front, parts = np.full(n, -1, np.int64), np.empty(n, np.int64), 0
    for first in range(n):
        if part[first] >= 0:
            continue
        front[0], waiting, part[first] = first, 1, parts
        while waiting:
            waiting -= 1
            row = adjacency[front[waiting]]
            for other in range(n):
                if row[other] and part[other] < 0:
                    part[other] = parts
                    front[waiting] = other
                    waiting += 1
        parts += 1
    return part


@jit
def start(weight: Any, conflict: Any) -> Any:
    """State of a search over groups by descending weight: stacks of free and chosen groups, their lengths and
    values, [entries, nodes], the best choice so far (greedy), [its length], [its weight]."""
    n = len(weight)
    free, chosen = np.empty((n + 2, n), np.int32), np.empty((n + 2, n), np.int32)
    lengths, values = np.zeros((n + 2, 2), np.int64), np.zeros(n + 2)
    for g in range(n):
        free[0, g] = g
    lengths[0, 0] = n
    best, size, heavy = np.empty(n, np.int32), 0, 0.0
    for g in range(n):
        alone = True
        for i in range(size):
            if conflict[g, best[i]]:
                alone = False
                break
        if alone:
            best[size] = g
            size += 1
            heavy += weight[g]
    return free, chosen, lengths, values, np.array([1, 0]), best, np.array([size]), np.array([heavy])


@jit
def search(weight: Any, conflict: Any, state: Any, most_nodes: int) -> bool:
    """Go on for at most so many nodes; whether the search is over."""
    free, chosen, lengths, values, counts, best, size, heavy = state
    n = len(weight)
    cliques, sizes = np.empty((n, n), np.int32), np.empty(n, np.int64)
    mine, taken = np.empty(n, np.int32), np.empty(n, np.int32)
    for _ in range(most_nodes):
        if counts[0] == 0:
            return True
        counts[0] -= 1
        counts[1] += 1
        top = counts[0]
        frees, picked, value = lengths[top, 0], lengths[top, 1], values[top]
        mine[:frees], taken[:picked] = free[top, :frees], chosen[top, :picked]
        if value > heavy[0] + 1e-12:
            best[:picked] = taken[:picked]
            size[0], heavy[0] = picked, value
        if frees == 0 or value + _bound(mine[:frees], weight, conflict, cliques, sizes) <= heavy[0] + 1e-12:
            continue
        first = mine[0]
        free[top, : frees - 1], chosen[top, :picked] = mine[1:frees], taken[:picked]
        lengths[top, 0], lengths[top, 1], values[top] = frees - 1, picked, value
        left = 0
        for i in range(1, frees):
            if not conflict[first, mine[i]]:
                free[top + 1, left] = mine[i]
                left += 1
        chosen[top + 1, :picked] = taken[:picked]
        chosen[top + 1, picked] = first
        lengths[top + 1, 0], lengths[top + 1, 1], values[top + 1] = left, picked + 1, value + weight[first]
        counts[0] += 2
    return counts[0] == 0
