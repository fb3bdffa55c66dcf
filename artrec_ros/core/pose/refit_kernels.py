"""Fits to the contours of all markers that labels support, with the votes before and after, a hypothesis at a time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit
from ..model.chain_kernels import Chain
from .climb_kernels import Value, body_of, whole_votes
from .fit_kernels import Terms, fit_one, fit_room
from .placed_kernels import Joints
from .surface_kernels import SurfaceLimits, room_of
from .vote_kernels import is_supported


class Support(NamedTuple):
    """What a marker must show for its contour to have a say: see `WholeObjectFinder.supported`."""

    min_px: float
    least_agree: float


@jit
def refit_each(
    terms: Terms, chain: Chain, joints: Joints, limits: SurfaceLimits, value: Value, support: Support, near_m: float,
    far_m: float, R: Any, t: Any, q: Any, votes: Any, R_fitted: Any, t_fitted: Any, q_fitted: Any, votes_fitted: Any,
) -> None:  # fmt: skip
    """Fill votes (H,) with those for hypotheses R (H, 3, 3), t (H, 3), q (H, J), and which markers their labels support
    in `terms`; then fit the same, R_fitted, t_fitted and q_fitted, in place, and fill votes_fitted (H,) with theirs. Of
    one that uses no marker all stays.

    :param near_m, far_m: depths at which a fitted one is left: it is moved along its line of sight to the next.
    """
    s, view, markers, use = terms.contours.surface, terms.contours.seen, terms.contours.markers, terms.contours.use
    patches, room, body = np.arange(len(s.area)), room_of(s), body_of(s, value, q.shape[1])
    fitting, limited, once = fit_room(terms, chain, q.shape[1]), near_m > 0.0 or far_m < np.inf, body.once
    for h in range(len(R)):
        votes[h] = votes_fitted[h] = whole_votes(
            s, patches, chain, R[h], t[h], q[h], body.everything, view, limits, value, body, room
        )  # fmt: skip
        used = False
        for k in range(len(markers)):
            p = markers[k]
            use[h, k] = is_supported(once[0, p], once[1, p], once[2, p], support.min_px, support.least_agree)
            used |= use[h, k]
        if not used:
            continue
        R_h, t_h, q_h = R_fitted[h], t_fitted[h], q_fitted[h]
        fit_one(terms, h, chain, joints, R_h, t_h, q_h, fitting)
        nearest = min(max(t_h[2], near_m), far_m) / t_h[2] if limited else 1.0
        for i in range(3):
            t_h[i] *= nearest
        votes_fitted[h] = whole_votes(
            s, patches, chain, R_h, t_h, q_h, body.everything, view, limits, value, body, room
        )  # fmt: skip
