"""How images show an object whose markers' axes are marked in them, and what its pose and joints are there, about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..geometry.camera import Camera
from ..geometry.polygons import in_space
from ..geometry.projection import project
from ..geometry.transforms import Array, Pose
from ..model.chain_kernels import Chain
from ..model.kinematics import Frames, Kinematics, frames_of
from ..model.marker import Marker
from ..model.objects import ObjectModel
from ..pose.poses import Poses
from ..pose.views import FACING
from .keypoint_fit import Points, fit_points

_AROUND = 24  # values of each joint that are looked at
WORST_SHARE, LEAST_WORST_PX = 0.1, 5.0  # of the object's size in the image: marks farther off tell no lengths


class Marks(NamedTuple):
    """The marked axes of an object in one image.

    :param marker: (n,) numbers of the markers, in the order of `markers_of`.
    :param ends: (n, 2, 2) pixels of each one's tail and head. :param place: where that stands.
    """

    marker: NDArray[np.int64]
    ends: Array
    place: str = ""

    @property
    def worst_px(self) -> float:
        """How far off they may be in the mean."""
        return max(LEAST_WORST_PX, WORST_SHARE * float(np.linalg.norm(np.ptp(self.ends.reshape(-1, 2), axis=0))))


class Start(NamedTuple):
    """What is marked in an image, and the pose and joints, one row, that come nearest to it.

    :param off_px: mean distance of the marked ends from where they would be. :param near: that is little enough.
    """

    marks: Marks
    poses: Poses
    off_px: float
    near: bool


def markers_of(model: ObjectModel) -> list[tuple[int, Marker, Pose]]:
    """All markers of an object whose markers have places: the number of its component, it, and its pose there."""
    return [
        (c, marker, marker.T_component_marker)
        for c, component in enumerate(model.components)
        for marker in component.markers
        if marker.T_component_marker is not None
    ]


def marks_of(model: ObjectModel, points: Mapping[str, Array], place: str = "") -> Marks:
    """The markers of which both ends are marked. :param points: keypoint name -> (2,) pixels."""
    names = [f"{model.components[c].name}/{marker.name}" for c, marker, _ in markers_of(model)]
    both = [
        (n, (points[f"{name}.tail"], points[f"{name}.head"]))
        for n, name in enumerate(names)
        if f"{name}.tail" in points and f"{name}.head" in points
    ]
    marker, ends = zip(*both, strict=True) if both else ((), ())
    return Marks(np.array(marker, np.int64), np.array(ends, float).reshape(-1, 2, 2), place)


@dataclass(frozen=True)
class Figure:
    """An object as far as its markers' axes tell of it.

    :param component: (m,) of each marker. :param places: (m, 2, 3) where its axis' ends lie on its component.
    """

    chain: Chain
    component: NDArray[np.int64]
    places: Array

    @classmethod
    def of(cls, model: ObjectModel) -> Figure:
        known = markers_of(model)
        places = np.array([T.apply(axis_ends(marker)) for _, marker, T in known])
        return cls(Kinematics(model).chain, np.array([c for c, _, _ in known], np.int64), places)

    def with_lengths(self, joint_shift: Array, places: Array) -> Figure:
        """The same with joints shifted (C, 3) in their parents, and axes' ends elsewhere (m, 2, 3)."""
        return replace(self, chain=self.chain._replace(t=self.chain.t + joint_shift), places=places)

    def ends(self, poses: Poses) -> Array:
        """(H, m, 2, 3) of all axes in the camera."""
        frames = self.frames(poses)
        R, t = frames.R, frames.t
        return np.asarray(np.einsum("hmij,mkj->hmki", R[:, self.component], self.places) + t[:, self.component, None])

    def frames(self, poses: Poses) -> Frames:
        """Of the components in the camera."""
        return frames_of(self.chain, poses.R, poses.t, poses.q)


def axis_ends(marker: Marker) -> Array:
    """(2, 3) of its axis in its own frame."""
    return in_space(np.stack([marker.tail, marker.head]))


