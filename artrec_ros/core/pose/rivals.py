"""Poses that may be the true ones in place of some that are told."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .poses import Poses

WORTH_REST = 0.9  # share of what makes a rival without which a first fit will not become one by the last
WORTH_FIT = 0.5  # the same before that fit
ANY_DEPTH = 0.0, np.inf


class Rivals(NamedTuple):
    """Other poses at rest, whose each one is, and the log odds that it is the true one."""

    poses: Poses
    of: NDArray[np.int64]
    log_odds: Array


def rivals_at_rest(
    finder: WholeObjectFinder,
    frame: ImageFrame,
    poses: Poses,
    told: Array,
    flips: Poses,
    of: NDArray[np.int64],
    *,
    elsewhere: bool = False,
) -> tuple[Poses, NDArray[np.int64]]:
    """Those of some other turns of poses, at rest, that may be the true ones.

    :param told: (H,) votes of the poses. :param of: whose each other turn is. :param elsewhere: the required component
        need not be where it is.
    """
    if not len(flips):
        return flips, of
    first = finder.refit.of(frame, flips, ANY_DEPTH)[len(flips) :]
    least = finder.config.verdict.mirrored_votes * told
    near = np.flatnonzero(first.votes > WORTH_REST * least[of])
    fitted, of = first.poses[near], of[near]
    if not len(near):
        return fitted, of
    fitted = finder.rest.settled(frame, fitted, finder.voter.supports(frame, fitted))
    cosine = (np.einsum("hij,hij->h", fitted.R, poses.R[of]) - 1) / 2
    apart = cosine < np.cos(finder.config.search.niche_rad)
    apart &= elsewhere | finder.required.is_at(fitted, poses[of])
    apart &= finder.voter.votes(frame, fitted, occlusion=True) > least[of]
    apart &= frame.scene.stand(fitted.R, fitted.t)
    kept = np.flatnonzero(apart)
    return fitted[kept], of[kept]
