"""Where a rigid object's markers lie, to be compared with themselves when it is moved in its own frame."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, Pose, rotation_from_rotvec
from ..model.marker import Marker
from .surface_model import SpatialModel

_SAME_SIZE = 0.08  # logarithm of the roots of areas that differ by less are one size
NEAR = 0.25  # markers whose centres are nearer cover one another, as a share of the root of their area
SAME_WAY = 0.9  # cosine of their normals


class Placed(NamedTuple):
    """A marker.

    :param labels: classes that it may have.
    :param inside: its frame at its centroid in its component's frame; whole: in the object's, joints mid-range.
    """

    component: int
    marker: Marker
    labels: tuple[int, ...]
    inside: Pose
    whole: Pose


def placed_markers(surface: SpatialModel) -> list[Placed]:
    kin, out = surface.kinematics, []
    frames = kin.in_object(kin.middle[None])
    for c, component in enumerate(surface.model.components):
        for marker in component.markers:
            inside = middle_of(marker)
            whole = Pose(frames.R[0, c], frames.t[0, c]) @ inside
            out.append(Placed(c, marker, surface.labels[c], inside, whole))
    return out


def middle_of(marker: Marker) -> Pose:
    """A marker's frame at its centroid, in its component's."""
    assert marker.T_component_marker is not None  # the model is spatial
    return marker.T_component_marker @ Pose(np.eye(3), np.append(marker.centroid, 0.0))


def moves_onto(mine: Placed, there: Placed, turns: list[float]) -> tuple[Array, Array]:
    """(K, 3, 3), (K, 3) how a rigid object moves, in its own frame, with one of its markers put in another one's place,
    turned so."""
    in_place = rotation_from_rotvec(np.outer(turns, [0.0, 0.0, 1.0]))
    R = there.whole.rotation @ in_place @ mine.whole.rotation.T
    return R, there.whole.position - R @ mine.whole.position


class Layout:
    """Where M markers of a rigid object lie, to be compared with themselves when it is moved in its own frame.

    :ivar at, normal: (M, 3). :ivar near_m: (M,) what comes as near lies on one.
    :ivar same: (M, M) which are of one size and class.
    """

    def __init__(self, markers: list[Placed]) -> None:
        self.at = np.array([m.whole.position for m in markers]).reshape(-1, 3)
        self.normal = np.array([m.whole.rotation[:, 2] for m in markers]).reshape(-1, 3)
        size = np.array([m.marker.area**0.5 for m in markers])
        numbers = {labels: n for n, labels in enumerate({m.labels for m in markers})}
        of = np.array([numbers[m.labels] for m in markers], int)
        self.near_m = NEAR * size
        self.same = (np.abs(np.log(size[:, None] / size)) < _SAME_SIZE) & (of[:, None] == of)

    def alike(self, R: Array, t: Array) -> NDArray[np.bool_]:
        """(K, M, M) which markers lie on which, of their size and class. :param R, t: (K, 3, 3), (K, 3) moves."""
        there = self.at @ np.swapaxes(R, 1, 2) + t[:, None]
        off = (there**2).sum(axis=2)[:, :, None] + (self.at**2).sum(axis=1) - 2 * there @ self.at.T
        near = self.same & (off < self.near_m**2)
        return np.asarray(near & (self.normal @ np.swapaxes(R, 1, 2) @ self.normal.T > SAME_WAY))

    def cover(self, R: Array, t: Array, some: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(K,) after which moves like markers lie on each of some: one after the other, for few do on the first."""
        left = np.arange(len(R))
        size2 = (self.at**2).sum(axis=1)
        for m in some.tolist():
            before = ((self.at[m] - t[left])[:, None] @ R[left])[:, 0]  # where that which lies there has come from
            off2 = (before**2).sum(axis=1)[:, None] - 2 * before @ self.at.T + size2
            near = (off2 < self.near_m[m] ** 2) & self.same[:, m]
            one_way = self.normal @ (self.normal[m] @ R[left])[..., None] > SAME_WAY
            left = left[(near & one_way[..., 0]).any(axis=1)]
        return np.isin(np.arange(len(R)), left)
