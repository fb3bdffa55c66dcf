"""First hypotheses of a spatial object: poses in which one of its components made a blob.

The paper starts from the required component (phase 1). Seen from its side, half hidden or merged with something of
its class that one is hard to make out, while the others are plain; where they are of the same class, each of them is
tried, too. An object is still none without its required component.
"""

from __future__ import annotations

import numpy as np

from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..model.target import Target
from .distinct import best_distinct
from .guesses import Guesser, is_small
from .pose_fit import fit_poses
from .surface_model import Poses, SpatialModel

PLAIN_PX, PLAIN_VOTES = 30.0, 300.0  # of a blob, and for its component: no object with less is beyond doubt
FEW_GUESSES, FEW_KEEP = 24, 10  # enough for most objects in plain view
ROOT_KEEP = 40
LIMB_GUESSES, LIMB_KEEP = 32, 64  # of each other component, before its joints are bent; of all of them
COARSE_REACH_PX = (8, 6, 4, 3)


class Seeds:
    """Guesses of one target's pose, from each blob of its required component's class."""

    def __init__(self, target: Target, surface: SpatialModel) -> None:
        self._surface, self._root = surface, surface.root
        self._patches: dict[tuple[tuple[int, ...], bool], np.ndarray] = {}
        self._guessers = {
            c: Guesser(target.model, surface, c)
            for c, label in enumerate(surface.labels)
            if label == surface.labels[self._root]
        }

    def few(self, frame: ImageFrame, blob: Blob) -> Poses:
        """Of an object in plain view whose required component made the blob; none where there can be no such object."""
        if blob.area_px < PLAIN_PX:
            return self._surface.no_poses
        guesses = self._guessers[self._root].guess(frame, blob)
        few = self._best_roots(frame, guesses, FEW_GUESSES, bodies=False)
        roots = self._fit_root(frame, few, FEW_KEEP)
        plain = self._votes(frame, roots, self._root).max(initial=0.0) >= PLAIN_VOTES
        return roots if plain else roots[:0]

    def all(self, frame: ImageFrame, blob: Blob) -> Poses:
        """Of an object of which any component made the blob, or part of it."""
        guesses = self._guessers[self._root].guess(frame, blob)
        if is_small(blob):
            roots = self._best_roots(frame, guesses, ROOT_KEEP)
        else:
            roots = self._fit_root(frame, guesses, ROOT_KEEP)
        return Poses.concatenate([roots, self._of_limbs(frame, blob)])

    def _fit_root(self, frame: ImageFrame, poses: Poses, keep: int) -> Poses:
        """Of guesses and their fits to the required component's contours the best by its markers."""
        surface = self._surface
        use = np.tile(surface.component[surface.markers] == self._root, (len(poses), 1))
        pinned = np.zeros(poses.q.shape, bool)
        fitted = fit_poses(surface, frame, poses, use, COARSE_REACH_PX, pinned)
        return self._best_roots(frame, Poses.concatenate([poses, fitted]), keep, bodies=False)

    def _best_roots(self, frame: ImageFrame, poses: Poses, n: int, *, bodies: bool = True) -> Poses:
        """The best by the required component alone, with or without its body."""
        return poses[best_distinct(poses, self._votes(frame, poses, self._root, bodies=bodies), n)]

    def _of_limbs(self, frame: ImageFrame, blob: Blob) -> Poses:
        """The best of which another component made the blob, by the votes for both it and the required one."""
        parts, votes = [self._surface.no_poses], [np.zeros(0)]
        for c, guesser in self._guessers.items():
            if c != self._root and not frame.deadline.expired:
                poses = guesser.guess(frame, blob)
                poses = poses[best_distinct(poses, self._votes(frame, poses, c), LIMB_GUESSES)]
                parts.append(guesser.bent(poses))
                votes.append(self._votes(frame, parts[-1], c, self._root))
        poses = Poses.concatenate(parts)
        return poses[best_distinct(poses, np.concatenate(votes), LIMB_KEEP)]

    def _votes(self, frame: ImageFrame, poses: Poses, *components: int, bodies: bool = True) -> Array:
        """(H,) votes for some components, occlusion apart, with or without their bodies."""
        patches = self._patches_of(components, bodies)
        return self._surface.score(frame, poses, patches, occlusion=False).votes.sum(axis=1)

    def _patches_of(self, components: tuple[int, ...], bodies: bool) -> np.ndarray:
        """The components' patches: indices into the surface's, ascending."""
        if (components, bodies) not in self._patches:
            mine = np.isin(self._surface.component, components) & (bodies | self._surface.is_marker)
            self._patches[components, bodies] = np.flatnonzero(mine)
        return self._patches[components, bodies]
