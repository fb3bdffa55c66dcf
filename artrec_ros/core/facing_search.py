"""Search of one image for objects that face the camera: all hypotheses of all blobs in one batch.

What a search in space does blob by blob is done at once here: there are many small objects, each with few hypotheses.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .base.config import RecognizerConfig
from .geometry.range_limits import ScaleLimits
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .pose.facing_guesses import FacingGuesser
from .pose.finder import Climb, WholeObjectFinder
from .pose.ranked import Ranked
from .pose.surface_model import Poses


class FacingSearch:
    """One target's candidates."""

    def __init__(self, finder: WholeObjectFinder, config: RecognizerConfig) -> None:
        self.finder, self._config = finder, config
        self._guesser = FacingGuesser(finder.target.model, finder.surface, config)
        self._climb = Climb(0, config.facing.rounds, config.facing.first_step)

    def run(self, frame: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits) -> Poses:
        """Candidates of all blobs. :param limits: of the scale."""
        mine = [b for b in blobs if b.label in self.finder.root_labels]
        if not mine:
            return self.finder.surface.no_poses
        guesses = self._guesser.guess(frame, mine, limits)
        poses, count = guesses.poses, np.bincount(guesses.blob, minlength=len(mine))
        if poses.q.shape[1]:
            poses = self.finder.surface.search_joints(frame, poses, self._config.search.first_joint_step)
        votes = self.finder.votes(frame, poses, occlusion=False)
        most = self._config.facing.per_patch * -(-count // self._config.facing.turns)
        keep = self._best_of_each(frame, poses, votes, guesses.blob, most)
        return self._few_of_each_place(frame, self.finder.polished(frame, poses[keep], self._climb))

    def _few_of_each_place(self, frame: ImageFrame, found: Ranked) -> Poses:
        """The best, and at each place where the required component is a few rivals: all that a verdict must look at."""
        order = np.argsort(-found.votes, kind="stable")
        order = order[found.votes[order] > self._config.verdict.min_votes]
        anchors = self.finder.anchors(found.poses[order])
        at = anchors[:, :2] / anchors[:, 2:] * frame.camera.focal_px
        reach = self._config.search.same_place * self.finder.surface.extent * frame.camera.focal_px / anchors[:, 2]
        near = np.linalg.norm(at[:, None] - at, axis=2) < reach[:, None]
        kept: list[int] = []
        for i in range(len(order)):
            if np.count_nonzero(near[i, kept]) < self._config.facing.rivals:
                kept.append(i)
        return found.poses[order[kept]]

    def _best_of_each(
        self, frame: ImageFrame, poses: Poses, votes: np.ndarray, blob: np.ndarray, most: np.ndarray
    ) -> np.ndarray:
        """Indices of the best hypotheses of each blob that are not alike."""
        cell = self._config.facing.cell_px
        uv = np.rint(poses.t[:, :2] / poses.t[:, 2:] * (frame.camera.focal_px / cell))
        along = poses.R @ self._guesser.along
        turn = np.rint(np.arctan2(along[:, 1], along[:, 0]) * (12 / np.pi)) % 24
        order = np.lexsort((-votes, blob))
        keys = np.column_stack([blob, uv, turn])[order]
        _, first = np.unique(keys, axis=0, return_index=True)
        order = order[np.sort(first)]
        rank = np.arange(len(order)) - np.searchsorted(blob[order], blob[order])
        return np.asarray(order[(rank < most[blob[order]]) & (votes[order] > 0)])
