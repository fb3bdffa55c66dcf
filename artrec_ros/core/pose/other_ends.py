"""Where long markers that face the camera may end otherwise: their scale is told by their ends, and what is nearer to
the truth at each of these no vote tells.

Something of a marker's class that touches its end makes it longer, something unknown over it, or a class that ate it,
shorter. Without what is seen about that end, its width and its other end tell where it is. Which reading is the true
one say how many ends go on beyond it or fall short, by how much of their length the sides have no edge, and votes; how
wide a marker looks does not by itself: labels that are thinner all around are as common as strays. Nothing is amiss
with an end beneath what may lie before it, as another class; that such a thing begins just where a marker ends would be
a chance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.codes import EMPTY, OUTSIDE, UNKNOWN
from ..image.image_frame import ImageFrame
from .climber import Climber
from .edges import would_show
from .going_on import GoingOn, ends_of
from .pose_fit import Fit, contour_fit, far_ends
from .poses import Poses
from .surface_model import SpatialModel
from .voter import Voter

# an end's class ends there, goes on beyond it, ends before, or where what may lie before the end begins
AT_EDGE, GOES_ON, BEYOND, BENEATH = range(4)


class Seen(NamedTuple):
    """Of H poses. :ivar state: (H, E) of ends.
    :ivar evidence: (H, 4) what speaks for each, as `VerdictConfig.far_end_odds` weighs it: less the ends beyond which
        their class goes on, or may beneath what begins there, those that lie beyond it, and the share of the sides
        without an edge, but for what is outermost beside the latter and beneath what covers an end: what covers an end
        covers that, too; logarithm of votes.
    """

    state: NDArray[np.int64]
    evidence: Array


class OtherEnds:
    """Of one object's markers."""

    def __init__(self, surface: SpatialModel, voter: Voter, climber: Climber, config: RecognizerConfig) -> None:
        self._surface, self._voter, self._climber, self._config = surface, voter, climber, config
        self._fit, self._going_on = Fit(surface, config.fit, facing=True), GoingOn(surface, config.fit, facing=True)
        self._far = far_ends(surface, config.fit) & surface.open_contour
        of_end = ends_of(surface.outward[self._far], np.nonzero(self._far)[0])
        self._end = np.zeros((of_end.shape[1], *self._far.shape), bool)  # (N, M, m) points of each end
        self._end[:, self._far] = of_end.T > 0
        self._marker = self._end.any(axis=2).argmax(axis=1)  # (N,)
        off = surface.contour - surface.centre[surface.markers][:, None]
        outward = [surface.outward[end].mean(axis=0) for end in self._end]
        self._along = np.array([  # (N, M, m) how far out points are of the marker's half that has the end, else -inf
            np.where((np.arange(len(off)) == k)[:, None] & (off @ way > 0), off @ way, -np.inf)
            for k, way in zip(self._marker, outward, strict=True)
        ]).reshape(self._end.shape)  # fmt: skip

    @property
    def may_be(self) -> bool:
        """Whether the object has long markers."""
        return len(self._end) > 0

    def of(self, frame: ImageFrame, pose: Poses, used: NDArray[np.bool_]) -> tuple[Poses, Array]:
        """Other poses of one at rest, and the log odds that each is the true one, not the told one. Each has some end
        otherwise than those before: what ends at the same edges is the same, better or worse fitted; beneath what
        covers it an end is at none.

        :param used: (M,) markers that the labels support.
        """
        ends = np.flatnonzero(used[self._marker])
        if not len(ends):
            return pose[:0], np.zeros(0)
        both = Poses.concatenate([pose, self._in_limits(frame, self._ended_otherwise(frame, pose, used, ends))])
        seen = self.seen(frame, both, used, ends)
        worth = seen.evidence @ np.array(self._config.verdict.far_end_odds)
        at, kept = self._at(frame, both, ends), [0]
        apart_px, share = self._config.verdict.far_end_apart
        apart_px = max(apart_px, share * float(np.linalg.norm(at[0][:, None] - at[0], axis=2).max()))
        for n in (1 + np.argsort(-worth[1:], kind="stable")).tolist():
            far = np.linalg.norm(at[kept] - at[n], axis=2).max(axis=1) > apart_px
            if (far & ((seen.state[kept] != seen.state[n]) | (seen.state[n] == BENEATH)).any(axis=1)).all():
                kept.append(n)
        log_odds = (worth - worth[0])[kept[1:]]
        likelier = log_odds > self._config.verdict.least_turn_odds  # below, both are as likely, as mirrored turns are
        return both[kept[1:]], np.where(likelier, log_odds, np.minimum(log_odds, 0.0))

    def seen(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_], ends: NDArray[np.int64]) -> Seen:
        """What is seen of H poses. :param ends: (E,) numbers of those that may be elsewhere."""
        config, which, use = self._config, np.flatnonzero(used), np.tile(used, (len(poses), 1))
        reach, border = config.covariance.reach_px, config.fit.border_px
        fit = contour_fit(self._surface, frame, poses, use, reach, config.fit)
        edge, sides, of_ends = fit.weight > 0, ~self._far[which], self._end[ends][:, which]
        bare, beyond = fit.shown & ~edge, (reach + border) * fit.normal
        shows = would_show(frame.field, fit.point, fit.normal, reach, border)
        own = self._going_on.at_ends(frame, poses, use)
        goes_on = np.stack([own[:, end[self._far]].mean(axis=1) > 0.5 for end in self._end[ends]], axis=1)
        open_ = np.stack([bare[:, end].all(axis=1) for end in of_ends], axis=1)
        covers = self._covers(frame, (fit.point[0] + beyond[0])[edge[0] & sides])
        covered, before, after = (
            covers[frame.field.at(at)] for at in (fit.point, fit.point - reach * fit.normal, fit.point + beyond)
        )
        before, after = (np.stack([c[:, end].mean(axis=1) > 0.5 for end in of_ends], axis=1) for c in (before, after))
        state = np.where(open_, np.where(goes_on, GOES_ON, np.where(before, BENEATH, BEYOND)), AT_EDGE)
        hidden = self._ends_covered(state, covered, edge, sides, self._along[ends][:, which])
        lost = (bare & shows & sides & ~hidden).sum(axis=(1, 2)) / sides.sum()
        votes = np.log(np.maximum(self._voter.votes(frame, poses, occlusion=True), 1.0))
        on = (state == GOES_ON) | (state == AT_EDGE) & after
        return Seen(state, np.stack([-on.sum(axis=1), -(state == BEYOND).sum(axis=1), -lost, votes], axis=1))

    def _covers(self, frame: ImageFrame, beside: Array) -> NDArray[np.bool_]:
        """(256,) codes of what may lie before markers: classes but for the object's, and pixels that others own; what
        lies beside most of the sides is ground. Beyond the image no contour is seen to lack an edge.

        :param beside: (n, 2) pixels beside sides.
        """
        label = frame.field.meaning.label
        covers = 2 * np.bincount(label[frame.field.at(beside)], minlength=256) <= len(beside)
        covers[[UNKNOWN, EMPTY, OUTSIDE, *(k for labels in self._surface.marker_labels for k in labels)]] = False
        return np.asarray(covers[label])

    @staticmethod
    def _ends_covered(
        state: NDArray[np.int64],
        covered: NDArray[np.bool_],
        edge: NDArray[np.bool_],
        sides: NDArray[np.bool_],
        along: Array,
    ) -> NDArray[np.bool_]:
        """(H, K, m) points of K markers farther out than their sides have an edge, at ends that lie beyond their class;
        or beneath something, if they do.

        :param covered: (H, K, m) which do. :param edge: (H, K, m) which have one. :param sides: (K, m) those of sides.
        :param along: (E, K, m).
        """
        seen = np.where(edge[:, None] & sides, along, -np.inf).max(axis=(2, 3))  # (H, E)
        beyond, beneath = ((state == which)[..., None, None] for which in (BEYOND, BENEATH))
        return np.asarray(((beyond | beneath & covered[:, None]) & (along > seen[..., None, None])).any(axis=1))

    def _ended_otherwise(
        self, frame: ImageFrame, pose: Poses, used: NDArray[np.bool_], ends: NDArray[np.int64]
    ) -> Poses:
        """With ends where the class ends; and from there, and from where they are, without each of them.

        What is seen about an end is left out with all of the marker's half first: its sides may be a stray's.
        """
        config = self._config.fit
        afar = config.coarse_reach_px + config.fine_reach_px
        spans = self._going_on.fitted(frame, pose, used[None], covered=False)
        begun = Poses.concatenate([pose, self._fit.of(frame, spans, used[None], config.fine_reach_px, last=True)])
        row, end = np.repeat(np.arange(len(begun)), len(ends)), np.tile(ends, len(begun))
        use, freed = np.tile(used, (len(row), 1)), begun[row]
        shown = self._surface.shown_contour(freed, use)
        for without in (self._along[end] > 0, self._end[end]):
            freed = self._fit.by(self._fit.terms(frame, use, afar, shown=shown & ~without), frame, freed)
        return Poses.concatenate([begun[1:], freed])

    def _in_limits(self, frame: ImageFrame, poses: Poses) -> Poses:
        """Those of a scale that is looked for, and that the scene has there."""
        near_m, far_m = self._climber.depths(frame.camera)
        depth = poses.t[:, 2]
        kept = (depth >= near_m) & (depth <= far_m)
        if frame.scene:
            scale, limits = frame.camera.focal_px / depth, frame.scene.scale_limits(project(frame.camera, poses.t))
            kept &= (scale >= limits[:, 0]) & (scale <= limits[:, 1])
        return poses[np.flatnonzero(kept)]

    def _at(self, frame: ImageFrame, poses: Poses, ends: NDArray[np.int64]) -> Array:
        """(H, E, 2) the ends' middles, pixels."""
        surface = self._surface
        points = np.array([surface.contour[self._end[k]].mean(axis=0) for k in ends])
        frames = surface.kinematics.seen(poses.R, poses.t, poses.q)
        X = surface.place(frames, points, surface.component[surface.markers[self._marker[ends]]])
        return project(frame.camera, X.reshape(-1, 3)).reshape(len(poses), len(ends), 2)
