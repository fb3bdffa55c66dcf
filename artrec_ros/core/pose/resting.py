"""Where hypotheses of whole objects come to rest: on the contours of their markers, and on what colours show."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .climber import Climber
from .colour_fit import ColourFit
from .contour_term_kernels import ContourFit
from .edges import would_show
from .going_on import GoingOn
from .pose_fit import Fit, contour_fit
from .poses import PatchScores, Poses
from .region_fit import RegionFit
from .stacked_regions import StackedRegions
from .voter import Voter


class Resting:
    """Brings hypotheses of one object to rest. :param facing: they turn about the optical axis alone.

    :ivar regions: the fit to the image's colours of what faces the camera; None of other objects.
    """

    def __init__(self, voter: Voter, climber: Climber, config: RecognizerConfig, *, facing: bool) -> None:
        self._surface, self._voter, self._climber, self._config = voter.surface, voter, climber, config
        self._fit = Fit(voter.surface, config.fit, facing=facing)
        self._going_on = GoingOn(voter.surface, config.fit, facing=facing)
        regions = StackedRegions if voter.surface.stacks else RegionFit
        self._facing, self.regions = facing, regions(voter.surface, config) if facing else None
        self._to_colours = self.regions or ColourFit(voter.surface, config)

    def fitted(self, frame: ImageFrame, poses: Poses, used: np.ndarray | None = None) -> Poses:
        """Fits to the contours of the markers used (H, M), or of all that the labels support."""
        if not len(poses):
            return poses
        supported = self._voter.supports(frame, poses) if used is None else used
        return self._fitted(frame, poses, supported)

    def gone_on(self, frame: ImageFrame, poses: Poses) -> Poses:
        """Last fits of those beyond whose contours their class goes on, to where that ends."""
        if not self._going_on.may_be:
            return poses[:0]
        used = self._surface.sides.with_all(self._voter.supports(frame, poses))
        rows = self._going_on.rows(frame, poses, used)
        return self._gone_on(frame, poses[rows], used[rows])

    def settled(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Hypotheses at rest on the contours of the markers used (H, M), which are finer than the votes, but for those
        whose votes fall far, and those that would leave a marker in use: what speaks for an object is not given up.
        None leaves the scene's floor."""
        return self._settled(frame, poses, used)[0]

    def _settled(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> tuple[Poses, PatchScores]:
        """The same, and what the labels say of them."""
        fitted, h = self._fitted(frame, poses, self._surface.sides.with_all(used), last=True), len(poses)
        both = Poses.concatenate([poses, fitted])
        scores = self._voter.judge(frame, both, occlusion=True)
        rows = self._borne_out(frame, both, used, (scores[:h], scores[h:]), self._voter.supported)
        return both[rows], scores[rows]

    def _borne_out(
        self,
        frame: ImageFrame,
        both: Poses,
        used: np.ndarray,
        scores: tuple[PatchScores, PatchScores],
        speaks: Callable[[PatchScores], np.ndarray],
    ) -> NDArray[np.int64]:
        """(H,) rows of H poses, and of what H fits made of them, that the labels bear out.

        :param scores: what these say of either. :param speaks: what markers speak for an object (H, M); of those in use
            none may cease to.
        """
        before, after = map(self._voter.total, scores)
        had, has = map(speaks, scores)
        kept = (after > self._config.search.settled_votes * before) & ~(used & had & ~has).any(axis=1)
        kept &= ~self._left_floor(frame, both)
        return np.arange(len(used)) + len(used) * kept

    def at_rest(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Hypotheses at rest on the contours of the markers used (H, M), and on what the image's colours show; of what
        faces the camera not on those of what covers part of it."""
        settled, scores = self._settled(frame, poses, used)
        self._voter.keep(frame, settled, scores)
        fitted = self.on_colours(frame, settled, used)
        if not self._facing or fitted is settled:
            return fitted
        covered = (used & (self._voter.lacks_px(scores) > 0)).any(axis=1)
        return Poses.concatenate([fitted, settled])[np.arange(len(poses)) + len(poses) * covered]

    def on_colours(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> Poses:
        """Hypotheses at rest on what the image's colours show; the same where it has none. As `settled`."""
        if frame.image is None:
            return poses
        fitted = self._to_colours.fitted(frame, poses, self._surface.sides.with_all(used))
        scores = self._voter.judge(frame, poses, occlusion=True), self._voter.judge(frame, fitted, occlusion=True)
        both, columns = Poses.concatenate([poses, fitted]), self._surface.marker_columns
        # colours know better than labels where a marker ends, but not that it is elsewhere
        return both[self._borne_out(frame, both, used, scores, lambda s: s.votes[:, columns] > 0)]

    def tells_colour_edges(self, frame: ImageFrame) -> bool:
        """Whether `edges` are those of colours, which are finer than the labels'."""
        return frame.image is not None and not self._facing

    def edges(self, frame: ImageFrame, poses: Poses, used: np.ndarray) -> tuple[ContourFit, Array, Array]:
        """Contours of poses that rest on them, and residuals and weights (H, M, m) of the edges that the image shows in
        its colours, or in its labels where it has none."""
        if isinstance(self._to_colours, ColourFit) and self.tells_colour_edges(frame):
            return self._to_colours.edges(frame, poses, used)
        fit = contour_fit(self._surface, frame, poses, used, self.reach_px(frame), self._config.fit)
        return fit, fit.residual, fit.weight

    def reach_px(self, frame: ImageFrame) -> int:
        """How far from contours `edges` are looked for."""
        config = self._config
        return config.fit.colour_reach_px if self.tells_colour_edges(frame) else config.covariance.reach_px

    def lost(self, frame: ImageFrame, poses: Poses, used: np.ndarray, fit: ContourFit) -> NDArray[np.bool_]:
        """(H, M, m) points of the contours of `edges` that should lie on one and lie on none: nothing hides them, none
        of the object's other markers begins there, and labels would show it.

        :param fit: what `edges` says of them.
        """
        which = np.flatnonzero(used.any(axis=0))
        ends = self._surface.sides.ends(poses, frame.camera)[..., which, :]
        shown = would_show(frame.field, fit.point, fit.normal, self.reach_px(frame), self._config.fit.border_px)
        return fit.shown & ends & shown & ~(fit.weight > 0)

    def _left_floor(self, frame: ImageFrame, both: Poses) -> NDArray[np.bool_]:
        """(H,) which of H poses in space stood on the scene's floor, and do so no longer as the next H."""
        stood, stand = frame.scene.stand(both.R, both.t).reshape(2, -1)
        return np.asarray(stood & ~stand)

    def _fitted(self, frame: ImageFrame, poses: Poses, use: np.ndarray, *, last: bool = False) -> Poses:
        """Fits to the contours of the markers in use (H, M); what faces the camera stays within its scale's limits."""
        fitted = self._fit.of(frame, poses, use, self._config.fit.fine_reach_px, last=last)
        if last:
            again, begun = self._going_on.fitted_anew(frame, poses, fitted, use)
            if len(again):
                rows = np.arange(len(poses))
                rows[again] = len(poses) + np.arange(len(again))
                fitted = Poses.concatenate([fitted, self._gone_on(frame, begun, use[again])])[rows]
        return self._climber.within_limits(frame.camera, fitted)

    def _gone_on(self, frame: ImageFrame, poses: Poses, use: np.ndarray) -> Poses:
        """Fits of those, in space from afar: what ended so far short may be slanted and bent as guesses are."""
        if not len(poses):
            return poses
        farther, config = self._going_on.fitted(frame, poses, use), self._config.fit
        reach = config.fine_reach_px if self._facing else config.coarse_reach_px + config.fine_reach_px
        return self._climber.within_limits(frame.camera, self._fit.of(frame, farther, use, reach, last=True))
