"""Poses that solids may have instead of those found: tilted where they are.

A box, or whatever else its sides close in, has one outline in the image and nothing inside of it. Seen from elsewhere,
and from a little nearer or farther, it covers almost the same pixels: what votes tell of the two is less than noise
does, while the outline fits only one of them. A search that goes by votes may rest at either; so others are begun
around each that is told.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, rotation_from_rotvec
from .poses import Poses
from .required_place import RequiredPlace
from .surface_model import SpatialModel

_WAYS = 8  # directions in which a solid is tilted
_ON_EDGES = 0.1  # of its size: what lies between two corners of a cylinder's prism, .03, and more than that of a box
_BY_RAD = 0.35, 0.75  # fits lead to what is within half of the steps; a cube's sides are 0.8 from its edges at most


class Tilts:
    """Those of one object whose required component is a solid, but no ball; of others there are none."""

    def __init__(self, surface: SpatialModel, required: RequiredPlace) -> None:
        self._surface, self._required = surface, required
        around = 2 * np.pi * np.arange(_WAYS) / _WAYS
        across = np.column_stack([np.cos(around), np.sin(around), np.zeros(_WAYS)])
        self._turns = rotation_from_rotvec(np.concatenate([across * by for by in _BY_RAD]))  # about lines of sight's
        self._is_solid = surface.root in surface.solids
        mine = surface.markers_of[surface.root] if self._is_solid else []
        self._corners = np.concatenate([surface.patches[p].drawn[3:] for p in mine]) if mine else np.zeros((0, 3))
        self._edges = np.concatenate([surface.patches[p].contour for p in mine]) if mine else np.zeros((0, 3))

    def __len__(self) -> int:
        return len(self._turns) if self._is_solid else 0

    def of(self, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
        """Tilted about the middle of the required component in all directions that turn another side to the camera,
        joints as they are; and whose each one is."""
        k = len(self)
        of = np.repeat(np.arange(len(poses)), k)
        if not len(of):
            return poses[:0], of
        middle = self._required.anchors(poses)
        to_sight = _turned_to(middle / np.linalg.norm(middle, axis=1, keepdims=True))
        turns = to_sight[:, None] @ self._turns[None] @ to_sight.transpose(0, 2, 1)[:, None]  # (H, K, 3, 3)
        R = turns @ poses.R[:, None]
        t = np.einsum("hkij,hj->hki", turns, poses.t - middle) + middle[:, None]
        return Poses(R.reshape(-1, 3, 3), t.reshape(-1, 3), poses.q[of]), of

    def look_otherwise(self, poses: Poses, others: Poses, least_rad: float) -> NDArray[np.bool_]:
        """(H,) whether the required component has its corners elsewhere, as if turned by more than an angle."""
        here, there = (self._places(some, self._corners) for some in (poses, others))
        return self._off(here, there, there, here) > least_rad * self._size

    def look_alike(self, poses: Poses, others: Poses) -> NDArray[np.bool_]:
        """(H,) whether the required component has its corners on edges of another pose's: so a cylinder has that is
        turned about its axis, by whatever angle."""
        here, there = (self._places(some, self._corners) for some in (poses, others))
        on_these, on_those = (self._places(some, self._edges) for some in (poses, others))
        return self._off(here, on_those, there, on_these) < _ON_EDGES * self._size

    @property
    def _size(self) -> float:
        return float(np.sqrt(np.mean(np.sum((self._corners - self._corners.mean(axis=0)) ** 2, axis=1))))

    @staticmethod
    def _off(some: Array, near: Array, others: Array, near_these: Array) -> Array:
        """(H,) how far the farthest of points (H, n, 3) is from the nearest of those that it should be near to, and of
        others likewise."""
        each = ((some, near), (others, near_these))
        return np.max([np.linalg.norm(a[:, :, None] - b[:, None], axis=3).min(axis=2).max(axis=1) for a, b in each], 0)

    def _places(self, poses: Poses, points: Array) -> Array:
        """(H, n, 3) points of the required component (n, 3) about the middle of its corners."""
        kin, root = self._surface.kinematics, self._surface.root
        frames = kin.in_object(poses.q)
        points = points - self._corners.mean(axis=0)
        return np.asarray(np.einsum("hij,nj->hni", poses.R @ frames.R[:, root], points))


def _turned_to(sight: Array) -> Array:
    """(H, 3, 3) the least turns of the z axis into unit vectors (H, 3) that point away from the camera."""
    axis = np.column_stack([-sight[:, 1], sight[:, 0], np.zeros(len(sight))])
    sine = np.linalg.norm(axis, axis=1, keepdims=True)
    return rotation_from_rotvec(axis / np.maximum(sine, 1e-12) * np.arctan2(sine, sight[:, 2:]))
