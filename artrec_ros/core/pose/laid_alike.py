"""Poses in which a rigid object has like markers where those are that are seen, and the others elsewhere.

Of a board of equal dots of which half is covered, what is seen may be this half or that, or what lies between them: all
have dots where some are seen, and nothing tells them apart but where the others would be. What another side shows in
the place of one is like_sides.py's.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from .layout import SAME_WAY, Layout, placed_markers
from .lookalikes import ALIKE_TURN, turns_alike
from .poses import Poses
from .surface_model import SpatialModel

_MOST = 63  # as likely ones: each of more would have less than what anything is told by
_AT_ONCE = 1024  # of moves, for what large boards take of memory
_MOST_KNOWN = 256  # sets of markers that are seen
_ACROSS = 0.1  # sine between a marker's normal and the way to another one, from which on both tell a turn


class _Moves(NamedTuple):
    """Of the object in its own frame. :ivar R, t: (K, 3, 3), (K, 3)."""

    R: Array
    t: Array


class LaidAlike:
    """Those of one object; none of one that has joints, for what lies on what depends on them."""

    def __init__(self, surface: SpatialModel) -> None:
        # of balls, too, which show one side in any turn
        none = surface.kinematics.n_joints > 0 or len(surface.sides.balls) > 0
        self._markers = every = [] if none else placed_markers(surface)
        self._layout, self._R = Layout(every), np.array([m.whole.rotation for m in every])
        kinds = {id(m.marker): n for n, m in enumerate(every)}
        self._kind = [kinds[id(m.marker)] for m in every]
        self._turns = dict[tuple[int, int], Array]()
        self._known = dict[bytes, _Moves]()

    def of(self, pose: Poses, seen: NDArray[np.bool_]) -> Poses:
        """K poses beside one; those after which all looks the same are one. :param seen: (M,) its markers that are."""
        if len(self._markers) < 3 or seen.all() or seen.sum() < 2:
            return pose[:0]
        key = seen.tobytes()
        if key not in self._known:
            if len(self._known) >= _MOST_KNOWN:
                self._known.pop(next(iter(self._known)))
            self._known[key] = self._moves(np.flatnonzero(seen))
        moves, (R,), (t,) = self._known[key], pose.R, pose.t
        return Poses(R @ moves.R, moves.t @ R.T + t, np.tile(pose.q, (len(moves.R), 1)))

    def _moves(self, seen: NDArray[np.int64]) -> _Moves:
        every, kept = np.arange(len(self._markers)), (np.eye(3)[None], np.zeros((1, 3)))
        for turn, shift in self._covering(seen):
            back = np.swapaxes(kept[0], 1, 2)
            onto = back @ turn, np.einsum("kij,kj->ki", back, shift - kept[1])
            if not self._layout.cover(*onto, every).any():
                kept = np.concatenate([kept[0], turn[None]]), np.concatenate([kept[1], shift[None]])
            if len(kept[0]) > _MOST:
                break
        return _Moves(kept[0][1:], kept[1][1:])

    def _covering(self, seen: NDArray[np.int64]) -> Iterator[tuple[Array, Array]]:
        """Those proposed that lay like markers on all that are seen."""
        R, t = self._proposed(seen)
        for begin in range(0, len(R), _AT_ONCE):
            some, shifts = R[begin : begin + _AT_ONCE], t[begin : begin + _AT_ONCE]
            on_like = np.flatnonzero(self._layout.cover(some, shifts, seen))
            yield from zip(some[on_like], shifts[on_like], strict=True)

    def _proposed(self, seen: NDArray[np.int64]) -> _Moves:
        """Moves that lay two markers on like ones that are seen: on those two of these that lie farthest apart."""
        layout, (i, j) = self._layout, self._farthest(seen)
        apart = np.linalg.norm(layout.at[:, None] - layout.at, axis=2)
        like = layout.same[:, i][:, None] & layout.same[:, j]
        p, q = np.nonzero(like & (np.abs(apart - apart[i, j]) < layout.near_m[i] + layout.near_m[j]))
        there, is_told = self._along(np.array([i]), np.array([j]))
        own, tell = self._along(p, q)
        R, normal = there @ np.swapaxes(own, 1, 2), layout.normal[seen]
        same_side = (np.einsum("kij,nj->kni", R, normal) * normal).sum(axis=2) > SAME_WAY
        kept = np.flatnonzero(tell & is_told & same_side.all(axis=1))
        kept = kept[[self._looks_alike(R[k], int(p[k]), i) for k in kept.tolist()]]
        middle, on = (layout.at[p[kept]] + layout.at[q[kept]]) / 2, (layout.at[i] + layout.at[j]) / 2
        return _Moves(R[kept], on - np.einsum("kij,kj->ki", R[kept], middle))

    def _farthest(self, seen: NDArray[np.int64]) -> tuple[int, int]:
        own = self._layout.at[seen]
        i, j = divmod(int(np.argmax(((own[:, None] - own) ** 2).sum(axis=2))), len(own))
        return int(seen[i]), int(seen[j])

    def _along(self, first: NDArray[np.int64], second: NDArray[np.int64]) -> tuple[Array, NDArray[np.bool_]]:
        """(N, 3, 3) frames: z is a first marker's normal, x lies towards a second one; and whether there is such."""
        z, way = self._layout.normal[first], self._layout.at[second] - self._layout.at[first]
        x = way - (way * z).sum(axis=1, keepdims=True) * z
        long, across = np.linalg.norm(way, axis=1), np.linalg.norm(x, axis=1)
        tell = across > _ACROSS * long
        x /= np.where(tell, across, 1.0)[:, None]
        return np.stack([x, np.cross(z, x), z], axis=2), tell

    def _looks_alike(self, R: Array, mine: int, there: int) -> bool:
        """Whether a marker, so turned, looks like the one in whose place it comes."""
        both, kinds = (self._markers[mine].marker, self._markers[there].marker), (self._kind[mine], self._kind[there])
        if all(m.disc_radius for m in both):
            return True
        if kinds not in self._turns:
            self._turns[kinds] = np.array(turns_alike(*both))
        x = self._R[there].T @ R @ self._R[mine][:, 0]
        return bool((np.cos(self._turns[kinds] - np.arctan2(x[1], x[0])) > np.cos(ALIKE_TURN)).any())
