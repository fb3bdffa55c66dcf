"""Search of one image for objects that face the camera: all hypotheses of all blobs in one batch.

What a search in space does blob by blob is done at once here: there are many small objects, each with few hypotheses.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .base.config import RecognizerConfig
from .geometry.range_limits import ScaleLimits
from .image.blobs import Blob, centres
from .image.image_frame import ImageFrame
from .pose.distinct_kernels import few_of_places
from .pose.facing_guesses import FacingGuesser, Guesses
from .pose.finder import Climb, WholeObjectFinder
from .pose.guesses import is_small
from .pose.pose_fit import fit_required
from .pose.ranked import Ranked
from .pose.surface_model import Poses


_CELLS = 1 << 20  # more than any image has along a side


class FacingSearch:
    """One target's candidates."""

    def __init__(self, finder: WholeObjectFinder, config: RecognizerConfig) -> None:
        self.finder, self._config = finder, config
        self._guesser = FacingGuesser(finder.target.model, finder.surface, config)
        first, last = config.facing.rounds
        self._climbs = Climb(0, first, config.facing.first_step), Climb(0, last, config.facing.first_step / 2)

    def run(self, frame: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits) -> Poses:
        """Candidates of all blobs. :param limits: of the scale."""
        mine = [b for b in blobs if b.label in self.finder.root_labels]
        seen = frame.scene.scale_limits(centres(mine))[:, 1] > 0  # else behind the horizon
        mine = [b for b, yes in zip(mine, seen, strict=True) if yes]
        if not mine:
            return self.finder.surface.no_poses
        guesses = self._guesser.guess(frame.hurried(self._config.facing.guess_share), mine, limits)
        count = np.bincount(guesses.blob, minlength=len(mine))
        guesses = self._with_fits(frame, guesses, np.array([not is_small(b, self._config.guesses) for b in mine]))
        poses = guesses.poses
        if poses.q.shape[1]:
            poses = self.finder.surface.search_joints(frame, poses, self._config.search.first_joint_step)
        found = Ranked(poses, self.finder.votes(frame, poses, occlusion=True))
        most = self._config.facing.per_patch * -(-count // self._config.facing.turns)
        found = self.finder.moved(frame, found[self._best_of_each(frame, found, guesses.blob, most)], self._climbs[0])
        found = self.finder.polished(frame, self._few_of_each_place(frame, found), self._climbs[1])
        return self._few_of_each_place(frame, found).poses

    def _with_fits(self, frame: ImageFrame, guesses: Guesses, large: np.ndarray) -> Guesses:
        """Add fits of the required component's contours where it is large enough to have some: a grid is coarse there.

        :param large: of each blob, bool.
        """
        of = np.flatnonzero(large[guesses.blob])
        if not len(of):
            return guesses
        fitted = fit_required(self.finder.surface, frame, guesses.poses[of], self._config.fit, facing=True)
        return Guesses(
            Poses.concatenate([guesses.poses, fitted]),
            np.concatenate([guesses.votes, guesses.votes[of]]),
            np.concatenate([guesses.blob, guesses.blob[of]]),
        )

    def _few_of_each_place(self, frame: ImageFrame, found: Ranked) -> Ranked:
        """The best, and at each place where the required component is a few rivals: all that a verdict must look at."""
        order = np.argsort(-found.votes, kind="stable")
        order = order[found.votes[order] > self._config.verdict.min_votes]
        anchors = self.finder.anchors(found.poses[order])
        at = anchors[:, :2] / anchors[:, 2:] * frame.camera.focal_px
        reach = self.finder.surface.extent / 2 * frame.camera.focal_px / anchors[:, 2]  # half of one covers the other
        kept = np.empty(len(order), np.int64)
        n = few_of_places(np.ascontiguousarray(at), reach, int(self._config.facing.rivals), kept)
        return found[order[kept[:n]]]

    def _best_of_each(
        self, frame: ImageFrame, found: Ranked, blob: np.ndarray, most: np.ndarray
    ) -> NDArray[np.int64]:
        """Indices of the best hypotheses of each blob that are not alike. :param most: of each blob."""
        poses, votes, config = found.poses, found.votes, self._config.facing
        best = np.zeros(len(most))
        np.maximum.at(best, blob, votes)
        rows = np.flatnonzero((votes > 0) & (votes >= config.least_share * best[blob]))
        rows = rows[np.lexsort((-votes[rows], blob[rows]))]
        uv = poses.t[rows, :2] / poses.t[rows, 2:] * (frame.camera.focal_px / config.cell_px)
        along = poses.R[rows] @ self._guesser.along
        turn = np.arctan2(along[:, 1], along[:, 0]) * (12 / np.pi) % 24
        u, v = np.rint(uv).astype(np.int64).T % _CELLS
        cell = ((blob[rows] * 24 + np.rint(turn).astype(np.int64) % 24) * _CELLS + u) * _CELLS + v
        rows = rows[np.sort(np.unique(cell, return_index=True)[1])]
        rank = np.arange(len(rows)) - np.searchsorted(blob[rows], blob[rows])
        return np.asarray(rows[rank < most[blob[rows]]])
