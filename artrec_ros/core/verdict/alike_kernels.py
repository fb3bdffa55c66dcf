"""How many times as easily chance bears out an object because its components look alike.

That a component's class lies where it should be says less if it may be another one's that looks the same: of nine equal
dots some three lie on any three of a hand's. In how many other ways what is confirmed may be laid is known, and by how
many numbers each of these had to fit by chance (A. Desolneux, L. Moisan, J.-M. Morel, "Meaningful alignments", IJCV
40(1), 2000). Where all look different there is no other way, and nothing is taken.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..base.jit import lean
from ..model.chain_kernels import Chain

_MOST = 50.0  # logarithm of how many times: nothing is left of an object then


class Alike(NamedTuple):
    """What an object's components have in common.

    The last three are of `expert.verdict.mixed_up`; of what faces the camera the first of these is 0.
    """

    numbers: Any  # (C,) how many the place of each component tells
    free: float  # and how many a pose has
    like: Any  # (C, C) bool: components that look like one another
    share: float
    power: float
    per_number: float


@lean
def freedom(chain: Chain, by: Alike, confirmed: Any) -> tuple[float, float]:
    """`Evidence.spare` and `Evidence.distinct` of a claim of which some components (C,) are confirmed: of one alone
    curves say how often it is there. As many as fix a pose may be laid in any way, then the others have their
    places."""
    told, ways, count, n_c = 0.0, 0.0, 0, len(confirmed)
    for c in range(n_c):
        if confirmed[c]:
            like = 0
            for d in range(n_c):
                like += by.like[c, d] and not (d < c and confirmed[d])
            count, told, ways = count + 1, told + by.numbers[c], ways + math.log(like)
    spare = told - by.free
    for j in range(len(chain.moves)):
        moved, still = False, False
        for c in range(n_c):
            if confirmed[c]:
                moved, still = moved or chain.moves[j, c], still or not chain.moves[j, c]
        if moved and still:
            spare -= 1.0
    return spare, -ways * min(by.free / told, 1.0) if count > 1 else 0.0


@lean
def times_mixed_up(by: Alike, spare: float, distinct: float) -> float:
    """How many times as easily chance bears out a claim with this evidence."""
    if distinct >= 0.0 or by.share <= 0.0:
        return 1.0
    others = math.log(-math.expm1(distinct)) - distinct
    return 1.0 + math.exp(min(math.log(by.share) + by.power * others - by.per_number * spare, _MOST))
