"""Placements of flat objects that lay like markers where those lie that are seen, and the others where nothing shows.

Of three like discs one is hidden: the other two lie on a pair of others' places, or each in the other's place, as well
as in their own, and the hidden one is where it cannot be seen, or is not, in all of these. What tells them apart is
what is known of the hidden ones' places alone. So it is of a tool of which nothing but the tape around its shaft is
seen: that looks the same after half a turn.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from ..base.config import DesignConfig
from ..geometry.polygons import distance_to_outline
from ..model.surface import sample_contour
from .exchanges import OFF, SAME, STRETCH, Placements, may_be_taken_for
from .lookalikes import turns_onto_itself
from .surface_model import SpatialModel

_SAMPLES = 48  # of an outline
_SAME_SHARE = DesignConfig().same_share  # of its radius: a lone marker that differs by less is the same by its file
_MOST_TURNS = 12  # of a lone marker onto itself
_ALIKE = 0.15  # outlines that differ by less may be taken for each other: rms, as a share of the root of their area

_Points = NDArray[np.complex128]  # x + iy in the object's plane
_Rows = NDArray[np.int64] | list[int]


class SeenAlike:
    """Those of one object, by the components that are seen; of one with joints the turns of a lone one alone that no
    joint moves."""

    def __init__(self, surface: SpatialModel) -> None:
        markers, kin = surface.markers, surface.kinematics
        self._component, self._jointed = surface.component[markers], kin.n_joints > 0
        frames, patches = kin.in_object(kin.middle[None]), [surface.patches[p] for p in markers.tolist()]
        self._is_moved = kin.moves[self._component].any(axis=1)
        self._markers = [p.marker for p in patches]
        self._area, self._like = surface.area[markers], may_be_taken_for(surface, markers)
        drawn = [_plane(surface.place(frames, p.drawn, np.full(len(p.drawn), p.component))[0]) for p in patches]
        self._at = np.array([points[0] for points in drawn])
        self._outlines = [points[3:] - points[0] for points in drawn]
        self._known = dict[frozenset[int], Placements]()

    def of(self, seen: Collection[int]) -> Placements:
        """Those of an object of which these components are seen: none where all are, but of a lone marker."""
        key = frozenset(seen)
        if key not in self._known:
            self._known[key] = self._placements(np.flatnonzero(np.isin(self._component, list(key))))
        return self._known[key]

    def _placements(self, seen: NDArray[np.int64]) -> Placements:
        """:param seen: (S,) markers."""
        found, laid, alone = list[tuple[complex, complex]](), [self._at], len(self._at) == 1
        for turn, shift in self._ways(seen) if alone or len(seen) < len(self._at) else ():
            moved = turn * self._at + shift
            # of a marker that is all there is what tells its turns apart is its own outline, or nothing does
            differs = self._off(turn, 0, 0) >= SAME if alone else not any(self._is_same(moved, t) for t in laid)
            if differs:
                found.append((turn, shift))
                laid.append(moved)
        turns, shifts = np.array(found, complex).reshape(-1, 2).T
        same = [len(seen) == 1 and self._is_the_same(turn, seen[0]) for turn in turns.tolist()]
        return Placements(turns, shifts, same)

    def _ways(self, seen: NDArray[np.int64]) -> Iterator[tuple[complex, complex]]:
        """Turns and shifts that lay like markers on those that are seen; a lone one turned onto itself."""
        if len(seen) == 1:
            marker, at = self._markers[seen[0]], complex(self._at[seen[0]])
            turns = turns_onto_itself(marker) if marker is not None and not self._is_moved[seen[0]] else []
            turns = turns[:: -(-len(turns) // _MOST_TURNS)] if turns else []  # of what is nearly round
            yield from ((complex(turn), at - turn * at) for turn in np.exp(1j * np.array(turns)))
        for on in self._proposed(seen) if len(seen) > 1 and not self._jointed else ():
            turn, shift = _onto(self._at[on], self._at[seen])
            if self._lies_there(turn, turn * self._at + shift, seen, on):
                yield turn, shift

    def _proposed(self, seen: NDArray[np.int64]) -> list[list[int]]:
        """Which markers may come where the seen ones are: by the two of these that lie farthest apart, and each two
        markers that do so by as much."""
        own = self._at[seen]
        i, j = divmod(int(np.argmax(abs(own[:, None] - own))), len(own))
        out, far = list[list[int]](), abs(own[j] - own[i])
        for pair in permutations(range(len(self._at)), 2):
            ends = self._at[list(pair)]
            if abs(abs(ends[1] - ends[0]) - far) <= STRETCH * far:
                turn, shift = _onto(ends, own[[i, j]])
                on = abs(turn * self._at[:, None] + shift - own).argmin(axis=0)
                out.append(on.tolist())
        return out

    def _lies_there(self, turn: complex, moved: _Points, seen: NDArray[np.int64], on: list[int]) -> bool:
        """Whether so moved each marker `on` lies on the like one that is seen, and looks like it."""
        if len(set(on)) < len(on) or not self._lie(moved, on, self._at, seen):
            return False
        return all(self._look_alike(turn, a, b) for a, b in zip(on, seen.tolist(), strict=True))

    def _look_alike(self, turn: complex, mine: int, there: int) -> bool:
        """Whether a marker's outline, so turned, is another one's."""
        return self._off(turn, mine, there) < _ALIKE

    def _off(self, turn: complex, mine: int, there: int) -> float:
        """By how much it differs from that: rms, as a share of the root of its area."""
        points = turn * _plane(sample_contour(_pairs(self._outlines[mine]), _SAMPLES)[0])
        off = distance_to_outline(_pairs(points), _pairs(self._outlines[there]))
        return float(np.sqrt(np.mean(off**2) / self._area[there]))

    def _is_the_same(self, turn: complex, lone: int) -> bool:
        """Whether nobody promises that a marker's direction is told from this turn of it, as `artrec model` says."""
        off_m = self._off(turn, lone, lone) * np.sqrt(self._area[lone])
        radius_m = np.sqrt(np.mean(abs(_plane(sample_contour(_pairs(self._outlines[lone]), _SAMPLES)[0])) ** 2))
        return bool(off_m < _SAME_SHARE * radius_m)

    def _is_same(self, moved: _Points, there: _Points) -> bool:
        """Whether all markers lie on like ones of another placement, be they seen or not: what tells these two turns is
        not what is hidden (`Exchanges`), or nothing does."""
        every, on = np.arange(len(moved)), abs(moved[:, None] - there).argmin(axis=1)
        return len(set(on.tolist())) == len(on) and self._lie(moved, every, there, on)

    def _lie(self, moved: _Points, rows: _Rows, there: _Points, others: _Rows) -> bool:
        """Whether markers lie on others, each on a like one. :param moved, there: (M,) where all are."""
        least = np.sqrt(np.minimum(self._area[rows], self._area[others]))
        near = abs(moved[rows] - there[others]) < OFF * least
        return bool(near.all() and self._like[rows, others].all())


def _onto(points: _Points, others: _Points) -> tuple[complex, complex]:
    """Turn and shift that take points (n,) nearest to others (n,)."""
    middle, there = points.mean(), others.mean()
    turn = np.exp(1j * np.angle(np.vdot(points - middle, others - there)))
    return complex(turn), complex(there - turn * middle)


def _plane(points: NDArray[np.float64]) -> _Points:
    """(n,) x + iy of points (n, 2) or (n, 3)."""
    return points[:, 0] + 1j * points[:, 1]


def _pairs(points: _Points) -> NDArray[np.float64]:
    return np.column_stack([points.real, points.imag])
