"""Search of one image for objects that face the camera: all hypotheses of all blobs in one batch.

What a search in space does blob by blob is done at once here: there are many small objects, each with few hypotheses.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from .base.config import RecognizerConfig
from .facing_known import FacingKnown
from .facing_lone import FacingLone
from .facing_sizes import FacingSizes, with_joints
from .geometry.projection import project
from .geometry.range_limits import ScaleLimits
from .geometry.transforms import Array
from .image.blobs import Blob, centres, find_blobs, solidity
from .image.image_frame import ImageFrame
from .memory.recall import Recall
from .pose.climber import Climb
from .pose.directions import Directions
from .pose.distinct_kernels import few_of_places
from .pose.facing_guesses import FacingGuesser
from .pose.facing_limbs import FacingLimbs
from .pose.facing_pairs import FacingPairs
from .pose.finder import WholeObjectFinder
from .pose.guesses import is_small
from .pose.others_shown import OthersShown
from .pose.poses import Poses
from .pose.ranked import Ranked, first_of_each

_TURNS = 24  # all around: hypotheses of one place that differ by less than one are alike
_ALIKE = 2  # rivals that are alike: one and its fit to the contours
_TURNED_AT_ONCE = 2048  # between two looks at the clock: few at a time take as long again
_CELLS = 1 << 20  # more than any image has along a side


class FacingSearch:
    """One target's candidates."""

    def __init__(self, finder: WholeObjectFinder, config: RecognizerConfig) -> None:
        self.finder, self._config = finder, config
        model, surface = finder.target.model, finder.surface
        self._directions = Directions.about_required(finder, config)
        self._others = OthersShown(finder, config.verdict.lengths_off) if self._directions.turned > 1 else None
        self._guesser = FacingGuesser(model, surface, config, surface.root, self._directions.laid)
        self._limbs = FacingLimbs(model, surface, config)
        self._pairs = FacingPairs(finder, self._guesser, config, self._directions.kept)
        self._climbs = Climb(0, config.facing.rounds[0], config.facing.first_step), finder.last_climb
        self._sizes = FacingSizes(finder, config)
        self._known = FacingKnown(finder, self._sizes, config)
        self._lone = FacingLone(finder) if finder.surface.is_lone_marker else None
        markers = model.required.markers
        self._largest, self._compact = max(m.area for m in markers), max(solidity(m.outline) for m in markers)

    def large(self, blobs: Sequence[Blob], limits: ScaleLimits) -> list[Blob]:
        """Blobs of the required component's class that may hold more than the component; where nothing else leads to
        the object only those of `several`."""
        least_px = self._config.guesses.small_px / self._config.facing.least_area_share
        large = [b for b in blobs if b.label in self.finder.root_labels and b.area_px >= least_px]
        return large if self._limbs.labels else self.several(large, limits)

    def several(self, blobs: Sequence[Blob], limits: ScaleLimits) -> list[Blob]:
        """Those that may be several merged ones, smaller than `run` looks for in a blob: one that fills its convex hull
        as well as the component's marker does is one piece.

        :param limits: of the scale. Where a smaller part of a blob is still larger than the component can be, its
            greatest scale was looked through.
        """
        most_px = self._largest * limits.greatest**2 / self._config.facing.least_area_share
        compact = self._config.guesses.compact * self._compact
        return [b for b in blobs if b.area_px < most_px and solidity(b.contour) < compact]

    def unexplained(self, frame: ImageFrame, blobs: Sequence[Blob]) -> list[Blob]:
        """Those of which nobody owns most."""
        return [b for b in blobs if frame.field.owned_share(b.contour) <= self._config.search.explained]

    def roomy(self, frame: ImageFrame, blobs: Sequence[Blob], found: Poses) -> list[Blob]:
        """Blobs of the required component's class with room for one more than stand in them: one that touches others
        can have lost its place to hypotheses that lie across them."""
        anchors, share = self.finder.required.anchors(found), self._config.facing.least_area_share
        place, area = project(frame.camera, anchors), self._largest * (frame.camera.focal_px / anchors[:, 2]) ** 2
        mine = [b for b in blobs if b.label in self.finder.root_labels]
        low, high = np.array([b.box for b in mine]).reshape(-1, 2, 1, 2).swapaxes(0, 1)
        within = ((place >= low) & (place <= high)).all(axis=2)  # (B, H) by x and by y
        # each stands in the smallest that can hold it: a border around the scene has all of it in its bounding box
        size = np.array([b.area_px for b in mine])[:, None]
        smallest = np.where(within & (size >= share * area), size, np.inf)
        within &= smallest == smallest.min(axis=0, initial=np.inf)
        return [
            b
            for b, own in zip(mine, within, strict=True)
            if own.any() and b.area_px - area[own].sum() >= share * area[own].min()
        ]

    def pieces(self, rest: ImageFrame, blobs: Sequence[Blob], found: Poses) -> list[Blob]:
        """What objects leave of blobs, where that is large enough to be another one.

        :param rest: the frame without the pixels of the objects.
        """
        depth = self.finder.required.anchors(found)[:, 2]
        least_px = self._config.facing.least_area_share * self._largest * (rest.camera.focal_px / depth.max()) ** 2
        found_in = find_blobs(rest.field.labels, self.finder.root_labels, self._config)
        left = [piece for piece in found_in if piece.area_px >= least_px]
        low, high = np.array([b.box for b in blobs]).swapaxes(0, 1)
        at = centres(left)[:, None]
        inside = np.any(np.all((at >= low) & (at <= high), axis=2), axis=1)
        return [piece for piece, yes in zip(left, inside.tolist(), strict=True) if yes]

    def limbs(self, frame: ImageFrame, blobs: Sequence[Blob]) -> list[Blob]:
        """The largest blobs from which other components may lead to the object, of which nobody owns most."""
        mine = self._in_view(frame, [b for b in blobs if b.label in self._limbs.labels])
        mine = self.unexplained(frame, mine)
        return sorted(mine, key=lambda b: -b.area_px)[: self._config.facing.limb_blobs]

    def run(
        self,
        frame: ImageFrame,
        blobs: Sequence[Blob],
        limits: ScaleLimits,
        sizes: int = 1,
        limbs: Sequence[Blob] = (),
        recall: Recall | None = None,
    ) -> Poses:
        """Candidates of all blobs, and those that have not the scale of the scene's plane fitted to it, too.

        :param limits: of the scale. :param sizes: of the required component in its blob, see `FacingGuesser.guess`.
        :param limbs: blobs that other components may have made. :param recall: what earlier frames say of this one.
        """
        search = partial(self._searched, frame, limits, sizes, limbs)
        found = search(blobs) if recall is None else self._known.beside(frame, blobs, recall, search)
        poses = (found if self._lone is None else self._told_apart(frame, found, self._lone)).poses
        at_scale = self.finder.at_scale
        if frame.scene.plane is None or at_scale is None or frame.deadline.expired:
            return poses
        fitted, beyond = at_scale.fitted(frame, poses)
        return Poses.concatenate([poses, fitted[beyond]])

    def _searched(
        self, frame: ImageFrame, limits: ScaleLimits, sizes: int, limbs: Sequence[Blob], blobs: Sequence[Blob]
    ) -> Ranked:
        """Candidates that blobs lead to."""
        mine = self._in_view(frame, [b for b in blobs if b.label in self.finder.root_labels])
        if not mine and not limbs:
            return self.finder.ranked(frame, self.finder.surface.no_poses)
        rivals = self._config.facing.rivals
        few_of = partial(self._few_of_each_place, frame, rivals=rivals, alone=len(mine) <= rivals)
        found, blob, most, swollen = self._guesses(frame, mine, blobs, limits, sizes, limbs)
        kept = self._best_of_each(frame, found, blob, most)
        begun, swollen = found[kept], swollen[kept]
        found = self._sizes.each(swollen, lambda finder, rows: finder.moved(frame, begun[rows], self._climbs[0]))
        kept = few_of(found)
        few, swollen = found[kept], np.sort(swollen)[kept]  # as `each` orders them
        found = self._sizes.each(swollen, lambda finder, rows: self._settled(finder, frame, few[rows]))
        if self._lone is not None:
            return found + self.finder.fit_all(frame, begun.poses)
        found = found[few_of(found)]
        if self._directions.turned == 1 or len(mine) > self._config.facing.swollen_most:
            return found
        larger = self._sizes.larger(frame, found, self._climbs[1])
        return found + larger[few_of(larger)]

    def _told_apart(self, frame: ImageFrame, found: Ranked, lone: FacingLone) -> Ranked:
        """Those of lone markers that go on."""
        few = self._few_of_each_place(frame, found, self._config.facing.rivals)
        if frame.deadline.expired:
            return found[few]
        best = self._few_of_each_place(frame, found, 1, lone.worth(frame, found.poses))
        slanted = self.finder.ranked(frame, lone.slanted(frame, found.poses[best]))
        return found[lone.told_apart(frame, found.poses, few, best)] + slanted

    def _settled(self, finder: WholeObjectFinder, frame: ImageFrame, few: Ranked) -> Ranked:
        """Hypotheses after the last climb, and so those that turn the required component onto itself, where they are
        the best of their places: its outline tells nothing of these turns, and a grid so coarse that other components
        lie beside their pixels keeps one by chance."""
        found = finder.gone_on(frame, finder.polished(frame, few, self._climbs[1]))
        if not len(finder.in_place) or frame.deadline.expired:
            return found
        every = found + with_joints(finder, frame, finder.in_place.of(found.poses))
        best = self._few_of_each_place(frame, every, 1)
        return found + finder.polished(frame, every[best[best >= len(found)]], self._climbs[1])

    def _in_view(self, frame: ImageFrame, blobs: Sequence[Blob]) -> list[Blob]:
        """Those that do not lie behind the horizon."""
        if not frame.scene or not blobs:
            return list(blobs)
        seen = frame.scene.scale_limits(centres(blobs))[:, 1] > 0
        return [b for b, yes in zip(blobs, seen, strict=True) if yes]

    def _guesses(
        self,
        frame: ImageFrame,
        mine: Sequence[Blob],
        blobs: Sequence[Blob],
        limits: ScaleLimits,
        sizes: int,
        limbs: Sequence[Blob],
    ) -> tuple[Ranked, NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
        """Hypotheses that come near to the best of their blobs, of which blob and size each is (H,), how many of each
        of these shall go on, and whether its markers look larger than they are (H,)."""
        hurried, config, own = frame.hurried(self._config.facing.guess_share), self._config.facing, sizes * len(mine)
        early = hurried.hurried(0.5) if limbs else hurried  # as much time is left for these
        poses, own_votes, blob = self._guesser.guess(early, mine, limits, sizes)
        of_limbs, limb = self._limbs.guess(hurried, limbs, limits)
        of_limbs = self.finder.climber.within_limits(frame.camera, of_limbs)
        most = np.full(own + len(limbs), config.per_patch)
        most[:own] = self._directions.kept * -(-np.bincount(blob, minlength=own) // self._directions.laid)
        # a blob in which smaller ones are looked for has no middle
        paired, pair = self._pairs.guess(early, mine if sizes == 1 else (), blobs, limits)
        likely = first_of_each(blob, own_votes, config.per_patch if self._directions.turned == 1 else 0)
        poses, blob = self._turned(early, poses, blob)
        poses, blob = Poses.concatenate([poses, paired, of_limbs]), np.concatenate([blob, pair, own + limb])
        long = np.array([not is_small(b, self._config.guesses) for b in mine] * sizes + [False] * len(limbs), bool)
        few = len(mine) <= config.swollen_most
        small = np.array([few and self._sizes.matter(b) for b in mine] * sizes + [False] * len(limbs), bool)
        found, swollen = self._sizes.of(frame, poses, small[blob] & (self._directions.turned == 1), limits)
        near = self._near_best(found.votes, blob)
        # fits of the contours where they are long enough: a grid is coarse there, and what it turns by a few degrees
        # may lay all but the component itself beside its pixels
        every = np.union1d(near, likely)
        large, limb = every[long[blob[every]]], near[blob[near] >= own]
        if not len(large) and not len(limb):
            return found[near], blob[near], most, swollen[near]
        fitted = self._guesser.fitted(frame, found.poses[large])
        fitted = Poses.concatenate([fitted, self.finder.rest.fitted(frame, found.poses[limb])])
        again = with_joints(self.finder, frame, self.finder.climber.within_limits(frame.camera, fitted))
        swollen = np.concatenate([swollen[near], np.zeros(len(large) + len(limb), bool)])
        return found[near] + again, np.concatenate([blob[near], blob[large], blob[limb]]), most, swollen

    def _turned(self, frame: ImageFrame, poses: Poses, blob: NDArray[np.int64]) -> tuple[Poses, NDArray[np.int64]]:
        """What was laid on blobs (H,), in the best of the directions in which it is to be turned, and their blobs."""
        directions = self._directions
        if self._others is None or not len(poses):
            return poses, blob
        shown = self._others.in_frame(frame)
        found, of = [self.finder.surface.no_poses], [np.zeros(0, np.int64)]
        for part in frame.deadline.parts(len(poses), max(_TURNED_AT_ONCE // directions.turned, 1)):
            turned, which = directions.turn(self.finder, self._guesser, frame, poses[part])
            told = shown(turned)
            told[np.unique(which, return_index=True)[1]] = True  # what is laid is judged, whatever is around it
            turned, which = turned[np.flatnonzero(told)], which[told]
            ranked = with_joints(self.finder, frame, turned)
            best = first_of_each(which, ranked.votes, directions.kept)
            found.append(ranked.poses[best])
            of.append(blob[part][which[best]])
        return Poses.concatenate(found), np.concatenate(of)

    def _near_best(self, votes: Array, blob: NDArray[np.int64]) -> NDArray[np.int64]:
        """Indices of hypotheses that come near to the best one of their blob."""
        best = np.zeros(blob.max(initial=-1) + 1)
        np.maximum.at(best, blob, votes)
        return np.flatnonzero((votes > 0) & (votes >= self._config.facing.least_share * best[blob]))

    def _few_of_each_place(
        self, frame: ImageFrame, found: Ranked, rivals: int, worth: Array | None = None, *, alone: bool = False
    ) -> NDArray[np.int64]:
        """Indices of the best, and at each place where the required component is of a few rivals: all that a verdict
        must look at.

        :param worth: (H,) by what they are the best; None: by their votes. :param alone: whether there are so few
            places that there is time for what is turned otherwise in any case.
        """
        worth = found.votes if worth is None else worth
        rows = np.flatnonzero(found.votes > self._config.verdict.min_votes)
        poses = found.poses[rows]
        best = np.argsort(self.finder.alternatives.contradicted(frame, poses) - worth[rows], kind="stable")
        order, poses = rows[best], poses[best]
        anchors = self.finder.required.anchors(poses)
        at = anchors[:, :2] / anchors[:, 2:] * frame.camera.focal_px
        reach = self.finder.surface.extent / 2 * frame.camera.focal_px / anchors[:, 2]  # half of one covers the other
        at, turns, near = np.ascontiguousarray(at), self._turns(poses), float(np.cos(2 * np.pi / _TURNS))
        found_each = list[NDArray[np.int64]]()
        for alike in {_ALIKE if self._directions.turned > 1 else rivals, *([_ALIKE] if alone else [])}:
            kept = np.empty(len(order), np.int64)
            n = few_of_places(at, turns, reach, rivals, alike, near, kept)
            found_each.append(kept[:n])
        return np.asarray(order[np.unique(np.concatenate(found_each))])

    def _turns(self, poses: Poses) -> Array:
        """(H,) directions in the image, radians."""
        along = poses.R @ self._guesser.along
        return np.asarray(np.arctan2(along[:, 1], along[:, 0]))

    def _best_of_each(
        self, frame: ImageFrame, found: Ranked, blob: NDArray[np.int64], most: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """Indices of the best hypotheses of each blob that are not alike. :param most: of each blob."""
        rows = self._near_best(found.votes, blob)
        rows = rows[np.lexsort((-found.votes[rows], blob[rows]))]
        poses = found.poses[rows]
        uv = poses.t[:, :2] / poses.t[:, 2:] * (frame.camera.focal_px / self._config.facing.cell_px)
        turn = np.rint(self._turns(poses) * (_TURNS / (2 * np.pi))).astype(np.int64) % _TURNS
        u, v = np.rint(uv).astype(np.int64).T % _CELLS
        cell = ((blob[rows] * _TURNS + turn) * _CELLS + u) * _CELLS + v
        rows = rows[np.sort(np.unique(cell, return_index=True)[1])]
        return np.asarray(rows[first_of_each(blob[rows], found.votes[rows], most)])
