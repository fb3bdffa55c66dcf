"""How clearly a packing is the best: what would be lost without each of its groups."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..base.deadline import Deadline
from ..geometry.transforms import Array
from .packing import connected_parts, pack


def runner_up_margins(
    weight: Array,
    conflict: NDArray[np.bool_],
    chosen: Sequence[int],
    same: Sequence[Hashable],
    node_limit: int,
    deadline: Deadline,
) -> list[float | None]:
    """Per chosen group, by how much the best packing without it is lighter, as a share of the group's own weight.

    1: nothing else could explain any of it; 0: another choice is as good; None: limit or deadline left it unproven.

    :param weight, conflict: as for `packing.pack`; chosen: the heaviest packing.
    :param same: (G,) groups with equal values are one and the same choice.
    """
    part_of = {g: part for part in connected_parts(conflict) for g in part}
    picked = set(chosen)
    margins: list[float | None] = []
    for g in chosen:
        if deadline.expired:
            margins.append(None)
            continue
        others = [n for n in part_of[g] if same[n] != same[g]]
        if not others:
            margins.append(1.0)
            continue
        best, proven, _ = pack(weight[others], conflict[np.ix_(others, others)], node_limit, deadline)
        held = sum(float(weight[n]) for n in part_of[g] if n in picked)
        left = sum(float(weight[others[n]]) for n in best)
        margins.append(min(max((held - left) / float(weight[g]), 0.0), 1.0) if proven else None)
    return margins
