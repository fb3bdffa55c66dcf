"""Fits to the contours of all markers that labels support, with the votes before and after, a hypothesis at a time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit
from ..geometry.pixel_kernels import LabelView
from ..model.chain_kernels import Chain
from .climb_kernels import Value, body_of, whole_votes
from .fit_kernels import Terms, fit_one, fit_room
from .placed_kernels import Joints
from .surface_kernels import Surface, SurfaceLimits, room_of
from .vote_kernels import is_supported


class Support(NamedTuple):
    """What a marker must show for its contour to have a say: see `WholeObjectFinder.supported`."""

    min_px: float
    least_agree: float


@jit
def support_of(
    s: Surface, chain: Chain, view: LabelView, limits: SurfaceLimits, value: Value, support: Support, markers: Any,
    R: Any, t: Any, q: Any, use: Any, votes: Any,
) -> None:  # fmt: skip
    """Fill use (H, M) with which of `markers` (M,) labels support under hypotheses R (H, 3, 3), t (H, 3), q (H, J), and
    votes (H,) with those for the whole objects."""
    patches, room, body = np.arange(len(s.area)), room_of(s), body_of(s, value, q.shape[1])
    once = body.once
    for h in range(len(R)):
        votes[h] = whole_votes(
            s, patches, chain, R[h], t[h], q[h], body.everything, view, limits, value, body, room
        )  # fmt: skip
        for k in range(len(markers)):
            p = markers[k]
            use[h, k] = is_supported(once[0, p], once[1, p], once[2, p], support.min_px, support.least_agree)


@jit
def refit_each(
    terms: Terms, chain: Chain, joints: Joints, limits: SurfaceLimits, value: Value, near_m: float, far_m: float,
    R: Any, t: Any, q: Any, votes: Any,
) -> None:  # fmt: skip
    """Fit hypotheses R (H, 3, 3), t (H, 3), q (H, J) in place, and fill votes (H,) with those for the fitted ones; of
    one that uses no marker all stays.

    :param near_m, far_m: depths at which a fitted one is left: it is moved along its line of sight to the next.
    """
    s, view, use = terms.contours.surface, terms.contours.seen, terms.contours.use
    patches, room, body = np.arange(len(s.area)), room_of(s), body_of(s, value, q.shape[1])
    fitting, limited = fit_room(terms, chain, q.shape[1]), near_m > 0.0 or far_m < np.inf
    for h in range(len(R)):
        if not use[h].any():
            continue
        fit_one(terms, h, chain, joints, R[h], t[h], q[h], fitting)
        nearest = min(max(t[h, 2], near_m), far_m) / t[h, 2] if limited else 1.0
        for i in range(3):
            t[h, i] *= nearest
        votes[h] = whole_votes(
            s, patches, chain, R[h], t[h], q[h], body.everything, view, limits, value, body, room
        )  # fmt: skip
