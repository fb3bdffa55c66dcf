"""`RegionFit` of a model with markers that lie on each other: of each hypothesis those are regions that are there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .poses import Poses
from .region_fit import RegionFit
from .surface_model import SpatialModel

_KEPT = 64  # fits, a few hundredths of a MiB and a millisecond each


class StackedRegions:
    """Fits one model's poses."""

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._surface, self._config, self._fits = surface, config, dict[bytes, RegionFit]()

    def fitted(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]) -> Poses:
        """As `RegionFit.fitted`."""
        out = Poses(poses.R.copy(), poses.t.copy(), poses.q.copy())
        for fit, rows in self._alike(frame, poses):
            at = fit.fitted(frame, poses[rows], used[rows])
            out.R[rows], out.t[rows], out.q[rows] = at.R, at.t, at.q
        return out

    def evenness(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H,) as `RegionFit.evenness`."""
        out = np.zeros(len(poses))
        for fit, rows in self._alike(frame, poses):
            out[rows] = fit.evenness(frame, poses[rows])
        return out

    def _alike(self, frame: ImageFrame, poses: Poses) -> Iterator[tuple[RegionFit, NDArray[np.int64]]]:
        """Hypotheses of which the same markers are there, and the fit of these; but those of which none is."""
        there = self._surface.there(frame, poses)
        each, of = np.unique(there, axis=0, return_inverse=True)
        for n, one in enumerate(each):
            if not one.any():
                continue
            if (key := one.tobytes()) not in self._fits:
                if len(self._fits) == _KEPT:
                    self._fits.pop(next(iter(self._fits)))
                self._fits[key] = RegionFit(self._surface, self._config, one)
            yield self._fits[key], np.flatnonzero(of.reshape(-1) == n)
