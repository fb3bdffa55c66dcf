"""Which of several readings of the same blobs an object is: one that leaves fewer of them to clutter.

Votes count what a pose explains, and nothing what it leaves: two of three like balls, laid on two parts of an object
with its third one out of the picture, have as many as all three of which one lies a little beside its place. But what
is left must then be clutter, and lie by chance where the object has a part if it is laid otherwise. That is as
improbable as there is little clutter elsewhere in the image, and as the places are few where the part would be taken
for seen; as in `chance.py`, of which these are the numbers. What is not seen where a pose has it may be a little
farther off, for lengths are; a joint that moves nothing else that is seen may have any value.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import compress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.blobs import Blob, centres
from ..image.image_frame import ImageFrame
from ..image.label_field import LabelField
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from .chance import Blobs, Chances, explains
from .claims import left_by, unexplained
from .judge import Judge
from .verdicts import Verdict, Verdicts

_LEAST = 1e-4  # of a probability, and of its complement
_BEFORE = 0.5  # blobs of clutter that are expected where none is seen (Jeffreys' prior of a Poisson rate)
_VALUES = 61  # of a joint that are tried
_Explained = dict[int, tuple[float, int]]


class Free(NamedTuple):
    """B blobs of a target's classes. :ivar middles: (B, 2). :ivar free: (B,) which ones nothing explains."""

    seen: Blobs
    middles: Array
    free: NDArray[np.bool_]


