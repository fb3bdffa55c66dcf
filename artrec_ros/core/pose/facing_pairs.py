"""First hypotheses of objects that face the camera from two blobs each: the required marker, and another far from it.

A small blob's pixels tell its scale no better than to half a step of those that are tried, and its direction no better,
a disc's none: markers many radii away lie beside their blobs then. A fit to the contour of a larger one is as exact as
its outline in the file, be the image ever so sharp. The middles of two blobs tell place, turn and scale at once, and
the better the farther they are from each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import comb

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.range_limits import ScaleLimits
from ..geometry.transforms import Array
from ..image.blobs import Blob, centres
from ..image.image_frame import ImageFrame
from ..model.marker import Marker
from .facing_guesses import FacingGuesser
from .finder import WholeObjectFinder
from .poses import Poses
from .ranked import first_of_each

_AT_ONCE = 16  # blobs between two looks at the clock
_MOST = 128  # pairs of one blob that are looked at: bounds the time in crowds, where few are right


class FacingPairs:
    """Takes a blob for the required component, and another for each marker that no joint moves against it and that is
    so far out that half a step of the scale moves it by more than its own radius. Of what has an outline amid so many
    like blobs that chance makes most pairs only those on which other markers lie as seldom by chance."""

    def __init__(self, finder: WholeObjectFinder, guesser: FacingGuesser, config: RecognizerConfig, keep: int) -> None:
        """:param guesser: of the required component. :param keep: hypotheses of each blob that go on."""
        self._surface, self._guesser, self._keep = finder.surface, guesser, keep
        self._none = finder.surface.no_poses, np.zeros(0, np.int64)
        self._outlined, self._most = not finder.target.model.needs_another, config.facing.most_pairs
        surface, fixed, off_scale = finder.surface, _fixed(finder), np.sqrt(config.facing.scale_ratio) - 1
        self._labels, self._markers, arms = list[Sequence[int]](), list[Marker](), list[Array]()
        for p, marker, at in fixed:
            arm = guesser.in_view(at)
            if np.linalg.norm(arm) * off_scale > marker.radius:
                arms.append(arm)
                self._labels.append(surface.labels[surface.component[p]])
                self._markers.append(marker)
        self._arms = np.array(arms).reshape(-1, 2)
        rigid = surface.component[[p for p, _, _ in fixed]]
        self._patches = np.flatnonzero(np.isin(surface.component, rigid))
        others = rigid != finder.root
        self._around = np.array([guesser.in_view(at) for _, _, at in fixed])[others]
        self._may_show = surface.may_show[rigid[others]]

    def guess(
        self, frame: ImageFrame, mine: Sequence[Blob], blobs: Sequence[Blob], limits: ScaleLimits
    ) -> tuple[Poses, NDArray[np.int64]]:
        """The best of each of `mine` by the votes for all that no joint moves, and of which each is (H,).

        :param mine: blobs that the required component may have made. :param blobs: among which their partners are.
        :param limits: of the scale.
        """
        if not len(self._arms) or not mine:
            return self._none
        found, of = [self._none[0]], [self._none[1]]
        own, others = self._guesser.scales(frame, mine, limits), self._scales_of_others(frame, blobs, limits)
        here, there = centres(mine), centres(blobs)
        parts = list(frame.deadline.parts(len(mine), _AT_ONCE))
        pairs = [self._pairs(here[part], there, own[part], others) for part in parts]
        if self._outlined and sum(len(T) for T, _ in pairs) > self._most:
            pairs = self._borne_out(frame, pairs)
        for part, (T, which) in zip(parts, pairs, strict=True):
            poses = self._guesser.lifted(T, frame)
            votes = self._surface.score(frame, poses, self._patches, occlusion=False).votes.sum(axis=1)
            best = first_of_each(which, votes, self._keep)
            found.append(poses[best])
            of.append(part.start + which[best])
        return Poses.concatenate(found), np.concatenate(of)

    def _borne_out(
        self, frame: ImageFrame, pairs: Sequence[tuple[Array, NDArray[np.int64]]]
    ) -> list[tuple[Array, NDArray[np.int64]]]:
        """Those of many pairs under which so many more markers lie on pixels of their classes as chance, which makes
        most of them, brings about less than once."""
        on = [self._on_their_classes(frame, T) for T, _ in pairs]
        every, others = np.concatenate(on), len(self._around) - 1
        share = max(float(every.mean()) - 1, 0) / max(others, 1)  # one is the pair's own
        exactly = [comb(others, k) * share**k * (1 - share) ** (others - k) for k in range(others + 1)]
        least = 1 + sum(len(every) * sum(exactly[k:]) >= 1 for k in range(others + 1))
        return [(T[n >= least], which[n >= least]) for (T, which), n in zip(pairs, on, strict=True)]

    def _on_their_classes(self, frame: ImageFrame, T: Array) -> NDArray[np.int64]:
        """(n,) how many markers about the required component have their middles on pixels of their classes."""
        c, s = np.cos(T[:, 2:3]), np.sin(T[:, 2:3])
        x, y = self._around.T
        u = np.rint(T[:, :1] + T[:, 3:] * (c * x - s * y)).astype(np.int64)
        v = np.rint(T[:, 1:2] + T[:, 3:] * (s * x + c * y)).astype(np.int64)
        labels = frame.field.labels
        height, width = labels.shape
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        label = labels[np.clip(v, 0, height - 1), np.clip(u, 0, width - 1)]
        return np.asarray((inside & self._may_show[np.arange(len(x)), label]).sum(axis=1))

    def _scales_of_others(self, frame: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits) -> Array:
        """(A, B, 2) least and greatest scale of each marker in each blob; none where its class is another one."""
        label = np.array([b.label for b in blobs])
        out = np.array([self._guesser.scales(frame, blobs, limits, m) for m in self._markers])
        for scales, labels in zip(out, self._labels, strict=True):
            scales[~np.isin(label, labels)] = np.inf, 0.0
        return out

    def _pairs(self, here: Array, there: Array, own: Array, others: Array) -> tuple[Array, NDArray[np.int64]]:
        """Alignments (n, 4: x, y, turn, scale) of the required component, and with which of N blobs each is (n,).

        :param here: (N, 2) these blobs' middles. :param there: (B, 2) others'. :param own: (N, 2) scales.
        :param others: (A, B, 2) likewise.
        """
        way = there - here[:, None]
        scale = np.linalg.norm(way, axis=2)[:, None] / np.linalg.norm(self._arms, axis=1)[:, None]
        least = np.maximum(own[:, None, None, 0], others[..., 0])
        most = np.minimum(own[:, None, None, 1], others[..., 1])
        n, a, b = np.nonzero((scale >= least) & (scale <= most))
        # in crowds those go on whose scale is most like what the disc's pixels tell
        unlike = np.abs(np.log(scale[n, a, b] ** 2 / own[n].prod(axis=1)))
        kept = first_of_each(n, -unlike, _MOST)
        n, a, b = n[kept], a[kept], b[kept]
        turn = np.arctan2(way[n, b, 1], way[n, b, 0]) - np.arctan2(self._arms[a, 1], self._arms[a, 0])
        return np.column_stack([here[n], turn, scale[n, a, b]]), n


def _fixed(finder: WholeObjectFinder) -> list[tuple[int, Marker, Array]]:
    """Markers that no joint moves against the required component, with their patches, and where they are (3,) in the
    object's frame with joints mid-range."""
    surface, kin = finder.surface, finder.surface.kinematics
    at, out = kin.in_object(kin.middle[None]), []
    for p in surface.markers.tolist():
        marker, c = surface.patches[p].marker, surface.component[p]
        if marker is not None and (kin.moves[c] == kin.moves[finder.root]).all():
            out.append((p, marker, at.R[0, c] @ marker.centre + at.t[0, c]))
    return out
