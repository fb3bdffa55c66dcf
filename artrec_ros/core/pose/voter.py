"""What the labels say of whole hypotheses of one object."""

from __future__ import annotations

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..image.label_field import LabelField
from .climb_kernels import Value, totals, votes_of
from .poses import PatchScores, Poses
from .surface_model import SpatialModel


class Voter:
    """Votes for whole objects, and which of their markers they support.

    :ivar value: how the votes for an object's patches add up.
    """

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self.surface, self._config = surface, config
        components, hidden_cost = len(surface.model.components), float(config.votes.hidden_cost)
        self.value = Value(components, surface.root, hidden_cost, occlusion=True)
        self._patches = np.arange(len(surface.patches))
        self._kept: tuple[LabelField, Poses, PatchScores] | None = None
        self._kept_votes: Array | None = None

    def keep(self, frame: ImageFrame, poses: Poses, scores: PatchScores | None = None) -> None:
        """Remember what the labels say of these hypotheses, until others are kept: all who compare others with them ask
        for it. :param scores: None: not known yet."""
        if self._known(frame, poses) is None:
            self._kept = frame.field, poses, scores or self.judge(frame, poses, occlusion=True)
            self._kept_votes = None

    def _known(self, frame: ImageFrame, poses: Poses) -> PatchScores | None:
        kept = self._kept
        return kept[2] if kept is not None and kept[1] is poses and kept[0] is frame.field else None

    def judge(self, frame: ImageFrame, poses: Poses, *, occlusion: bool, covered: bool = False) -> PatchScores:
        """What the labels say of every patch under each hypothesis: see `SpatialModel.score`."""
        if occlusion and not covered and (known := self._known(frame, poses)) is not None:
            return known
        return self.surface.score(frame, poses, self._patches, occlusion=occlusion, covered=covered)

    def votes(self, frame: ImageFrame, poses: Poses, *, occlusion: bool) -> Array:
        """(H,) votes of whole objects; a component that speaks against itself counts as hidden, at a price."""
        if not occlusion or (known := self._known(frame, poses)) is None:
            return self._counted(frame, poses, occlusion=occlusion)
        if self._kept_votes is None:  # what verdicts refuse of parts that lie on each other no search does
            again = bool(((known.votes == 0.0) & (known.area_px > 0.0)).any())
            self._kept_votes = self._counted(frame, poses, occlusion=True) if again else self.total(known)
        return self._kept_votes.copy()  # a climb changes them in place

    def _counted(self, frame: ImageFrame, poses: Poses, *, occlusion: bool) -> Array:
        surface, view, out = self.surface, frame.view, np.empty(len(poses))
        value = self.value._replace(occlusion=occlusion)
        R, t, q = poses.R, poses.t, poses.q
        votes_of(surface.compiled, surface.kinematics.chain, view, surface.limits, value, R, t, q, out)
        return out

    def total(self, scores: PatchScores) -> Array:
        """(H,) votes of whole objects from what is said of all their patches."""
        out = np.empty(len(scores.votes))
        totals(self.surface.compiled, self.value, scores.votes, scores.area_px, out)
        return out

    def borne_out(self, scores: PatchScores) -> Array:
        """(H,) votes of the markers that the labels support, whatever the others lack."""
        votes = scores.votes[:, self.surface.marker_columns]
        return np.asarray(np.where(self.supported(scores), votes, 0.0).sum(axis=1))

    def supported(self, scores: PatchScores) -> np.ndarray:
        """(H, M) markers that the labels support."""
        m, config = self.surface.marker_columns, self._config
        seen = (scores.area_px[:, m] > config.min_blob_px) & (scores.agree[:, m] > config.votes.supported_agree)
        return np.asarray(seen & (scores.votes[:, m] > 0))

    def supports(self, frame: ImageFrame, poses: Poses) -> np.ndarray:
        """(H, M) markers that the labels of a frame support under each hypothesis."""
        return self.supported(self.judge(frame, poses, occlusion=True))

    def lacks_px(self, scores: PatchScores) -> Array:
        """(H, M) pixels of each marker that are not of its class, less what a rim around it can take: 0 or less of one
        that is seen whole."""
        surface, m = self.surface, self.surface.marker_columns
        area_px: Array = scores.area_px[:, m]
        around_px = surface.perimeter * np.sqrt(area_px / surface.area[m])
        return np.asarray((1 - scores.agree[:, m]) * area_px - surface.votes.ring_px * around_px, np.float64)