class Readings:
    """Those of one target's objects that face the camera."""

    def __init__(self, finder: WholeObjectFinder, judge: Judge, chances: Chances) -> None:
        surface = finder.surface
        self.finder, self._judge, self._chances = finder, judge, chances
        self._labels = {label for own in surface.labels for label in own}
        self._first = np.array([markers[0] for markers in surface.markers_of])
        self._radius = np.sqrt(surface.sides.blobs[1][self._first] / np.pi)
        bears = surface.may_show.astype(int)
        self._asked: tuple[LabelField, Sequence[Blob], tuple[Verdict, ...]] | None = None  # of which `_free` is
        self._free: Free | None = None
        self.any = bool(np.triu(bears @ bears.T, 1).any())  # what is seen may be another part

    def free(self, accepted: Sequence[Verdict], frame: ImageFrame, blobs: Sequence[Blob]) -> Free | None:
        """None: none is that may be a part of one of this target's objects. Asked of the same again, as where objects
        that were found are described, it is not worked out again.

        :param accepted: objects of all targets. :param blobs: of the frame.
        """
        field, seen, objects = (None, None, ()) if self._asked is None else self._asked
        if field is not frame.field or seen is not blobs or objects != tuple(accepted):
            self._free, self._asked = self._left_free(accepted, frame, blobs), (frame.field, blobs, tuple(accepted))
        return self._free

    def _left_free(self, accepted: Sequence[Verdict], frame: ImageFrame, blobs: Sequence[Blob]) -> Free | None:
        """See `free`."""
        accepted = self._telling(accepted)
        mine = [v for v in accepted if v.finder is self.finder and not all(v.confirmed)]  # others explain all they can
        own = [b for b in blobs if b.label in self._labels] if self.any and mine else []
        if not own:
            return None
        seen, middles = Blobs.of(own), centres(own)
        near = np.any([self._near(frame, v, seen, middles) for v in mine], axis=0)
        if not near.any():
            return None
        left, explained = left_by(frame, [v.claim for v in accepted]), self.finder.config.search.explained
        if not unexplained(left, list(compress(own, near)), explained).any():
            return None
        like = np.any([self._as_large(seen, v.claim.scale).any(axis=0) for v in mine], axis=0)
        like[like] = unexplained(left, list(compress(own, like)), explained)
        return Free(seen, middles, like)

    def better(
        self, poses: Poses, accepted: Sequence[Verdict], frame: ImageFrame, blobs: Sequence[Blob]
    ) -> Poses | None:
        """Candidates without those that are worse readings of what an accepted object lies on than another one; None:
        there are no such, or no time is left to find them.

        :param poses: all candidates. :param accepted: objects of all targets. :param blobs: of the frame.
        """
        left = self.free(accepted, frame, blobs)
        if left is None:
            return None
        accepted = self._telling(accepted)
        mine = [v for v in accepted if v.finder is self.finder and not all(v.confirmed)]
        kept, more = np.ones(len(poses), bool), list[Poses]()
        hit = self._hit(frame, poses, left.seen)
        for verdict in mine:
            if frame.deadline.expired:
                break
            own = self._hit(frame, verdict.poses, left.seen)[0] & ~left.free
            others = ~left.free & ~own
            rows = np.flatnonzero((hit & own).any(axis=1) & ~(hit & others).any(axis=1))
            look = left_by(frame, [v.claim for v in accepted if v is not verdict])
            worse, best = self._worse(Poses.concatenate([verdict.poses, poses[rows]]), look, left, ~others)
            kept[rows[worse[1:]]] = False
            if worse.any():
                more.append(best)
        return Poses.concatenate([poses[np.flatnonzero(kept)], *more]) if more else None

    def _near(self, frame: ImageFrame, verdict: Verdict, seen: Blobs, middles: Array) -> NDArray[np.bool_]:
        """(B,) which blobs are as large as a component of an object, and no farther from what it lies on than that can
        be."""
        at, scale = self._at(frame, verdict.poses)[0, list(verdict.confirmed)], verdict.claim.scale
        off = np.linalg.norm(middles[:, None] - at, axis=2).max(axis=1, initial=0.0)
        return self._as_large(seen, scale).any(axis=0) & (off <= self.finder.apart.farthest_px(scale))

    def _telling(self, accepted: Sequence[Verdict]) -> list[Verdict]:
        """Objects that explain what they lie on: of what occurs once no more than there are."""
        told, names = [v for v in accepted if explains(v)], self.finder.alternatives
        most = max(len(names.identities), 1) if names.unique else len(told)
        mine = [v for v in told if v.finder is self.finder][:most]
        return [v for v in told if v.finder is not self.finder or v in mine]

    def log_odds(self, verdict: Verdict, poses: Poses, left: Free) -> Array:
        """(H,) of each of some poses of an accepted object against the first one, by what they leave to clutter."""
        its = left.free | self._hit(verdict.claim.frame, verdict.poses, left.seen)[0]
        by_chance = self._read(poses, self._judge.verdicts(self.finder, poses, verdict.claim.frame), left, its)[1]
        return np.asarray(by_chance[0] - by_chance)

    def _hit(self, frame: ImageFrame, poses: Poses, seen: Blobs) -> NDArray[np.bool_]:
        """(H, B) which blobs lie where poses have components of their classes."""
        at = self._at(frame, poses)[:, :, None]
        inside = ((at >= seen.low) & (at <= seen.high)).all(axis=3)
        return np.asarray((inside & self.finder.surface.may_show.take(seen.label, axis=1)).any(axis=1))

    def _at(self, frame: ImageFrame, poses: Poses) -> Array:
        """(H, C, 2) pixels of the components' middles."""
        return project(frame.camera, self.finder.through_middles.places(poses, self._first))

    def _worse(
        self, poses: Poses, frame: ImageFrame, left: Free, its: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], Poses]:
        """(n,) which readings of what one object lies on, of which the first is told, are worse than the best one, and
        that. :param its: (B,) blobs that it lies on, and free ones."""
        verdicts = self._judge.verdicts(self.finder, poses, frame)
        bent = self._bent(poses, verdicts, left, its)
        n, poses = len(poses), Poses.concatenate([poses, bent])
        verdicts = self._judge.verdicts(self.finder, poses, frame) if len(bent) else verdicts
        probability, accepts = self._probable(verdicts)
        count, by_chance = self._read(poses, verdicts, left, its)
        odds = np.where(accepts, np.log(probability) - np.log1p(-probability) - by_chance, -np.inf)
        best = int(np.argmax(odds))
        better = count[best] > count[0] and odds[best] > odds[0]
        return np.asarray((odds < odds[best])[:n] & better), poses[best : best + 1]

    def _bent(self, poses: Poses, verdicts: Verdicts, left: Free, its: NDArray[np.bool_]) -> Poses:
        """Those with joints that move nothing confirmed, where these bring what they carry nearest to blobs."""
        kin, confirmed = self.finder.surface.kinematics, np.asarray(verdicts.confirmed, bool)
        moved = np.asarray((confirmed[:, :, None] & kin.moves).any(axis=1))
        loose: NDArray[np.bool_] = np.asarray(confirmed.any(axis=1, keepdims=True) & ~moved)  # (H, J)
        rows = np.flatnonzero(loose.any(axis=1))
        bent, q, at = poses[rows], poses.q[rows].copy(), self._at(verdicts.claims.frame, poses[rows])[:, :, None]
        lain_on = ((at >= left.seen.low) & (at <= left.seen.high)).all(axis=3) & confirmed[rows, :, None]
        may_show = self.finder.surface.may_show.take(left.seen.label, axis=1)
        may = np.asarray(may_show & its & ~lain_on.any(axis=1, keepdims=True))
        for j in range(kin.n_joints):
            mine = np.flatnonzero(loose[rows, j])
            if not len(mine):
                continue
            values = np.linspace(kin.lower[j], kin.upper[j], _VALUES)
            tried = np.repeat(q[mine], _VALUES, axis=0)
            tried[:, j] = np.tile(values, len(mine))
            every = np.repeat(mine, _VALUES)
            at = self._at(verdicts.claims.frame, Poses(bent.R[every], bent.t[every], tried))
            off = np.linalg.norm(at[:, :, None] - left.middles, axis=3)
            off = np.where(may[every] & kin.moves[:, j, None], off, np.inf).min(axis=(1, 2)).reshape(len(mine), _VALUES)
            q[mine, j] = np.where(np.isfinite(off.min(axis=1)), values[off.argmin(axis=1)], q[mine, j])
        return Poses(bent.R, bent.t, q)

    def _probable(self, verdicts: Verdicts) -> tuple[Array, NDArray[np.bool_]]:
        """(H,) how probable each is, as it looks or with markers that look larger, and which are objects."""
        probability, accepts = verdicts.probability.copy(), self._judge.accepts(verdicts)
        for again, worth, _ in self._judge.swollen(verdicts):
            probability = np.where(worth > 0, np.maximum(probability, again.probability), probability)
            accepts |= worth > 0
        return np.clip(probability, _LEAST, 1 - _LEAST), accepts

    def _read(
        self, poses: Poses, verdicts: Verdicts, left: Free, its: NDArray[np.bool_]
    ) -> tuple[NDArray[np.int64], Array]:
        """(H,) how many components each explains, and the logarithm of how often clutter lies so by chance."""
        frame, scales, at = (
            verdicts.claims.frame,
            verdicts.claims.scale.tolist(),
            self._at(verdicts.claims.frame, poses),
        )
        explains = [self._explained(verdicts[h].confirmed, s, at[h], left, its) for h, s in enumerate(scales)]
        of_free = max(sum(left.free[b] for _, b in parts.values() if b >= 0) for parts in explains)
        rate = (_BEFORE + max(int(left.free.sum()) - of_free, 0)) / float(np.prod(frame.size))
        by_chance = [self._by_chance(parts, s, rate) for parts, s in zip(explains, scales, strict=True)]
        return np.array([len(parts) for parts in explains]), np.array(by_chance)

    def _explained(
        self, confirmed: Sequence[bool], scale: float, at: Array, left: Free, its: NDArray[np.bool_]
    ) -> _Explained:
        """By component how far from where a pose has it the blob is that it explains, pixels, and which one; what is
        confirmed on none lies on one together with others: -1. :param at: (C, 2)"""
        shown = [c for c, yes in enumerate(confirmed) if yes]
        off = np.linalg.norm(at[:, None] - left.middles, axis=2)  # (C, B)
        within = self.finder.apart.off_px(shown, scale)[:, None]
        may = self.finder.surface.may_show.take(left.seen.label, axis=1) & its & self._as_large(left.seen, scale)
        near = np.where(may & (off <= within), off / within, np.inf)
        out = {c: (0.0, -1) for c in shown}
        while np.isfinite(near.min(initial=np.inf)):
            c, b = divmod(int(np.argmin(near)), near.shape[1])
            out[c] = float(off[c, b]), b
            near[c], near[:, b] = np.inf, np.inf
        return out

    def _as_large(self, seen: Blobs, scale: float) -> NDArray[np.bool_]:
        """(C, B) which blobs are about as large as each component."""
        share = seen.area_px / (np.pi * np.square(self._radius * scale))[:, None]
        ratio = self.finder.config.verdict.left_over_ratio
        return np.asarray((share <= ratio) & (share >= 1 / ratio))

    def _by_chance(self, parts: _Explained, scale: float, rate: float) -> float:
        """Logarithm of how many places like these clutter makes beside a first one. :param rate: of its blobs a
        pixel."""
        if not parts:
            return 0.0
        first = self.finder.root if self.finder.root in parts else min(parts)
        off = [max(d, self._radius[c] * scale) for c, (d, _) in parts.items() if c != first]
        ways = self._chances.ways(tuple(sorted(parts)))
        return float(np.log(ways) + np.minimum(np.log(rate * np.pi * np.square(off)), 0.0).sum())
