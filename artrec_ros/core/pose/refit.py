"""Fits of hypotheses to the contours of all markers that labels support, with the votes before and after."""

from __future__ import annotations

import numpy as np

from ..base.config import RecognizerConfig
from ..image.image_frame import ImageFrame
from .climb_kernels import Value, votes_of
from .pose_fit import AT_ONCE, Fit, of_some
from .poses import Poses
from .ranked import Ranked
from .refit_kernels import Support, refit_each
from .surface_model import SpatialModel


class Refit:
    """Those of one model. :param value: how votes add up. :param facing: poses turn about the optical axis alone."""

    def __init__(self, surface: SpatialModel, value: Value, config: RecognizerConfig, *, facing: bool) -> None:
        self._surface, self._value = surface, value
        self._fit, self._reach_px = Fit(surface, config.fit, facing=facing), config.fit.fine_reach_px
        self._support = Support(float(config.min_blob_px), float(config.votes.supported_agree))

    def of(self, frame: ImageFrame, poses: Poses, depths_m: tuple[float, float]) -> Ranked:
        """H hypotheses, and then their fits; those that use no marker, or are left at the deadline, stay as they are.

        :param depths_m: between which those that are fitted are left.
        """
        n, s, chain = len(poses), self._surface, self._surface.kinematics.chain
        R, t, q = (np.concatenate([values, values]) for values in (poses.R, poses.t, poses.q))
        both, known = (R, t, q, np.empty(2 * n)), 0
        terms = self._fit.terms(frame, np.empty((n, len(s.markers)), bool), self._reach_px)
        limits = s.limits, self._value, self._support, *depths_m
        for part in frame.deadline.parts(n, AT_ONCE):
            begun, fitted = ([values[rows][part] for values in both] for rows in (slice(n), slice(n, None)))
            refit_each(of_some(terms, part), chain, self._fit.joints, *limits, *begun, *fitted)
            known = part.stop
        if known < n:  # late: the others stay
            *begun, votes = (values[known:n] for values in both)
            votes_of(s.compiled, chain, frame.view, s.limits, self._value, *begun, votes)
            both[-1][n + known :] = votes
        return Ranked(Poses(R, t, q), both[-1])
