"""What faces the camera at scales that are looked for, and that the scene's plane has where it is; and what speaks
against it for it looks larger or smaller than that.

Outlines are drawn, and labels end, a little beside where an object ends, and a fit that takes all edges at their word
makes another scale of that. Where markers that stand apart or a long one tell both, the last fit knows it
(`weight_at_edges`), and may stay within limits that others leave.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.projection import project
from ..geometry.range_limits import ROUNDING, scale_limits
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..image.label_field import LabelField
from .pose_fit import Fit
from .poses import Poses
from .required_place import RequiredPlace
from .scale_deviation import scale_deviations
from .voter import Voter


class OffScale(NamedTuple):
    """What their sizes say of H poses.

    :ivar odds: (H,) logarithm of how many times as seldom as what is at a limit an object looks so far beyond it as
        each does; 0 where it does not.
    :ivar scale: (H,) pixels per metre that its edges would give it; NaN where they are within the limits.
    :ivar limit: (H,) the nearest that it may have.
    """

    odds: Array
    scale: Array
    limit: Array

    @classmethod
    def of_none(cls, h: int) -> OffScale:
        """Of H poses of which nothing is asked."""
        return cls(np.zeros(h), np.full(h, np.nan), np.full(h, np.nan))


class AtScale:
    """Those of one object."""

    def __init__(self, voter: Voter, config: RecognizerConfig) -> None:
        self._voter, self._config = voter, config
        self._plain = voter.surface.swollen(0.0)  # deviations know nothing of markers that look larger than they are
        self._required = RequiredPlace(voter.surface.model, voter.surface)
        self._fit, self._limits = Fit(voter.surface, config.fit, facing=True), scale_limits(config, None)
        self._asked: tuple[LabelField, dict[bytes, tuple[float, ...]]] | None = None  # of one image, by poses

    def fitted(
        self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_] | None = None
    ) -> tuple[Poses, NDArray[np.int64]]:
        """Poses, those whose scales are beyond the limits fitted anew from there and no farther than these; and which.
        Behind the horizon of the scene's plane none has a scale, and they stay.

        :param used: (H, M) markers whose contours tell where each is; None: those that the labels support.
        """
        kept = self._within(frame, poses)
        beyond = np.flatnonzero((kept.t != poses.t).any(axis=1))
        if not len(beyond):
            return poses, beyond
        begun = kept[beyond]
        use = self._voter.supports(frame, begun) if used is None else used[beyond]
        again = self._within(frame, self._freely(frame, begun, use))
        rows = np.arange(len(poses))
        rows[beyond] = len(poses) + np.arange(len(beyond))
        return Poses.concatenate([poses, again])[rows], beyond

    def off_scale(self, frame: ImageFrame, poses: Poses) -> OffScale:
        """How far beyond the limits poses within them look, where fits lead that know no limit, but for a normal
        deviation: that of these. Fits to which the labels object were led astray, and say nothing. Each pose is asked
        once in an image: many are judged again and again."""
        told, rows = OffScale.of_none(len(poses)), self._near_limits(frame, poses)
        asked = self._asked
        if asked is None or asked[0] is not frame.field:
            asked = self._asked = frame.field, {}
        known, keys = asked[1], {int(n): poses[n : n + 1].key for n in rows}
        new = [n for n, key in keys.items() if key not in known]
        if new:
            found = self._off_scale(frame, poses[np.array(new)])
            known.update(zip((keys[n] for n in new), zip(*(of.tolist() for of in found), strict=True), strict=True))
        for n, key in keys.items():
            told.odds[n], told.scale[n], told.limit[n] = known[key]
        return told

    def _near_limits(self, frame: ImageFrame, poses: Poses) -> NDArray[np.int64]:
        """Which poses are within the limits, and no farther than a step or so: a fit leads no farther."""
        scale, limits = self._scales(frame, poses)
        inside = np.stack([scale - limits[:, 0], limits[:, 1] - scale]) / scale
        near = (inside > -ROUNDING).all(axis=0) & (inside.min(axis=0) < self._config.fit.most_shift)
        return np.flatnonzero(near & (np.abs(poses.R[:, 2, 2]) > 1 - ROUNDING))

    def _off_scale(self, frame: ImageFrame, poses: Poses) -> OffScale:
        """As `off_scale`, of those near the limits."""
        told, limits = OffScale.of_none(len(poses)), self._scales(frame, poses)[1]
        use = self._voter.supports(frame, poses)
        free = self._freely(frame, poses, use)
        scale = self._scales(frame, free)[0]
        limit = np.clip(scale, *limits.T)
        votes = self._voter.votes(frame, Poses.concatenate([poses, free]), occlusion=True).reshape(2, -1)
        at = np.flatnonzero((scale != limit) & (votes[1] > self._config.verdict.size_votes * votes[0]))
        sigma = scale_deviations(self._plain, frame, free[at], use[at], self._config)
        sigma = np.hypot(sigma, self._config.constraints.model_noise)  # however well edges tell, lengths are off
        off = np.abs(np.log(scale[at] / limit[at])) / sigma
        told.odds[at] = [-math.log(max(math.erfc(d / math.sqrt(2)), 1e-300)) for d in off]
        told.scale[at], told.limit[at] = scale[at], limit[at]
        return told

    def _freely(self, frame: ImageFrame, poses: Poses, use: NDArray[np.bool_]) -> Poses:
        """Last fits to edges as far off as those of first ones."""
        config = self._config.fit
        return self._fit.of(frame, poses, use, config.coarse_reach_px + config.fine_reach_px, last=True)

    def _within(self, frame: ImageFrame, poses: Poses) -> Poses:
        """Poses with their required components in the image where they are, at scales within the limits."""
        scale, limits = self._scales(frame, poses)
        kept = np.clip(scale, *limits.T)
        farther = np.where(kept > 0, scale / np.where(kept > 0, kept, 1.0) - 1, 0.0)
        farther[np.abs(farther) < ROUNDING] = 0.0
        return Poses(poses.R, poses.t + self._required.anchors(poses) * farther[:, None], poses.q)

    def _scales(self, frame: ImageFrame, poses: Poses) -> tuple[Array, Array]:
        """(H,) pixels per metre of required components, and (H, 2) the least and greatest that may be there."""
        anchors = self._required.anchors(poses)
        known = frame.scene.scale_limits(project(frame.camera, anchors))
        within = np.clip(known, self._limits.least, self._limits.greatest)
        # behind the horizon no scale is known
        limits = np.where(known[:, 1:] > 0, within, 0.0)
        return frame.camera.focal_px / anchors[:, 2], limits
