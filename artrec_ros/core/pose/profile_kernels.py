"""Votes of one hypothesis along each of its joints."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base.jit import jit
from ..geometry.pixel_kernels import LabelView
from ..model.chain_kernels import Chain
from .climb_kernels import Body, Value, body_of, copy_scores, whole_votes
from .surface_kernels import Surface, SurfaceLimits, room_of


@jit
def profile(
    s: Surface, chain: Chain, view: LabelView, limits: SurfaceLimits, value: Value, own: Any, plain: float, grids: Any,
    R: Any, t: Any, q: Any, out: Any,
) -> None:  # fmt: skip
    """Fill out (J, n) with the votes of one hypothesis R (3, 3), t (3,), q (J,) with each joint in turn at each of its
    values in `grids` (J, n). -inf where these are NaN, and for joints whose own components (J,) lie on their labels.

    :param plain: mean vote of a marker's pixel from which on all of it is explained.
    """
    patches, room, body, at = np.arange(len(s.area)), room_of(s), body_of(s, value, len(q)), q.copy()
    whole_votes(s, patches, chain, R, t, q, body.everything, view, limits, value, body, room)
    copy_scores(body.tried, body.scores)
    out[:] = -np.inf
    for j in range(len(q)):
        if mean_vote(s, body, own[j]) >= plain:
            continue
        for i in range(grids.shape[1]):
            if not math.isnan(grids[j, i]):
                at[j] = grids[j, i]
                out[j, i] = whole_votes(
                    s, patches, chain, R, t, at, chain.moves[j], view, limits, value, body, room
                )  # fmt: skip
        at[j] = q[j]


@jit
def mean_vote(s: Surface, body: Body, component: int) -> float:
    """Of the pixels of a component's markers in view; 0 where none is."""
    votes, area_px = 0.0, 0.0
    for p in range(len(s.component)):
        if s.component[p] == component and s.marker_of[p] >= 0:
            votes, area_px = votes + body.scores.votes[p], area_px + body.scores.area_px[p]
    return votes / max(area_px, 1.0)