@dataclass(frozen=True)
class Eye:
    """What sees an object. :param facing: it lies flat and faces the camera, whatever that is: only turned about the
    line of sight, and moved."""

    model: ObjectModel
    camera: Camera
    facing: bool

    def starts(self, marks: Sequence[Marks]) -> list[Start]:
        """Of what is marked well enough to tell a pose, be it near or not."""
        figure, kin = Figure.of(self.model), Kinematics(self.model)
        find = self._facing if self.facing else self._in_space
        found = [find(figure, kin, m) for m in marks]
        return [start for start in found if start is not None]

    def pixels(self, figure: Figure, poses: Poses) -> Array:
        """(H, m, 2, 2) where it shows the ends of all axes."""
        return project(self.camera, figure.ends(poses))

    def _in_space(self, figure: Figure, kin: Kinematics, marks: Marks) -> Start | None:
        """A disc's marked ends need not be those of its axis: its middle counts."""
        known = markers_of(self.model)
        disc = np.array([known[m][1].disc_radius is not None for m in marks.marker.tolist()])
        normal = np.array([known[m][2].rotation[:, 2] for m in marks.marker.tolist()]).reshape(-1, 3)
        axes, discs, component = marks.marker[~disc], marks.marker[disc], figure.component
        points = Points(
            np.concatenate([component[axes].repeat(2), component[discs]]),
            np.concatenate([figure.places[axes].reshape(-1, 3), figure.places[discs].mean(axis=1)]),
            np.concatenate([normal[~disc].repeat(2, axis=0), normal[disc]]),
            np.concatenate([marks.ends[~disc].reshape(-1, 2), marks.ends[disc].mean(axis=1)]),
        )
        fit = fit_points(kin, self.camera, points)
        if fit is None:
            return None
        poses = Poses(fit.R[None], fit.t[None], fit.q[None])
        return Start(marks, poses, fit.rms_px, bool(fit.rms_px <= marks.worst_px))

    def _facing(self, figure: Figure, kin: Kinematics, marks: Marks) -> Start:
        """One marker tells the pose; then joint by joint what brings all marks nearest, twice around."""
        best = self._laid(figure, marks, kin.middle[None])
        for joint in [*range(kin.n_joints)] * 2:
            values = np.append(kin.grid(joint, 2 * np.pi / _AROUND), best.q[0, joint])
            q = np.repeat(best.q, len(values), axis=0)
            q[:, joint] = values
            tried = self._laid(figure, marks, q)
            best = tried[[int(np.argmin(self._off_px(figure, marks, tried)))]]
        near = bool(self._off_px(figure, marks, best)[0] < marks.worst_px)  # one of two that is lost is as much
        return Start(marks, best, float(self._off_each_px(figure, marks, best).mean()), near)

    def _laid(self, figure: Figure, marks: Marks, q: Array) -> Poses:
        """Poses that carry one axis, of the required component where that is marked, to its marks, at joints (H, J)."""
        root = self.model.components.index(self.model.required)
        first = int(np.argmax(figure.component[marks.marker] == root))
        marker, (tail, head) = int(marks.marker[first]), marks.ends[first]
        frames = figure.frames(Poses(np.tile(np.eye(3), (len(q), 1, 1)), np.zeros((len(q), 3)), q))
        R, t = (v[:, figure.component[marker]] for v in (frames.R, frames.t))  # of the marker's component in the object
        front = FACING @ markers_of(self.model)[marker][2].rotation.T @ R.transpose(0, 2, 1)
        along = np.diff(figure.places[marker], axis=0)[0]
        shown, marked = (front @ R @ along)[:, :2] @ np.array([1, 1j]), (head - tail) @ np.array([1, 1j])
        turns = np.angle(marked / shown)
        R_object = Rotation.from_rotvec(turns[:, None] * [0.0, 0.0, 1.0]).as_matrix() @ front
        middle_px = (tail + head) / 2 - self.camera.matrix[:2, 2]
        depth = self.camera.focal_px * np.linalg.norm(along) / abs(marked)
        middle = t + R @ figure.places[marker].mean(axis=0)
        there = depth * np.append(middle_px / self.camera.focal_px, 1.0)
        return Poses(R_object, there - np.einsum("hij,hj->hi", R_object, middle), q)

    def _off_px(self, figure: Figure, marks: Marks, poses: Poses) -> Array:
        """(H,) mean distance of the axes' ends from where they are marked; no mistaken axis counts for much."""
        return np.asarray(np.minimum(self._off_each_px(figure, marks, poses), 2 * marks.worst_px).mean(axis=1))

    def _off_each_px(self, figure: Figure, marks: Marks, poses: Poses) -> Array:
        """(H, n) of each axis, mean of both ends."""
        off = self.pixels(figure, poses)[:, marks.marker] - marks.ends
        return np.asarray(np.linalg.norm(off, axis=-1).mean(axis=2))
