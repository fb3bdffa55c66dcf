"""Fits of hypotheses to the contours of all markers that labels support, with the votes before and after."""

from __future__ import annotations

import numpy as np

from ..base.config import RecognizerConfig
from ..image.image_frame import ImageFrame
from .climb_kernels import Value
from .pose_fit import AT_ONCE, Fit, of_some
from .poses import Poses
from .ranked import Ranked
from .refit_kernels import Support, refit_each, support_of
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
        n, s, kin = len(poses), self._surface, self._surface.kinematics
        R, t, q = (np.concatenate([values, values]) for values in (poses.R, poses.t, poses.q))
        votes, use = np.empty(2 * n), np.empty((n, len(s.markers)), bool)
        before, after, seen = votes[:n], votes[n:], (s.compiled, kin.chain, frame.view, s.limits)
        support_of(*seen, self._value, self._support, s.markers, R[:n], t[:n], q[:n], use, before)
        after[:] = before
        terms, limits = self._fit.terms(frame, use, self._reach_px), (s.limits, self._value, *depths_m)
        for part in frame.deadline.parts(n, AT_ONCE):
            fitted = (values[n:][part] for values in (R, t, q, votes))
            refit_each(of_some(terms, part), kin.chain, self._fit.joints, *limits, *fitted)
        return Ranked(Poses(R, t, q), votes)
