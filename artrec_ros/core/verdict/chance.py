"""How many objects like one that is told chance makes of an image's blobs, and how much less sure that makes it.

The curves of `acceptance.py` are fitted on images with few things of the objects' classes in them. Where many like
patches lie about, some lie by chance as an object's components do: the more the more there are, and the fewer the more
components are confirmed. This is the number of false alarms of the a contrario method (A. Desolneux, L. Moisan, J.-M.
Morel, "Meaningful alignments", IJCV 40(1), 2000): how many places there are to try, times the probability that all
components have something like them there.

Blobs that other objects explain are none that chance could take, as far as these are sure: robots side by side do not
make each other doubtful. One of which a single component is seen explains nothing: chance may have made as many of
these as there are blobs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from .verdicts import Verdict


class Blobs(NamedTuple):
    """B blobs.

    :param label, area_px: (B,). :param low, high: (B, 2) corners of their bounding boxes, pixels.
    """

    label: NDArray[np.int64]
    area_px: Array
    low: NDArray[np.int64]
    high: NDArray[np.int64]

    @classmethod
    def of(cls, blobs: Sequence[Blob]) -> Blobs:
        low, high = np.stack([b.box for b in blobs], axis=1)
        return cls(np.array([b.label for b in blobs]), np.array([b.area_px for b in blobs]), low, high)


class Chances:
    """Of one target's objects that face the camera."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._turns = finder, dict[tuple[int, ...], float]()

    def times(
        self, verdicts: Sequence[Verdict], frame: ImageFrame, blobs: Sequence[Blob], among: Sequence[Verdict]
    ) -> Array:
        """(H,) how many times as easily chance bears out each object here as where nothing is like its components.

        :param blobs: of the frame. :param among: all its objects, these too.
        """
        share = self._finder.config.verdict.chance_share
        return np.asarray(1 + share * self.expected(verdicts, frame, blobs, among))

    def expected(
        self, verdicts: Sequence[Verdict], frame: ImageFrame, blobs: Sequence[Blob], among: Sequence[Verdict]
    ) -> Array:
        """(H,) how many objects with the same components confirmed chance makes of the blobs that are left to it, each
        component within its marker's size of where it should be. None of what has one component: its looks alone say
        what it is."""
        if not len(blobs) or not len(verdicts) or len(self._finder.surface.labels) == 1:
            return np.zeros(len(verdicts))
        seen = Blobs.of(blobs)
        explained, sure = _explained(among, frame, seen), np.array([_surety(v) for v in among])
        clutter = np.prod(1 - explained * sure[:, None], axis=0)
        own = {id(v): row for v, row in zip(among, explained, strict=True)}
        free = clutter * ~np.array([own[id(v)] for v in verdicts])
        return self._left_to(verdicts, free, seen, float(np.prod(frame.size)))

    def _left_to(self, verdicts: Sequence[Verdict], free: Array, seen: Blobs, frame_px: float) -> Array:
        """`expected` of H objects. :param free: (H, B) how far each blob is left to chance."""
        confirmed, root = np.array([v.confirmed for v in verdicts]), self._finder.root
        scale = np.array([v.among.claims.scale[v.row] for v in verdicts])
        shown = np.array([v.shown for v in verdicts])
        area_px = self._finder.surface.sides.blobs[1][shown] * scale[:, None] ** 2  # (H, C)
        ratio = self._finder.config.verdict.left_over_ratio
        like = (seen.area_px < ratio * area_px[..., None]) & (ratio * seen.area_px > area_px[..., None])
        count = np.einsum("hcb,hb->hc", like & _bears(self._finder, seen), free)
        rows, first = np.arange(len(count)), np.where(confirmed[:, root], root, confirmed.argmax(axis=1))
        covered = np.where(confirmed, np.pi * area_px * count / frame_px, 1.0)
        covered[rows, first] = 1.0  # what chance takes for it is where the others are sought
        ways = [self.ways(tuple(np.flatnonzero(own).tolist())) for own in confirmed]
        return np.asarray(count[rows, first] * ways * covered.prod(axis=1))

    def ways(self, confirmed: tuple[int, ...]) -> float:
        """In how many ways an object with one of these components in its place can be turned and bent, as far as others
        of them are a marker's size from where they were; in none without one."""
        if not confirmed:
            return 0.0
        if confirmed not in self._turns:
            self._turns[confirmed] = _ways(self._finder, np.array(confirmed))
        return self._turns[confirmed]


