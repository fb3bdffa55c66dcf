"""On which of several blobs a component lies that hangs on joints.

Of two like hands, both within the reach of a joint, one is told as if there were no other. Nothing else asks: it lies
on its marker, and what it leaves is looked at only where something is missing. So the component is laid on each other
blob of its class, about as large as its marker, that nothing explains and that it can reach, all else that is seen
staying where it is and what it carries going along; and what its joint carries there is compared with what it carries
as it is told.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import compress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.spread import spread
from ..geometry.transforms import Array, rotation_from_rotvec
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..model.kinematics import Frames
from ..pose.finder import WholeObjectFinder
from ..pose.other_bends import Bends, bend_evidence, with_carried
from ..pose.poses import Poses
from ..pose.surface_kernels import LEAST_DEPTH_M
from ..pose.through_middles import Middles
from .free_blobs import FreeBlobs, Sizes
from .verdicts import Verdict

_BENDS, _TURNS = 6, 48  # with which poses begin that have something elsewhere, as it is turned and turned otherwise
_MOST = 8  # blobs that an object's components are laid on, those nearest to their sizes: each takes some milliseconds


class OnOthers(NamedTuple):
    """What one object may show instead, by K blobs.

    :ivar bends: K poses, each with what the last of the joints that move one component carries on another blob.
    :ivar log_odds: (K,) that each is the true one, and not the one told. :ivar components: (K,) that lie on them.
    :ivar blobs: (K,)
    """

    bends: Bends
    log_odds: Array
    components: Sequence[int]
    blobs: Sequence[Blob]

    def shares(self, least: float) -> Array:
        """(K,) of each how probable it is, beside the one told and those of the same component or on the same blob.
        Likelier ones but a little are as likely. :param least: log odds of those that are clearly likelier."""
        worth, blobs = (
            np.exp(np.where(self.log_odds > least, self.log_odds, np.minimum(self.log_odds, 0.0))),
            [id(b) for b in self.blobs],
        )
        same = np.equal.outer(self.components, self.components) | np.equal.outer(blobs, blobs)
        return np.asarray(worth / (1 + same @ worth), np.float64)


class OtherBlobs:
    """Those of one target's objects."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._kin, self._free = finder, finder.surface.kinematics, FreeBlobs(finder)
        parts = range(len(self._kin.parent))
        self._last = [self._last_joint(c) for c in parts]  # of the joints that move each component; -1: none does
        self._labels = {label for c in parts if self._last[c] >= 0 for label in finder.surface.labels[c]}

    def of(
        self,
        shows: Sequence[ImageFrame],
        poses: Poses,
        seen: Sequence[Collection[int]],
        used: NDArray[np.bool_],
        frames: Frames,
        frame: ImageFrame,
        blobs: Sequence[Blob],
        among: Sequence[Verdict],
    ) -> list[OnOthers | None]:
        """Of H poses at rest; None: there are none.

        :param shows: in which frame each is looked at. :param seen: of each the components that are. :param used: (H,
            M) markers that the labels support. :param frames: where all components are. :param blobs: of the frame.
        :param among: all its objects.
        """
        out: list[OnOthers | None] = [None] * len(poses)
        at = self._finder.surface.place(frames, self._free.middle, self._free.of) if self._labels and blobs else None
        for h, (near, mine) in enumerate([] if at is None else self._in_reach(at, seen, used, frame, blobs, among)):
            if near and not frame.deadline.expired:
                out[h] = self._compared(shows[h].unhurried(), poses[h : h + 1], mine, near)
        return out

    def likelier(self, found: OnOthers | None, pose: Poses, known: Poses, camera: Camera) -> Poses | None:
        """What is to be told in place of a pose: what is clearly likelier, that it was told before being as clear;
        None: nothing is. :param known: where earlier frames have this target's objects."""
        if found is None:
            return None
        finder, least = self._finder, np.full(len(found.blobs), self._finder.config.verdict.least_turn_odds)
        known = known[np.flatnonzero(finder.required.is_at(known, pose))] if len(known) else known
        at, of = finder.on_likes.pixels(camera, Poses.concatenate([pose, known]))[0], self._free.of
        for n, (c, blob) in enumerate(zip(found.components, found.blobs, strict=True)) if len(known) else ():
            there, here = (np.linalg.norm(at[1:, of == c] - off, axis=2) for off in (blob.middle, at[0, of == c]))
            least[n] *= -2 if (there < here).any() else 2
        best = int(np.argmax(found.log_odds - least))
        return found.bends.poses[best : best + 1] if found.log_odds[best] > least[best] else None

    def _in_reach(
        self,
        at: Array,
        seen: Sequence[Collection[int]],
        used: NDArray[np.bool_],
        frame: ImageFrame,
        blobs: Sequence[Blob],
        among: Sequence[Verdict],
    ) -> Iterator[tuple[list[tuple[int, Blob]], NDArray[np.int64]]]:
        """Of each object components with blobs that they may lie on, and the rows of the markers that show it.

        :param at: (H, M, 3) middles of all markers.
        """
        shown = used & np.array([np.isin(self._free.of, list(own)) for own in seen])
        pixels, scale = project(frame.camera, at), frame.camera.focal_px / np.maximum(at[..., 2], LEAST_DEPTH_M)
        mine = [b for b in blobs if b.label in self._labels]
        off = np.linalg.norm(Sizes.of(mine).middles.reshape(-1, 1, 1, 2) - pixels, axis=3)
        beside = ~((off < np.sqrt(self._free.area / np.pi) * scale) & shown).any(axis=(1, 2))
        mine, within = list(compress(mine, beside)), self._finder.apart.farthest_px(float(scale.max()))
        close = ((off[beside] <= within) | ~shown).all(axis=2).any(axis=0)  # (H,) whether any may be in reach
        if not close.any():
            return
        sizes = Sizes.of(mine)
        near = [self._near(at[h], sorted(own), frame, sizes) if close[h] else {} for h, own in enumerate(seen)]
        asked = np.zeros(len(mine), bool)
        for off in (off for by_component in near for off in by_component.values()):
            asked |= np.isfinite(off)
        free = self._free.unexplained(frame, mine, asked, among)
        for h, by_component in enumerate(near):
            pairs = [
                (c, b) for c, off in by_component.items() for b in np.flatnonzero(free & np.isfinite(off)).tolist()
            ]
            pairs.sort(key=lambda pair: self._unlike(pair[0], scale[h], sizes.area_px[pair[1]]))
            yield [(c, mine[b]) for c, b in pairs[:_MOST]], np.flatnonzero(shown[h])

    def _near(self, at: Array, seen: Sequence[int], frame: ImageFrame, sizes: Sizes) -> dict[int, Array]:
        """As of `FreeBlobs.near`, of components that are seen, by those that their last joint does not move."""
        out = dict[int, Array]()
        for j in sorted({self._last[c] for c in seen} - {-1}):
            stay = [c for c in seen if not self._kin.moves[c, j]]
            if stay:
                moved = [c for c in seen if self._last[c] == j]
                out.update(self._free.near(moved, stay, at, frame.camera, sizes))
        return out

    def _unlike(self, component: int, scale: Array, area_px: float) -> float:
        """How far a blob's size is from what one of a component's markers would show here."""
        size_px = (self._free.area * scale**2)[self._free.of == component]
        return float(np.abs(np.log(area_px / np.maximum(size_px, 1e-9))).min())

    def _compared(
        self, frame: ImageFrame, pose: Poses, shown: NDArray[np.int64], near: Sequence[tuple[int, Blob]]
    ) -> OnOthers | None:
        """:param shown: rows of the markers that are seen of it."""
        laid = [self._laid(frame, pose, shown, c, blob) for c, blob in near]
        of = np.repeat(np.arange(len(near)), [len(others) for others in laid])
        if not len(of):
            return None
        finder, joints = self._finder, np.array([self._last[c] for c, _ in near])
        begun = Bends(Poses.concatenate(laid), np.zeros(len(of), int), joints[of], np.zeros(len(of)))
        again = finder.looked_again(frame, with_carried(finder, frame, begun).poses)
        both = Poses.concatenate([pose, again.poses])
        both = finder.rest.at_rest(frame, both, finder.voter.supports(frame, both))
        votes, others = finder.voter.votes(frame, both, occlusion=True), both[1:]
        may_be = votes[1:] > finder.config.verdict.mirrored_votes * votes[0]
        may_be &= frame.scene.stand(others.R, others.t)
        kept, on = self._on(frame, others, np.where(may_be, votes[1:], 0.0), near)
        if not kept:
            return None
        bends = Bends(others[kept], np.zeros(len(kept), int), joints[on], np.zeros(len(kept)))
        weights = finder.config.verdict.differing_odds[2:]  # as of other values of joints
        odds = bend_evidence(finder, frame, both[:1], bends).log_odds((0.0, *weights))
        return OnOthers(bends, odds, [near[n][0] for n in on], [near[n][1] for n in on])

    def _laid(self, frame: ImageFrame, pose: Poses, shown: NDArray[np.int64], component: int, blob: Blob) -> Poses:
        """Poses with a component on a blob and what its last joint does not move where it is: bent alone, or else
        turned about it, too; none where there is no such."""
        through, kin, of, markers = self._finder.through_middles, self._kin, self._free.of, self._finder.surface.markers
        own, stay = np.flatnonzero(of == component)[:1], shown[~kin.moves[of[shown], self._last[component]]]
        at = through.places(pose, markers[stay])[0]
        middles = Middles(
            markers[np.append(stay, own)],
            np.concatenate([project(frame.camera, at), blob.middle[None]]),
            np.append(frame.camera.focal_px / at[:, 2], np.sqrt(blob.area_px / self._free.area[own])),
        )
        free = np.flatnonzero(kin.moves[component] & ~kin.moves[of[stay]].any(axis=0))
        anchor = self._finder.required.anchors(pose)[0]
        for n, turn in (_BENDS, 0.0), (_TURNS, 2 * np.pi):
            even, q = spread(n, 1 + len(free)), np.repeat(pose.q, n, axis=0)
            q[:, free] = kin.lower[free] + (kin.upper - kin.lower)[free] * even[:, 1:]
            turns = rotation_from_rotvec(turn * even[:, :1] * pose.R[0, :, 2])
            starts = Poses(turns @ pose.R, anchor + turns @ (pose.t[0] - anchor), q)
            others = through.begun(frame.camera, starts, middles, held=True)
            if len(others):
                break
        return self._finder.climber.within_limits(frame.camera, others)

    def _on(
        self, frame: ImageFrame, poses: Poses, votes: Array, near: Sequence[tuple[int, Blob]]
    ) -> tuple[list[int], list[int]]:
        """Rows of those of some poses that have most votes of all with a component on a blob; and of which of these."""
        kept, of = list[int](), list[int]()
        pixels = self._finder.on_likes.pixels(frame.camera, poses)[0]
        for n, (c, blob) in enumerate(near):
            off = np.linalg.norm(pixels[:, self._free.of == c] - blob.middle, axis=2).min(axis=1)
            mine = np.where(off < np.sqrt(blob.area_px / np.pi), votes, 0.0)
            if mine.max() > 0:
                kept.append(int(mine.argmax()))
                of.append(n)
        return kept, of

    def _last_joint(self, component: int) -> int:
        while component >= 0 and self._kin.joint_of[component] < 0:
            component = self._kin.parent[component]
        return self._kin.joint_of[component] if component >= 0 else -1
