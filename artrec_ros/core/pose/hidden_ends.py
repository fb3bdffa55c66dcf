"""Where an object with few markers may be if something unknown hides an end of one of them.

What cuts a marker short makes it look tilted, or farther off: the cut is taken for its end, and where few others are
seen the whole pose gives way, a tape on an arm by thirty degrees and more. Without the contour near that end the rest
of it, and the other markers, tell where the object is: from where it is told, and from its mirrored turns, it is fitted
without each end of each of its markers. What comes to rest elsewhere and explains nearly as much may be true.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .distinct import apart
from .pose_fit import ALL_SHOWN, Fit, but_for_common, contour_fit
from .poses import Poses
from .required_place import RequiredPlace
from .resting import Resting
from .surface_model import SpatialModel
from .voter import Voter


class HiddenEnds:
    """Those of one object in space."""

    def __init__(
        self, surface: SpatialModel, voter: Voter, rest: Resting, required: RequiredPlace, config: RecognizerConfig
    ) -> None:
        self._surface, self._voter, self._rest, self._required = surface, voter, rest, required
        self._verdict, self._fit = config.verdict, Fit(surface, config.fit, facing=False)
        self._edges = config.covariance.reach_px, config.fit
        self._kept = _without_each_end(surface.contour, config.verdict.end_share)
        self._reach_px = config.fit.coarse_reach_px + 2 * config.fit.fine_reach_px

    def of(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]) -> tuple[Poses, NDArray[np.int64]]:
        """Other poses at rest that explain nearly as much, and of which of H each is, as far as there is time.

        :param used: (H, M) markers whose contours tell where objects are.
        """
        few = np.flatnonzero(used.any(axis=1) & (used.sum(axis=1) <= self._verdict.end_markers))
        found, of = [poses[:0]], list[int]()
        for h in few[self._misfit_px2(frame, poses[few], used[few]) > self._verdict.end_misfit_px2].tolist():
            if frame.deadline.expired:
                break
            others = self._of_one(frame.unhurried(), poses[h : h + 1], used[h])
            found.append(others)
            of += [h] * len(others)
        return Poses.concatenate(found), np.array(of, np.int64)

    def _misfit_px2(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]) -> Array:
        """(H,) mean square of how far contours of the markers in use (H, M) lie from labels' edges, but for what all
        have in common: what is cut short fits nowhere quite."""
        if not len(poses):
            return np.zeros(0)
        fit = contour_fit(self._surface, frame, poses, used, *self._edges)
        off, total = but_for_common(fit.residual, fit.weight), np.maximum(fit.weight.sum(axis=(1, 2)), 1e-9)
        return np.asarray((fit.weight * off**2).sum(axis=(1, 2)) / total)

    def _of_one(self, frame: ImageFrame, pose: Poses, used: NDArray[np.bool_]) -> Poses:
        """Those of one pose. :param used: (M,)"""
        begun = Poses.concatenate([pose, self._required.flips(pose)])
        others = self._without_ends(frame, begun, used)
        others = others[np.flatnonzero(self._voter.votes(frame, others, occlusion=True) > self._least(frame, pose))]
        if not len(others):
            return others
        known = self._fitted(frame, begun, np.tile(used, (len(begun), 1)))  # mirrored turns are asked about elsewhere
        others = self._apart(frame, pose, known, others)
        if not len(others):
            return others
        both = Poses.concatenate([known, others])
        both = self._rest.at_rest(frame, both, self._voter.supports(frame, both))
        others = self._apart(frame, pose, both[: len(known)], both[len(known) :])
        return others[np.flatnonzero(self._hides_an_end(frame, others, used))]

    def _least(self, frame: ImageFrame, pose: Poses) -> float:
        """More votes than that what may be true has, too."""
        return float(self._verdict.end_votes * self._voter.votes(frame, pose, occlusion=True)[0])

    def _hides_an_end(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(H,) under which poses a marker in use (M,) lacks some of its class: else none has an end that is hidden, and
        how sure a pose is that all of its markers bear out its contours tell."""
        lacks_px = self._voter.lacks_px(self._voter.judge(frame, poses, occlusion=True))
        return np.asarray((lacks_px[:, used] > 0).any(axis=1))

    def _apart(self, frame: ImageFrame, pose: Poses, known: Poses, others: Poses) -> Poses:
        """Those of some poses that are near no known one, nor each other, with votes enough beside a told one's; the
        one with most first."""
        both = Poses.concatenate([pose, known, others])
        votes, n, least = self._voter.votes(frame, both, occlusion=True), 1 + len(known), self._least(frame, pose)
        votes[:n] = np.inf
        order = np.argsort(-votes, kind="stable")
        kept = order[apart(both[order], votes[order], least, *self._verdict.end_apart)]
        return both[kept[kept >= n]]

    def _without_ends(self, frame: ImageFrame, begun: Poses, used: NDArray[np.bool_]) -> Poses:
        """Fits from each of some poses without each end of each marker in use (M,)."""
        ends, markers = self._kept.shape[1], np.flatnonzero(used)
        row = np.repeat(np.arange(len(begun)), len(markers) * ends)
        marker, end = np.tile(np.repeat(markers, ends), len(begun)), np.tile(np.arange(ends), len(begun) * len(markers))
        use = np.tile(used, (len(row), 1))
        shown = self._surface.shown_contour(begun, use[: len(begun)])[row]
        shown[np.arange(len(row)), marker] &= self._kept[marker, end]
        return self._fitted(frame, begun[row], use, shown)

    def _fitted(
        self, frame: ImageFrame, poses: Poses, use: NDArray[np.bool_], shown: NDArray[np.bool_] = ALL_SHOWN
    ) -> Poses:
        return self._fit.by(self._fit.terms(frame, use, self._reach_px, shown=shown), frame, poses)


def _without_each_end(contour: Array, share: float) -> NDArray[np.bool_]:
    """(M, 4, m) which points of markers' contours (M, m, 3) are left without each end: to either side of its middle,
    along its long axis and across.

    :param share: of its length that an end takes.
    """
    out = np.empty((len(contour), 4, contour.shape[1]), bool)
    for left, points in zip(out, contour, strict=True):
        off = points - points.mean(axis=0)
        along = np.linalg.svd(off, full_matrices=False)[2][:2] @ off.T  # (2, m)
        for end, way in zip(left, (along[0], -along[0], along[1], -along[1]), strict=True):
            end[:] = way < way.max() - share * np.ptp(way)
    return out