def _ways(finder: WholeObjectFinder, confirmed: NDArray[np.int64]) -> float:
    """See `Chances.ways`."""
    surface, kin = finder.surface, finder.surface.kinematics
    first = finder.root if finder.root in confirmed else int(confirmed[0])
    others = confirmed[confirmed != first]
    if not len(others):
        return 1.0
    middle, area = surface.sides.blobs
    shows = np.array([surface.markers_of[c][0] for c in range(len(surface.labels))])
    frames, step = kin.in_object(kin.middle[None]), 2 * np.sqrt(area[shows])
    at = surface.place(frames, middle[shows], np.arange(len(shows)))[0]
    moved = kin.moves[others] != kin.moves[first]
    fixed = others[~moved.any(axis=1)] if not moved.any(axis=1).all() else others
    ways = 1 + float((2 * np.pi * np.linalg.norm(at[fixed] - at[first], axis=1) / step[fixed]).max())
    for j in np.flatnonzero(moved.any(axis=0)).tolist():
        mine = others[moved[:, j]]
        arm = np.linalg.norm(at[mine] - frames.origin[0, j], axis=1) if kin.revolute[j] else np.ones(len(mine))
        ways *= 1 + float((arm / step[mine]).max() * (kin.upper[j] - kin.lower[j]))
    return ways


def _bears(finder: WholeObjectFinder, seen: Blobs) -> NDArray[np.bool_]:
    """(C, B) which blobs are of a class of which each component may be."""
    return finder.surface.may_show.take(seen.label, axis=1)


def explains(verdict: Verdict) -> bool:
    """Whether an object explains what it lies on: one of several components may be anything like it."""
    return sum(verdict.confirmed) > 1 or len(verdict.confirmed) == 1


def _surety(verdict: Verdict) -> float:
    """How sure it is that what an object explains is no clutter."""
    return verdict.probability if explains(verdict) else 0.0


def _explained(among: Sequence[Verdict], frame: ImageFrame, seen: Blobs) -> NDArray[np.bool_]:
    """(A, B) which blobs lie where objects have components of their classes."""
    out = np.zeros((len(among), len(seen.label)), bool)
    for finder in dict.fromkeys(v.claim.finder for v in among):
        rows = [n for n, v in enumerate(among) if v.claim.finder is finder]
        out[rows] = _explained_by(finder, [among[n] for n in rows], frame, seen)
    return out


def _explained_by(
    finder: WholeObjectFinder, verdicts: Sequence[Verdict], frame: ImageFrame, seen: Blobs
) -> NDArray[np.bool_]:
    """(H, B) the same by one target's, be the component confirmed or not: what shows one badly is no other one's."""
    surface, poses = finder.surface, Poses.concatenate([v.claim.poses for v in verdicts])
    frames = surface.kinematics.seen(poses.R, poses.t, poses.q)
    at = project(frame.camera, surface.place(frames, surface.sides.blobs[0], surface.component))
    shown, first = np.array([v.shown for v in verdicts]), [markers[0] for markers in surface.markers_of]
    at = at[np.arange(len(at))[:, None], np.where(shown < 0, first, shown)][:, :, None]
    inside = (at >= seen.low) & (at <= seen.high)  # of x and of y
    return np.asarray((inside[..., 0] & inside[..., 1] & _bears(finder, seen)).any(axis=1))


def beyond_chance(score: float, times: float) -> float:
    """The share of an object's probability that is left where chance bears it out so many times as easily; its
    components are as much less sure."""
    return 1 / (score + (1 - score) * times)
