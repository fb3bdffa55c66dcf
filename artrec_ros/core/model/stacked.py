"""Markers of one component that lie on each other: views of one thing, of which one at a time is there."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from .solids import closed_in
from .surface import Patch, covers

_ON_EACH_OTHER = 0.5  # of the smaller one: with less they may be one outline that is made of two
_SAME_WAY = 0.94  # cosine: sides of a foot that stand less than 20 degrees apart are one


def stacks_of(patches: Sequence[Patch]) -> NDArray[np.int64]:
    """(P,) the first marker of the stack that each patch is in, directly or by others; -1: in none."""
    out, closed = np.full(len(patches), -1), closed_in(patches)
    flat = [n for n, p in enumerate(patches) if p.marker is not None and not p.bulge and p.component not in closed]
    for a, b in combinations(flat, 2):
        one, other = patches[a], patches[b]
        if one.component == other.component and _on_each_other(one, other):
            first = [n if out[n] < 0 else int(out[n]) for n in (a, b)]
            out[[*first, a, b]] = min(first)
            out[out == max(first)] = min(first)
    return out


def _on_each_other(a: Patch, b: Patch) -> bool:
    """Whether two markers face one way and the smaller one lies on the other."""
    small, large = sorted((a, b), key=lambda p: p.area)
    reach = sum(np.linalg.norm(p.contour - p.drawn[0], axis=1).max() for p in (a, b))
    if a.normal @ b.normal <= _SAME_WAY or np.linalg.norm(a.drawn[0] - b.drawn[0]) > reach:
        return False
    return bool(covers(large, small.finer).mean() > _ON_EACH_OTHER)
