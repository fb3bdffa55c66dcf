"""Turns of flat objects that lay each marker on another one that may be of its class: turned so, an object looks almost
the same, or as one of another name does."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from .surface_model import Poses, SpatialModel

_OFF = 0.5  # of the root of a marker's area: what lies nearer to another one lies on it
_LIKE = 0.5, 2.0  # areas of markers that may be taken for each other, one over the other
_STRETCH = 0.15  # by so much distances of such markers differ


class Exchanges:
    """Those of one object, joints mid-range. :ivar angle_rad: (K,) by which it is turned, counter-clockwise."""

    def __init__(self, surface: SpatialModel) -> None:
        markers, kin = surface.markers, surface.kinematics
        frames = kin.in_object((kin.lower + kin.upper)[None] / 2)
        at = surface.place(frames, surface.centre[markers], surface.component[markers])[0][:, :2]
        labels = [set(surface.patches[p].labels) for p in markers.tolist()]
        found = _turns(at, surface.area[markers], labels)
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


def _turns(at: Array, area: Array, labels: list[set[int]]) -> list[tuple[float, Array]]:
    """Angles and shifts that lay markers at places (M, 2) on each other."""
    pairs = list(permutations(range(len(at)), 2))
    if not pairs:
        return []
    along = {pair: at[pair[1]] - at[pair[0]] for pair in pairs}
    first = max(pairs, key=lambda pair: float(np.linalg.norm(along[pair])))
    length = float(np.linalg.norm(along[first]))
    found: list[tuple[float, Array]] = []
    for pair in pairs:
        if pair == first or abs(np.linalg.norm(along[pair]) - length) > _STRETCH * length:
            continue
        angle = float(np.arctan2(along[pair][1], along[pair][0]) - np.arctan2(along[first][1], along[first][0]))
        R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        shift = at.mean(axis=0) - R @ at.mean(axis=0)  # all lie on each other
        if _lies_on_itself(at @ R.T + shift, at, area, labels):
            found.append((angle, shift))
    return found


def _lies_on_itself(moved: Array, at: Array, area: Array, labels: list[set[int]]) -> bool:
    """Whether each marker lies on another one, or itself, that may be of its class and is of its size."""
    off = np.linalg.norm(moved[:, None] - at, axis=2)
    on = off.argmin(axis=1)
    near = off.min(axis=1) < _OFF * np.sqrt(np.minimum(area, area[on]))
    ratio = area / area[on]
    like = [bool(labels[m] & labels[n]) for m, n in enumerate(on.tolist())]
    lies = near & (ratio > _LIKE[0]) & (ratio < _LIKE[1]) & np.array(like)
    return bool(lies.all() and len(set(on.tolist())) == len(at))
