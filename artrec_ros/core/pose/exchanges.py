"""Turns of flat objects that lay each marker on another one that may be of its class: turned so, an object looks almost
the same, or as one of another name does."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from .poses import Poses
from .surface_model import SpatialModel

# what a contour's fit can yet bring onto another marker, and an image of few pixels does not tell from it
OFF = 0.5  # of the root of a marker's area: how far apart their middles may be
LIKE = 0.5, 2.0  # areas of markers that may be taken for each other, one over the other
STRETCH = 0.15  # by so much distances of such markers differ
SAME = 1e-3  # of sizes and places: what differs by less is the same, and nothing tells its turns apart

_Points = NDArray[np.complex128]  # x + iy in the object's plane


def may_be_taken_for(surface: SpatialModel, markers: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(M, M) which of some of a surface's patches (M,) may be of each other's class and are about as large."""
    area, labels = surface.area[markers], [set(surface.patches[p].labels) for p in markers.tolist()]
    ratio = area / area[:, None]
    same = np.array([[bool(a & b) for b in labels] for a in labels], bool).reshape(ratio.shape)
    return np.asarray(same & (ratio > LIKE[0]) & (ratio < LIKE[1]))


class Placements:
    """Ways to lay a flat object otherwise, in its plane.

    :ivar angle_rad: (K,) by which it is turned, counter-clockwise. :ivar same: (K,) after which of them what is seen is
        the same, not only alike.
    """

    def __init__(self, turn: _Points, shift: _Points, same: Sequence[bool] = ()) -> None:
        """:param turn: (K,) about its origin, of length one. :param shift: (K,) metres, after that. :param same: see
        `Placements`; not given: of none."""
        self.same = np.array(same, bool) if len(same) else np.zeros(len(turn), bool)
        self.angle_rad, cos, sin, nil = np.angle(turn), turn.real, turn.imag, np.zeros(len(turn))
        self._R = np.stack([cos, -sin, nil, sin, cos, nil, nil, nil, nil + 1], axis=1).reshape(-1, 3, 3)
        self._t = np.stack([shift.real, shift.imag, nil], axis=1)

    def __len__(self) -> int:
        return len(self.angle_rad)

    def of(self, pose: Poses) -> Poses:
        """K poses: one that is laid so."""
        (R,), (t,), (q,) = pose.R, pose.t, pose.q
        return Poses(R @ self._R, t + self._t @ R.T, np.tile(q, (len(self), 1)))


class Exchanges(Placements):
    """Those of one object; of one with joints none: what lies on what depends on them."""

    def __init__(self, surface: SpatialModel) -> None:
        markers, kin = surface.markers, surface.kinematics
        frames = kin.in_object(kin.middle[None])
        x, y, _ = surface.place(frames, surface.centre[markers], surface.component[markers])[0].T
        middle = np.mean(x + 1j * y)  # turned about it all markers lie on each other
        labels = [set(surface.patches[p].labels) for p in markers.tolist()]
        found = [] if kin.n_joints else _turns(x + 1j * y - middle, surface.area[markers], labels)
        turn = np.array(found, complex)
        super().__init__(turn, middle - turn * middle)


def _turns(at: _Points, area: NDArray[np.float64], labels: list[set[int]]) -> list[complex]:
    """Those about their middle that lay markers (M,) on each other, each once: factors of length one."""
    pairs = list(permutations(range(len(at)), 2))
    if not pairs:
        return []
    along = {pair: at[pair[1]] - at[pair[0]] for pair in pairs}
    first = max(along.values(), key=abs)
    found: dict[tuple[int, ...], complex] = {tuple(range(len(at))): 1.0}
    for other in along.values():
        if abs(abs(other) - abs(first)) > STRETCH * abs(first):
            continue
        turned = at * np.exp(1j * np.angle(other / first))
        on = abs(turned[:, None] - at).argmin(axis=1)
        if len(set(on.tolist())) < len(at) or tuple(on.tolist()) in found:
            continue
        turn = np.exp(1j * np.angle(np.vdot(at, at[on])))  # what moves all of them nearest
        if _lies_on(abs(turn * at - at[on]), area, area[on], labels, [labels[n] for n in on]):
            found[tuple(on.tolist())] = complex(turn)
    return list(found.values())[1:]


def _lies_on(
    off: NDArray[np.float64],
    area: NDArray[np.float64],
    of_area: NDArray[np.float64],
    labels: list[set[int]],
    of_labels: list[set[int]],
) -> bool:
    """Whether each marker lies on one that may be of its class and is of its size, and something tells that from how it
    was: places, sizes, or classes that may be others."""
    ratio, like = area / of_area, np.array([bool(a & b) for a, b in zip(labels, of_labels, strict=True)])
    lies = (off < OFF * np.sqrt(np.minimum(area, of_area))) & (ratio > LIKE[0]) & (ratio < LIKE[1]) & like
    differs = (off > SAME * np.sqrt(area)) | (abs(ratio - 1) > SAME) | [len(own) > 1 for own in labels]
    return bool(lies.all() and differs.any())
