"""Weighted set packing: the best choice of groups that may stand together (paper, step 8, for all at once)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.deadline import Deadline
from ..geometry.transforms import Array
from . import packing_kernels as compiled

_NODES_BETWEEN_LOOKS, _PAIRS_BETWEEN_LOOKS = 64, 2**24  # at the clock; a node's bound goes through pairs of groups


class Packing(NamedTuple):
    """A choice of groups.

    :param chosen: indices, ascending. :param exact: it is proven to be the best.
    :param out_of_nodes: the node limit ended the search for it somewhere, not the deadline.
    """

    chosen: list[int]
    exact: bool = True
    out_of_nodes: bool = False


def pack(weight: Array, conflict: NDArray[np.bool_], node_limit: int, deadline: Deadline) -> Packing:
    """The heaviest choice of groups of which no two conflict.

    Branch and bound, exact for each set of groups that hang together by conflicts. Where the node limit or the
    deadline ends it, the best choice so far stands, which is never lighter than the greedy one.

    :param weight: (G,) positive; conflict: (G, G) symmetric.
    """
    if np.count_nonzero(conflict) == np.trace(conflict):  # none is in another's way
        return Packing(list(range(len(weight))))
    chosen: list[int] = []
    exact, out_of_nodes = True, False
    kept = _heaviest_of_like(weight, conflict)
    for part in connected_parts(conflict[np.ix_(kept, kept)]):
        if len(part) == 1:
            chosen.append(int(kept[part[0]]))
            continue
        order = kept[sorted(part, key=lambda n: (-weight[kept[n]], n))].tolist()
        part_of_it = _pack_part(order, weight, conflict, node_limit, deadline)
        chosen += part_of_it.chosen
        exact &= part_of_it.exact
        out_of_nodes |= part_of_it.out_of_nodes
    return Packing(sorted(chosen), exact, out_of_nodes)


def connected_parts(conflict: NDArray[np.bool_]) -> list[list[int]]:
    """Connected parts of a graph given as (G, G) adjacency."""
    parts: dict[int, list[int]] = {}
    for node, part in enumerate(compiled.part_numbers(conflict).tolist()):
        parts.setdefault(part, []).append(node)
    return list(parts.values())


def _heaviest_of_like(weight: Array, conflict: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Groups, ascending, without those that conflict with just what a heavier one conflicts with."""
    heaviest: dict[bytes, int] = {}
    with_itself = conflict.copy()
    np.fill_diagonal(with_itself, True)
    rows, n = with_itself.tobytes(), len(conflict)
    for g in np.argsort(-weight, kind="stable").tolist():
        heaviest.setdefault(rows[g * n : (g + 1) * n], g)
    return np.array(sorted(heaviest.values()), np.int64)


def _pack_part(
    order: list[int], weight: Array, conflict: NDArray[np.bool_], node_limit: int, deadline: Deadline
) -> Packing:
    mine, among = weight[order], conflict[np.ix_(order, order)]
    state = compiled.start(mine, among)
    left, over = node_limit, False
    nodes = min(max(_PAIRS_BETWEEN_LOOKS // len(order) ** 2, 1), _NODES_BETWEEN_LOOKS)
    while left > 0 and not over and not deadline.expired:
        over = compiled.search(mine, among, state, min(left, nodes))
        left -= nodes
    *_, best, size, _ = state
    return Packing([order[n] for n in best[: size[0]].tolist()], over, left <= 0 and not over)
