"""How much room an object takes in a scene, and how far down it reaches."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..core.geometry.transforms import Array
from ..core.model.kinematics import Kinematics
from ..core.model.objects import ObjectModel
from .surfaces import component_surfaces, object_surfaces

_PLACES = 5  # of a joint at which an object's lowest point is looked for


class Extent:
    """An object's size. Its origin may lie anywhere, even outside of it.

    :ivar centre: in its own frame (3,), with every joint in the middle of its range.
    :ivar radius: greatest distance of a point from it, so.
    :ivar below: how far the lowest one ever is below it: no joint takes it through a floor there.
    """

    def __init__(self, model: ObjectModel, joint_range: float) -> None:
        self._kin = Kinematics(model)
        self._corners = [
            (c, surface.reach)
            for c, component in enumerate(model.components)
            for surface in component_surfaces(component, 1)
        ]
        shares = joint_range * np.linspace(-1, 1, _PLACES)
        self._places = np.array([list(joints_at(model, share).values()) for share in shares])
        corners = np.concatenate([s.reach for s in object_surfaces(model, 1, joints_at(model, 0.0))])
        self.centre: Array = (corners.min(axis=0) + corners.max(axis=0)) / 2
        self.radius = float(np.linalg.norm(corners - self.centre, axis=1).max())
        self.below = float(self.centre[2] - self.lowest(np.array([0.0, 0.0, 1.0])))

    def lowest(self, up: Array) -> float:
        """Height in its own frame, along a unit vector (3,), below which no joint takes it: each joint where the object
        is lowest, and once again."""
        q = self._places[_PLACES // 2]
        lowest = float(self._lowest_at(q[None], up)[0])
        for joint in (*range(len(q)), *range(len(q))):
            there = np.tile(q, (_PLACES, 1))
            there[:, joint] = self._places[:, joint]
            heights = self._lowest_at(there, up)
            if heights.min() < lowest:
                lowest, q = float(heights.min()), there[heights.argmin()]
        return lowest

    def _lowest_at(self, q: Array, up: Array) -> Array:
        """(n,) heights of its lowest point along `up`. :param q: (n, J)."""
        frames = self._kin.in_object(q)
        heights = [
            (up @ frames.R[:, c] @ corners.T + frames.t[:, c, None] @ up).min(axis=1) for c, corners in self._corners
        ]
        return np.asarray(np.min(heights, axis=0), np.float64)


def joints_at(model: ObjectModel, where: ArrayLike) -> dict[str, float]:
    """Joint values: `where` is -1 at the lower limit, 0 in the middle, 1 at the upper one; one for all or one each."""
    shares = np.broadcast_to(np.asarray(where, float), len(model.joints))
    values = {}
    for (name, joint), share in zip(model.joints.items(), shares, strict=True):
        low, high = joint.span
        values[name] = float((low + high) / 2 + share * (high - low) / 2)
    return values
