"""What of the image a told object leaves unexplained though it may be its own, and how probable its pose then is.

Where a model is not exact, as of a limb that swings out of its plane, no pose explains all markers. The one found then
lies on some of them, as well as a right one would, and says of the others that they are beyond the border or not to be
seen. What speaks against it is in the image: a blob of such a component's class, about as large as its marker, which
nothing explains, no farther from what is seen of the object than the component can be. How much that says depends on
the pose: one that its own markers bear out more than once stands in spite of it, while one that has as many joints as
they tell places of stands on nothing else. How many like things lie elsewhere in the image says no more: where many do,
poses are led astray by them as well.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import compress, zip_longest
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.blobs import Blob, centres
from ..image.image_frame import ImageFrame
from ..model.found import Detection, Missing
from ..model.kinematics import Frames
from ..pose.exchanges import OFF
from ..pose.finder import WholeObjectFinder
from ..pose.freedom import numbers_told, pose_numbers
from ..pose.poses import Poses
from ..pose.surface_kernels import LEAST_DEPTH_M
from ..pose.through_middles import Middles
from .free_blobs import FreeBlobs, Sizes
from .verdicts import Verdict


class LeftOver(NamedTuple):
    """What one object leaves.

    :param blobs: by the components' indices, each component's nearest to where the pose has it.
    :param spare: by how many numbers what is seen tells more than the pose has.
    """

    blobs: dict[int, Blob]
    spare: float

    @property
    def choices(self) -> list[list[int]]:
        """Components whose blobs are to be explained: all together, and each alone of several."""
        every = list(self.blobs)
        return [every] + [[c] for c in every] * (len(every) > 1)

    def share(self, config: RecognizerConfig) -> float:
        """How probable the pose is, of an object that is there."""
        return _share(config, self.spare) if self.blobs else 1.0


_NOTHING = LeftOver({}, 0.0)


def _share(config: RecognizerConfig, spare: float) -> float:
    at_first, by_spare, most = config.verdict.left_over_odds
    return float(1 / (1 + np.exp(at_first + by_spare * min(spare, most))))


class LeftOvers:
    """Those of one target's objects."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, surface = finder, finder.surface
        self._config, self._kin = finder.config, surface.kinematics
        self._numbers = numbers_told(surface, *((2, 3) if finder.facing else (3, 6)))
        self._free_blobs = FreeBlobs(finder)
        self._of, self._middle, self._area = self._free_blobs.of, self._free_blobs.middle, self._free_blobs.area
        labels = [set(own) for own in surface.labels]
        others = [set[int]().union(*labels[:c], *labels[c + 1 :]) for c in range(len(labels))]
        self._spares = dict[frozenset[int], float]()
        self._exclusive = {c for c, own in enumerate(labels) if own.isdisjoint(others[c])}

    def of(
        self,
        seen: Sequence[Collection[int]],
        frames: Frames,
        frame: ImageFrame,
        blobs: Sequence[Blob],
        among: Sequence[Verdict],
        away: Sequence[Collection[int]] = (),
    ) -> list[LeftOver]:
        """What each of H objects leaves.

        :param seen: of each the components that are. :param frames: where all of its components are.
        :param blobs: of the frame. :param among: all its objects. :param away: components that made no blob.
        """
        every = set(range(len(self._kin.parent)))
        missing = [every.difference(*own) for own in zip_longest(seen, away, fillvalue=())]
        labels = {label for lacks in missing for c in lacks for label in self._finder.surface.labels[c]}
        mine = [b for b in blobs if b.label in labels]
        if not mine:
            return [_NOTHING] * len(seen)
        placed, sizes = self._finder.surface.place(frames, self._middle, self._of), Sizes.of(mine)
        near = [
            self._free_blobs.near(sorted(lacks), sorted(own), placed[h], frame.camera, sizes) if own and lacks else {}
            for h, (lacks, own) in enumerate(zip(missing, seen, strict=True))
        ]
        asked = np.zeros(len(mine), bool)
        for off in (off for by_component in near for off in by_component.values()):
            asked |= np.isfinite(off)
        free = self._free_blobs.unexplained(frame, mine, asked, among)
        return [self._left(by_component, free, mine, own) for by_component, own in zip(near, seen, strict=True)]

    def beside_steps(
        self, left: LeftOver, pose: Poses, seen: Collection[int], camera: Camera, blobs: Sequence[Blob]
    ) -> LeftOver:
        """With blobs that lie where another value of a joint would put what is missing while like markers lie on each
        other: on the object itself, so that nothing else asks what they are."""
        found, surface, of = dict(left.blobs), self._finder.surface, self._finder.joint_steps.of
        for j, steps in of.items() if blobs else ():
            moved = self._finder.joint_steps.beyond_limits(pose, j)
            placed = surface.place(self._kin.seen(moved.R, moved.t, moved.q), self._middle, self._of)
            for row, lies in zip(steps.markers.tolist(), steps.lies.T, strict=True):
                c, at = int(self._of[row]), placed[~lies, row]
                mine = [b for b in blobs if b.label in surface.labels[c]]
                if mine and len(at) and c not in {*seen, *found} and (at[:, 2] > LEAST_DEPTH_M).all():
                    found.update(
                        (c, b) for b in self._there(mine, project(camera, at), camera.focal_px / at[:, 2], row)
                    )
        return LeftOver(found, self._spare(frozenset(seen))) if found else left

    def _there(self, blobs: Sequence[Blob], pixels: Array, scale: Array, row: int) -> list[Blob]:
        """The blob nearest to one of some places (n, 2) of a marker at scales (n,), if it is about there, and as
        large."""
        sizes, size_px = Sizes.of(blobs), self._area[row] * scale**2
        off = np.linalg.norm(sizes.middles[:, None] - pixels, axis=2) / np.sqrt(size_px)
        nearest = np.where(self._free_blobs.as_large(sizes.area_px, size_px), off.min(axis=1), np.inf)
        return [blobs[int(np.argmin(nearest))]] if nearest.min() < OFF else []

    def is_in_doubt(self, seen: Collection[int]) -> bool:
        """Whether an object of which some components are seen is not sure if it leaves something."""
        return _share(self._config, self._spare(frozenset(seen))) <= self._config.search.sure

    def may_be_sure(self, missing: Collection[int]) -> bool:
        """Whether one of some components is of a class that no other one has, so that a blob may be it and no other."""
        return not self._exclusive.isdisjoint(missing)

    def is_sure(self, left: LeftOver, blobs: Sequence[Blob]) -> bool:
        """Whether one of the blobs that are left is the only one of its class that may be its component."""
        ratio, labels = self._config.verdict.left_over_ratio, self._finder.surface.labels
        return any(
            sum(b.label in labels[c] and b.area_px > blob.area_px / ratio for b in blobs) == 1
            for c, blob in left.blobs.items()
            if c in self._exclusive
        )

    def middles(
        self, pose: Poses, patches: Sequence[int], left: LeftOver, camera: Camera, lost: Sequence[int]
    ) -> Middles:
        """Where the middles of some markers of one object are, and blobs that it leaves.

        :param patches: (n,) of the surface. :param lost: components whose blobs.
        """
        at = self._finder.through_middles.places(pose, np.array(patches, np.int64))[0]
        more = [self._finder.surface.markers_of[c][0] for c in lost]
        own = np.sqrt(np.array([left.blobs[c].area_px for c in lost]) / self._finder.surface.sides.blobs[1][more])
        return Middles(
            np.array([*patches, *more], np.int64),
            np.concatenate([project(camera, at), centres([left.blobs[c] for c in lost])]),
            np.concatenate([camera.focal_px / at[:, 2], own]),
        )

    def beside(self, blobs: Sequence[Blob], verdict: Verdict, camera: Camera) -> list[Blob]:
        """Blobs whose middles lie on none of the markers that are seen of an object."""
        shown = np.array([p for p, yes in zip(verdict.shown, verdict.confirmed, strict=True) if yes], np.int64)
        at = self._finder.through_middles.places(verdict.claim.poses, shown)[0]
        radius = np.sqrt(self._finder.surface.sides.blobs[1][shown] / np.pi) * camera.focal_px / at[:, 2]
        off = np.linalg.norm(centres(blobs)[:, None] - project(camera, at), axis=2)
        return list(compress(blobs, (off > radius).all(axis=1)))

    def _left(
        self, near: Mapping[int, Array], free: NDArray[np.bool_], blobs: Sequence[Blob], seen: Collection[int]
    ) -> LeftOver:
        """Each component's nearest blob, none of them twice. :param near: as of `_near`. :param free: (B,)."""
        free, found = free.copy(), dict[int, Blob]()
        for c, off in near.items():
            here = int(np.argmin(np.where(free, off, np.inf)))
            if free[here] and np.isfinite(off[here]):
                found[c], free[here] = blobs[here], False
        return LeftOver(found, self._spare(frozenset(seen))) if found else _NOTHING

    def _spare(self, seen: frozenset[int]) -> float:
        """By how many numbers the places of what is seen tell more than a pose and the joints between them have; where
        another side would show the same, no more than what tells these sides apart: all marks of one plate together
        say nothing of which plate it is."""
        if seen not in self._spares:
            free, moves = pose_numbers(facing=self._finder.facing), self._kin.moves[list(seen)]
            between = (moves.any(axis=0) & ~moves.all(axis=0)).sum()
            told, *apart = (self._numbers[list(s)].sum() for s in (seen, *self._finder.like_sides.told_apart_by(seen)))
            self._spares[seen] = float(min([told - free - between, *apart]))
        return self._spares[seen]


def in_doubt_of(finder: WholeObjectFinder, detection: Detection, left: LeftOver) -> Detection:
    """A detection as sure as its pose is by what it leaves unexplained, which it says of the components it lacks.

    Where its pose is wrong, who knows its joints' limits knows no more of them.
    """
    share, kin = left.share(finder.config), finder.surface.kinematics
    if not left.blobs:
        return detection
    most = dict(zip(finder.target.model.joint_names, (kin.upper - kin.lower) / np.sqrt(12), strict=True))
    deviations = {
        name: float(min(np.sqrt(deviation**2 + (1 - share) * most[name] ** 2), most[name]))
        for name, deviation in detection.joint_deviations.items()
    }
    names = [c.name for c in finder.target.model.components]
    at = {names[c]: blob.middle.tolist() for c, blob in left.blobs.items()}
    lacks = tuple(
        Missing(m.component, "elsewhere", *at[m.component]) if m.component in at else m for m in detection.missing
    )
    score = detection.score * share
    return replace(
        detection, score=score, as_told=detection.as_told * share, joint_deviations=deviations, missing=lacks
    )
