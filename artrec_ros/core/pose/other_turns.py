"""The mirrored turns of told poses that the image bears out nearly as well.

A flat marker that is slanted looks almost as it does slanted the other way: only perspective tells, and of a small or
distant marker too little. Other components in other planes tell, and so do bodies; where they do not, whoever reads
one pose with a small deviation is misled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..geometry.transforms import Array, rotvec_from_rotation
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .surface_model import Poses

_WORTH_REST = 0.9  # share of what makes a rival without which a first fit will not become one by the last
_ANY_DEPTH = 0.0, np.inf


@dataclass(frozen=True, eq=False)
class Mirrored:
    """A rival of a told pose. :param poses: one. :param probability: that it is the true one."""

    poses: Poses
    probability: float

    def beside(self, told: Poses) -> Array:
        """(6, 6) what it adds to the covariance of a told pose, about that pose, along the camera's axes."""
        turn = rotvec_from_rotation(self.poses.R[0] @ told.R[0].T)
        off = np.concatenate([self.poses.t[0] - told.t[0], turn])
        return np.asarray(self.probability * np.outer(off, off), np.float64)


def mirrored_of(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Sequence[Mirrored | None]:
    """Of each of H poses at rest the likeliest mirrored turn; None where there is none that is a rival."""
    out: list[Mirrored | None] = [None] * len(poses)
    flips, of = finder.required.flips_of_each(poses)
    if not len(flips):
        return out
    told, config = finder.votes(frame, poses, occlusion=True), finder.config
    first = finder.refit.of(frame, flips, _ANY_DEPTH)[len(flips) :]
    near = np.flatnonzero(first.votes > _WORTH_REST * config.verdict.mirrored_votes * told[of])
    if not len(near):
        return out
    of, fitted = of[near], first.poses[near]
    fitted = finder.settled(frame, fitted, finder.supported(finder.judge(frame, fitted, occlusion=True)))
    share = finder.votes(frame, fitted, occlusion=True) / np.maximum(told[of], 1e-9)
    cosine = (np.einsum("hij,hij->h", fitted.R, poses.R[of]) - 1) / 2
    rival = (share > config.verdict.mirrored_votes) & (cosine < np.cos(config.search.niche_rad))
    if (floor := frame.scene.floor) is not None:
        rival &= floor.standing(fitted.R, fitted.t, 1.0)
    for row in np.flatnonzero(rival)[np.argsort(share[rival], kind="stable")].tolist():
        out[of[row]] = Mirrored(fitted[[row]], config.verdict.mirrored_share)
    return out
