"""Turns of flat objects that lay each marker on another one that may be of its class: turned so, an object looks almost
the same, or as one of another name does."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from .surface_model import Poses, SpatialModel

# what a contour's fit can yet bring onto another marker, and an image of few pixels does not tell from it
_OFF = 0.5  # of the root of a marker's area: how far apart their middles may be
_LIKE = 0.5, 2.0  # areas of markers that may be taken for each other, one over the other
_STRETCH = 0.15  # by so much distances of such markers differ
_SAME = 1e-3  # of sizes and places: what differs by less is the same, and nothing tells its turns apart

_Turn = tuple[float, Array]  # angle and shift in the object's plane


class Exchanges:
    """Those of one object; of one with joints none: what lies on what depends on them.

    :ivar angle_rad: (K,) by which it is turned, counter-clockwise.
    """

    def __init__(self, surface: SpatialModel) -> None:
        markers, kin = surface.markers, surface.kinematics
        frames = kin.in_object(kin.middle[None])
        at = surface.place(frames, surface.centre[markers], surface.component[markers])[0][:, :2]
        labels = [set(surface.patches[p].labels) for p in markers.tolist()]
        found = [] if kin.n_joints else _turns(at, surface.area[markers], labels)
        self.angle_rad = np.array([angle for angle, _ in found])
        self._t = np.array([[*t, 0.0] for _, t in found]).reshape(-1, 3)

    def __len__(self) -> int:
        return len(self.angle_rad)

    def of(self, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
        """H K poses that are so turned, and of which each one is."""
        of = np.repeat(np.arange(len(poses)), len(self))
        cos, sin, nil = np.cos(self.angle_rad), np.sin(self.angle_rad), np.zeros(len(self))
        turn = np.stack([cos, -sin, nil, sin, cos, nil, nil, nil, nil + 1], axis=1).reshape(-1, 3, 3)
        turn, moved = (np.tile(values, (len(poses), *[1] * (values.ndim - 1))) for values in (turn, self._t))
        R = poses.R[of]
        return Poses(R @ turn, poses.t[of] + (R @ moved[..., None])[..., 0], poses.q[of]), of


def _turns(at: Array, area: Array, labels: list[set[int]]) -> list[_Turn]:
    """Those that lay markers at places (M, 2) on each other, each once."""
    pairs = list(permutations(range(len(at)), 2))
    along = {pair: at[pair[1]] - at[pair[0]] for pair in pairs}
    first = max(pairs, key=lambda pair: float(np.linalg.norm(along[pair])), default=None)
    found: dict[tuple[int, ...], _Turn] = {tuple(range(len(at))): (0.0, np.zeros(2))}
    for pair in pairs if first else ():
        assert first is not None
        length = float(np.linalg.norm(along[first]))
        if abs(np.linalg.norm(along[pair]) - length) > _STRETCH * length:
            continue
        angle = float(np.arctan2(along[pair][1], along[pair][0]) - np.arctan2(along[first][1], along[first][0]))
        on = _nearest(_moved(at, (angle, at.mean(axis=0) - _rotation(angle) @ at.mean(axis=0))), at)
        if len(set(on)) < len(at) or on in found:
            continue
        turn = _fitted(at, at[list(on)])
        if _lies_on(_moved(at, turn), at[list(on)], area, area[list(on)], labels, [labels[n] for n in on]):
            found[on] = turn
    return list(found.values())[1:]


def _rotation(angle: float) -> Array:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _moved(at: Array, turn: _Turn) -> Array:
    return np.asarray(at @ _rotation(turn[0]).T + turn[1])


def _nearest(moved: Array, at: Array) -> tuple[int, ...]:
    return tuple(np.linalg.norm(moved[:, None] - at, axis=2).argmin(axis=1).tolist())


def _fitted(at: Array, to: Array) -> _Turn:
    """What moves points (M, 2) nearest to others."""
    a, b = at - at.mean(axis=0), to - to.mean(axis=0)
    angle = float(np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum()))
    return angle, to.mean(axis=0) - _rotation(angle) @ at.mean(axis=0)


def _lies_on(
    moved: Array, to: Array, area: Array, of_area: Array, labels: list[set[int]], of_labels: list[set[int]]
) -> bool:
    """Whether each marker lies on one that may be of its class and is of its size, and something tells that from how it
    was: places, sizes, or classes that may be others."""
    off, ratio = np.linalg.norm(moved - to, axis=1), area / of_area
    like = np.array([bool(a & b) for a, b in zip(labels, of_labels, strict=True)])
    lies = (off < _OFF * np.sqrt(np.minimum(area, of_area))) & (ratio > _LIKE[0]) & (ratio < _LIKE[1]) & like
    differs = (off > _SAME * np.sqrt(area)) | (abs(ratio - 1) > _SAME) | [len(own) > 1 for own in labels]
    return bool(lies.all() and differs.any())
