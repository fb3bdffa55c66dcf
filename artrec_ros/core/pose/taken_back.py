"""Turns of an object's body about the axis of a joint on it, which that joint takes back.

A mast that carries a jib may stand turned by any angle if the jib's joint turns as far the other way: all that the
joint carries stays where it is, and a slender mast's outline hardly tells. What is rigid to it does, and its sides. No
climb leads from one such turn to the next if what is rigid has to leave the place that it has taken.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from ..geometry.spread import all_around
from ..geometry.transforms import Array, Pose, rotation_from_rotvec
from ..model.objects import ObjectModel
from ..model.same_turns import Looks
from .poses import Poses
from .surface_model import SpatialModel

_STEPS = 12  # of a whole turn: fits lead to what is within half of one
_ABOUT = 0.3  # of its size: a square's corners stand out by as much; of what does by more the outline tells the turn
_WAYS = 500  # in which it may stand out


class TakenBack:
    """Those of one object: by as many of its joints as turn about a required component that no joint moves, and leave
    its outline about as it is while something else tells the turn; mostly by none."""

    def __init__(self, surface: SpatialModel) -> None:
        kin, root = surface.kinematics, surface.root
        self._kin = kin
        own = [surface.patches[p].drawn[3:] for p in surface.markers_of[root]]
        corners = np.zeros((0, 3)) if root in surface.sides.balls or kin.moves[root].any() else np.concatenate(own)
        angles = 2 * np.pi * np.arange(1, _STEPS) / _STEPS
        frames, found = kin.in_object(kin.middle[None]), list[tuple[int, float]]()
        for j in np.flatnonzero(kin.revolute).tolist() if len(corners) else ():
            if kin.moves[kin.carried[j]].sum() > 1:  # it is not on the body, but on what another joint carries
                continue
            R, at = rotation_from_rotvec(angles[:, None] * frames.axis[0, j]), frames.origin[0, j]
            t = at - R @ at
            stays = np.flatnonzero(_stand_out(corners, R, t) < _ABOUT).tolist()
            looks = _looks_of(surface.model, ~kin.moves[:, j]) if stays else None
            found += [(j, angles[n]) for n in stays if looks and not looks.same_after(Pose(R[n], t[n]))]
        self._joint, self._angle = (np.array([f[n] for f in found], kind) for n, kind in ((0, int), (1, float)))

    def __len__(self) -> int:
        return len(self._joint)

    def of(self, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
        """Those within the joints' limits; and of which of H poses each is."""
        kin, k = self._kin, len(self)
        of = np.repeat(np.arange(len(poses)), k)
        if not len(of):
            return poses[:0], of
        joint, angle = np.tile(self._joint, len(poses)), np.tile(self._angle, len(poses))
        frames, rows = kin.forward(poses.R, poses.t, poses.q), np.arange(len(of))
        turn, at = rotation_from_rotvec(angle[:, None] * frames.axis[of, joint]), frames.origin[of, joint]
        q = poses.q[of]
        low = kin.lower[joint]
        q[rows, joint] = low + (q[rows, joint] - angle - low) % (2 * np.pi)
        within = np.flatnonzero(q[rows, joint] <= kin.upper[joint])
        t = np.einsum("nij,nj->ni", turn, poses.t[of] - at) + at
        return Poses(turn @ poses.R[of], t, q)[within], of[within]


def _looks_of(model: ObjectModel, stays: NDArray[np.bool_]) -> Looks:
    """Those of some of its components (C,): by how they look a turn is told."""
    return Looks(replace(model, components=tuple(compress(model.components, stays)), identities=()))


def _stand_out(points: Array, R: Array, t: Array) -> Array:
    """(K,) by how much at most moved points' convex hull and the points' own stand out beyond each other, as a share of
    the farthest point's distance from their middle.

    :param points: (n, 3). :param R, t: (K, 3, 3), (K, 3) moves.
    """
    ways, middle = all_around(_WAYS), points.mean(axis=0)
    there = points @ np.swapaxes(R, 1, 2) + t[:, None] - middle
    off = (there @ ways.T).max(axis=1) - ((points - middle) @ ways.T).max(axis=0)
    return np.asarray(np.abs(off).max(axis=1) / np.linalg.norm(points - middle, axis=1).max())
