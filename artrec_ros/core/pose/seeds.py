"""First hypotheses of a spatial object: poses in which one of its components made a blob.

The paper starts from the required component (phase 1). Seen from its side, half hidden or merged with something of
its class that one is hard to make out, while the others are plain; so each of them is tried, too.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..image.blobs import Blob, centres, solidity
from ..image.image_frame import ImageFrame
from ..model.target import Target
from .distinct import best_distinct
from .guesses import Guesser, Key, is_small
from .headings import Headings
from .lookalikes import Lookalikes
from .pose_fit import fit_component
from .poses import Poses
from .surface_model import SpatialModel
from .view_bank import ViewBank


class Seeds:
    """Guesses of one target's pose, from each blob of a class of its components.

    :ivar labels: these classes. :ivar has_solids: whether markers meet at angles, see `solid_views`.
    """

    def __init__(
        self, target: Target, surface: SpatialModel, config: RecognizerConfig, lookalikes: Lookalikes | None = None
    ) -> None:
        """:param lookalikes: a component whose blob these lead from to the required one need not be started from."""
        self._surface, self._root = surface, surface.root
        self._config, self._search, self._fit = config.guesses, config.search, config.fit
        self._min_votes, self._hidden_cost = config.verdict.min_votes, config.votes.hidden_cost
        self._solidity: dict[int, float] = {}  # of each class the greatest
        for component, labels in zip(target.model.components, surface.labels, strict=True):
            for label, marker in product(labels, component.markers):
                self._solidity[label] = max(self._solidity.get(label, 0.0), solidity(marker.outline))
        self._patches: dict[tuple[tuple[int, ...], bool], np.ndarray] = {}
        banks: dict[Key, ViewBank] = {}
        self._guessers = {
            c: Guesser(target.model, surface, c, config, banks)
            for c in range(len(target.model.components))
            if not (c != self._root and lookalikes and lookalikes.leads_to(c))
        }
        self.has_solids = any(g.has_solids for g in self._guessers.values())
        self._headings = Headings(surface, config.guesses, config.search)
        self._sizes_m2 = {c: guesser.largest_m2 for c, guesser in self._guessers.items()}
        self._reach_m = max(g.reach_m for g in self._guessers.values()) + self._guessers[self._root].reach_m

    def may_be_several(self, blob: Blob) -> bool:
        """Whether several things make up a blob: one that fills its convex hull as well as a marker of its class does
        is one piece."""
        if blob.area_px < self._config.piece_ratio * self._config.small_px:
            return False
        return solidity(blob.contour) < self._config.compact * self._solidity.get(blob.label, 0.0)

    def may_belong(self, limb: Blob, root: Blob) -> bool:
        """Whether one object may have made both blobs, `root` with its required component, and show enough of it: they
        are no farther apart than it reaches, as large as they show it, and the limb's shape tells of its marker."""
        if is_small(limb, self._config):
            return False
        by_limb = max(limb.area_px / self._sizes_m2[c] for c, g in self._guessers.items() if limb.label in g.labels)
        by_root = root.area_px / self._sizes_m2[self._root]  # px^2/m^2
        if by_root < self._config.limb_root_share * by_limb:
            return False
        apart_px = float(np.linalg.norm(np.diff(centres([limb, root]), axis=0)))
        return apart_px <= self._config.limb_reach * self._reach_m * max(by_limb, by_root) ** 0.5

    @property
    def labels(self) -> set[int]:
        return {label for guesser in self._guessers.values() for label in guesser.labels}

    def few(self, frame: ImageFrame, blob: Blob) -> Poses:
        """Of an object in plain view whose required component made the blob; none where there can be no such object."""
        if blob.label not in self._guessers[self._root].labels:
            return self._surface.no_poses
        guesses = self._guessers[self._root].guess(frame, blob)
        few = self._best_roots(frame, guesses, self._config.few_guesses, bodies=False)
        roots = self._fit_root(frame, few, self._config.few_keep)
        plain = self._votes(frame, roots, self._root).max(initial=0.0) >= self._min_votes  # by itself
        return self._headings.of_required(roots) if plain else roots[:0]

    def all(self, frame: ImageFrame, blob: Blob, piece: int = 0) -> Poses:
        """Of an object of which any component made the blob, or part of it. :param piece: see `scale_range`."""
        roots = self._surface.no_poses
        if blob.label in self._guessers[self._root].labels:
            guesses = self._guessers[self._root].guess(frame, blob, piece)
            if is_small(blob, self._config):
                roots = self._best_roots(frame, guesses, self._config.root_keep)
            else:
                roots = self._fit_root(frame, guesses, self._config.root_keep, hidden=True)
            roots = self._headings.of_required(roots)
        return Poses.concatenate([roots, self._of_limbs(frame, blob, piece)])

    def _fit_root(self, frame: ImageFrame, poses: Poses, keep: int, *, hidden: bool = False) -> Poses:
        """Of guesses and their fits to the required component's contours the best by its markers."""
        fitted = fit_component(self._surface, frame, poses, self._root, self._fit)
        return self._best_roots(frame, Poses.concatenate([poses, fitted]), keep, bodies=False, hidden=hidden)

    def _best_roots(
        self, frame: ImageFrame, poses: Poses, n: int, *, bodies: bool = True, hidden: bool = False
    ) -> Poses:
        """The best by the required component alone, with or without its body."""
        votes = self._votes(frame, poses, self._root, bodies=bodies, hidden=hidden)
        return poses[best_distinct(poses, votes, n, self._search)]

    def _of_limbs(self, frame: ImageFrame, blob: Blob, piece: int) -> Poses:
        """The best of which another component made the blob, by the votes for both it and the required one."""
        parts, votes = [self._surface.no_poses], [np.zeros(0)]
        for c, guesser in self._guessers.items():
            if c != self._root and blob.label in guesser.labels and not frame.deadline.expired:
                poses = guesser.guess(frame, blob, piece)
                votes_of_limb, keep = self._votes(frame, poses, c), self._config.limb_guesses
                poses = poses[best_distinct(poses, votes_of_limb, keep, self._search)]
                parts.append(guesser.bends.of(self._headings.of_ball(poses, c)))
                votes.append(self._votes(frame, parts[-1], c, self._root))
        poses = Poses.concatenate(parts)
        return poses[best_distinct(poses, np.concatenate(votes), self._config.limb_keep, self._search)]

    def _votes(
        self, frame: ImageFrame, poses: Poses, *components: int, bodies: bool = True, hidden: bool = False
    ) -> Array:
        """(H,) votes for some components, with or without their bodies; occlusion apart, but where sides that meet were
        laid on blobs with what hides some of them.

        :param hidden: a marker that speaks against itself counts as hidden, at a price: of a component with markers on
            several sides another object may hide some, and of what is hidden others' pixels say nothing.
        """
        patches, solid = self._patches_of(components, bodies), self.has_solids
        scores = self._surface.score(frame, poses, patches, occlusion=solid, rigid=solid)
        least = -self._hidden_cost * scores.area_px if hidden else -np.inf
        return np.asarray(np.maximum(scores.votes, least).sum(axis=1))

    def _patches_of(self, components: tuple[int, ...], bodies: bool) -> np.ndarray:
        """The components' patches: indices into the surface's, ascending."""
        if (components, bodies) not in self._patches:
            mine = np.isin(self._surface.component, components) & (bodies | self._surface.is_marker)
            self._patches[components, bodies] = np.flatnonzero(mine)
        return self._patches[components, bodies]
