"""Fits of hypotheses that end short of what they lie on.

A thin marker that reads thinner than it is, as by blur, or by edges that a segmenter lost, has a smaller one's area. A
hypothesis of that size ends farther inside of what it lies on than a fit looks for edges: nothing pulls it outwards,
and its long sides, which are most of its contour, hold it in width. Here the ends of long markers beyond which their
class goes on look as far as it does. Nor does anything pull back a fit that takes an end too far beyond: it begins
again where it had it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import FitConfig
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .contour_steps import ContourSteps
from .contour_term_kernels import ContourFit
from .edge_kernels import OWN
from .edges import edge_terms
from .pose_fit import contour_fit, far_ends
from .poses import Poses
from .surface_model import SpatialModel

_NEAR_PX = 1.0  # a step that takes no contour farther is the last: fits that follow look farther


class GoingOn:
    """Of one object's markers. :param facing: poses turn about the optical axis alone."""

    def __init__(self, surface: SpatialModel, config: FitConfig, *, facing: bool) -> None:
        self._surface, self._config, self._reach = surface, config, max(config.fine_reach_px)
        self._off = max(*config.coarse_reach_px, self._reach)
        self._steps = ContourSteps(surface, config, facing=facing)
        self._ends = far_ends(surface, config) & surface.open_contour
        self._marker = np.nonzero(self._ends)[0]  # (E,) of each end
        self._on = np.tile(surface.component[surface.markers[self._marker]], 2)
        self._of_end = ends_of(surface.outward[self._ends], self._marker)
        # (2 E, 3) these points, and others a little farther out
        self._at = np.concatenate([surface.contour[self._ends], (surface.contour + surface.outward)[self._ends]])

    @property
    def may_be(self) -> bool:
        """Whether the object has long markers."""
        return len(self._marker) > 0

    def rows(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Which are such. :param used: (H, M) the markers whose contours."""
        return self._goes_on(frame, poses, used, self._own(frame, poses, used))

    def at_ends(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(H, E) at which points of ends of markers in use their class goes on."""
        inside, outside = self._own(frame, poses, used)
        return np.asarray(inside & outside)

    def fitted_anew(
        self, frame: ImageFrame, begun: Poses, fitted: Poses, used: NDArray[np.bool_]
    ) -> tuple[NDArray[np.int64], Poses]:
        """Which of H fits are such, and which took ends from where their class ends to beyond it; and from where each
        is to be fitted otherwise. :param begun: where the fits began."""
        if not (self.may_be and used.any()):
            return np.zeros(0, np.int64), begun[:0]
        own = self._own(frame, Poses.concatenate([begun, fitted]), np.concatenate([used, used]))
        (inside, left), (beyond, _) = own.reshape(2, 2, len(begun), -1)
        ended = inside & ~beyond
        had, has = ended @ self._of_end, (ended & left) @ self._of_end
        lost = ((had > 0) & (has == 0)).any(axis=1)
        on = np.isin(np.arange(len(begun)), self._goes_on(frame, fitted, used, own[:, len(begun) :]))
        rows = np.flatnonzero(on | lost)
        return rows, Poses.concatenate([begun, fitted])[rows + len(begun) * ~lost[rows]]

    def fitted(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_], *, covered: bool = True) -> Poses:
        """A few steps of least squares; arguments as of `rows`.

        :param covered: what begins farther inside than guesses are off is partly covered, and no end is pulled there.
        """
        steps = self._steps.begun(frame, used)
        for _ in self._config.coarse_reach_px:
            fit, residual, weight, _ = self._edges(frame, poses, used, covered=covered)
            poses, moved_px = self._steps.step(steps, poses, fit, residual, weight)
            if moved_px < _NEAR_PX:
                break
        return poses

    def _goes_on(
        self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_], own: NDArray[np.bool_]
    ) -> NDArray[np.int64]:
        rows = np.flatnonzero((own[0] & own[1]).any(axis=1))
        return rows[np.asarray(self._edges(frame, poses[rows], used[rows])[3]).any(axis=(1, 2))] if len(rows) else rows

    def _own(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(2, H, E) whether there is its class inside of each end of markers in use, as far away as guesses are off,
        and outside, as far away as a fit looks."""
        if not (self.may_be and len(poses)):
            return np.zeros((2, len(poses), len(self._marker)), bool)
        frames = self._surface.kinematics.seen(poses.R, poses.t, poses.q)
        pixels = project(frame.camera, self._surface.place(frames, self._at, self._on))
        at, outward = pixels[:, : len(self._marker)], pixels[:, len(self._marker) :]
        outward -= at
        outward /= np.maximum(np.hypot(outward[..., :1], outward[..., 1:]), 1e-9)
        kinds = edge_terms(self._surface, frame.field, (self._reach,), self._config).kind
        codes = frame.field.at(np.stack([at - self._off * outward, at + self._reach * outward]))
        return np.asarray((kinds[self._marker, codes] == OWN) & used[:, self._marker])

    def _edges(
        self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_], *, covered: bool = True
    ) -> tuple[ContourFit, Array, Array, NDArray[np.bool_]]:
        """Contours against the labels' edges, residuals and weights (H, K, m), and at which points these are where the
        class ends that goes on beyond reach. What goes on for more than half of a marker's length is more than it.

        :param covered: as of `fitted`.
        """
        s, which, reach = self._surface, np.flatnonzero(used.any(axis=0)), self._reach
        fit = contour_fit(s, frame, poses, used, reach, self._config)
        residual, weight, on = fit.residual.copy(), fit.weight.copy(), np.zeros(fit.weight.shape, bool)
        h, k, i = np.nonzero(fit.shown & self._ends[which] & (fit.weight == 0))
        if not len(h):
            return fit, residual, weight, on
        kinds = edge_terms(s, frame.field, (reach,), self._config).kind[which][k]  # (n, 256)
        around = fit.point[h, k] - fit.point[h, k].mean(axis=1, keepdims=True)  # wherever the object's own place is
        half_px = np.minimum(np.linalg.norm(around, axis=2).max(axis=1), sum(frame.size))
        for way, most in (1, half_px), (-1, np.full(len(h), self._off) if covered else half_px):
            away = np.arange(reach, max(int(most.max()), reach) + 1)
            codes = frame.field.at(fit.point[h, k, i, None] + way * away[:, None] * fit.normal[h, k, i, None])
            own = np.take_along_axis(kinds, codes.astype(np.int64), axis=1) == OWN
            ends = own if way < 0 else ~own
            first = np.where(ends.any(axis=1), away[ends.argmax(axis=1)], reach)
            told = (first > reach) & (first <= most)
            at = h[told], k[told], i[told]
            residual[at], weight[at], on[at] = way * (0.5 - first[told]), 1.0, way > 0
        return fit, residual, weight, on


def ends_of(outward: Array, marker: NDArray[np.int64]) -> Array:
    """(E, N) 1 where a point is at an end: those of one marker that look about the same way. :param outward: (E, 3)."""
    same = (marker[:, None] == marker) & (outward @ outward.T > 0)
    return np.asarray(np.unique(same, axis=1), np.float64)
