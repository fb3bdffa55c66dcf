"""The surfaces of an object in a given pose: its markers and the faces of its bodies, flat ones and balls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..core.geometry.polygons import in_space
from ..core.geometry.transforms import Array, Pose
from ..core.model.kinematics import Kinematics
from ..core.model.objects import Box, Component, ObjectModel

# A box's faces by their outward normal, as corners of the unit cube in order around the face.
_CUBE_FACES = (
    ((1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)),
    ((-1, 1, -1), (-1, -1, -1), (-1, -1, 1), (-1, 1, 1)),
    ((1, 1, -1), (-1, 1, -1), (-1, 1, 1), (1, 1, 1)),
    ((-1, -1, -1), (1, -1, -1), (1, -1, 1), (-1, -1, 1)),
    ((-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)),
    ((-1, 1, -1), (1, 1, -1), (1, -1, -1), (-1, -1, -1)),
)

_BALL_CORNERS = 96  # of a ball's outline: it lacks .07 % of a circle's area
_STEPS = np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
_AROUND = np.delete(_STEPS, 13, axis=0)  # directions all around
_AROUND /= np.linalg.norm(_AROUND, axis=1, keepdims=True)


@dataclass(frozen=True)
class Surface:
    """A flat polygon that hides what is behind it, or the disc that a ball looks like from its frame's origin.

    :param corners: (n, 3) in order, metres.
    :param normal: (3,) outward unit normal.
    :param label: class label.
    :param owner: (component, marker) where it is a marker, else None.
    :param ball: centre (3,) and radius, metres; None: it is none.
    """

    corners: Array
    normal: Array
    label: int
    owner: tuple[str, str] | None = None
    ball: tuple[Array, float] | None = None

    def moved(self, T: Pose) -> Surface:
        """The same surface in the target frame of `T`."""
        if self.ball is not None:
            return ball_surface(T.apply(self.ball[0]), self.ball[1], self.label, self.owner)
        return Surface(T.apply(self.corners), T.rotation @ self.normal, self.label, self.owner)

    @property
    def reach(self) -> Array:
        """(n, 3) points as far out as it is."""
        return self.corners if self.ball is None else self.ball[0] + self.ball[1] * _AROUND

    @property
    def facing(self) -> float:
        """Cosine between the normal and the direction to the origin (the camera); negative: seen from behind."""
        centre = self.corners.mean(axis=0)
        return float(-self.normal @ centre / np.linalg.norm(centre))


def ball_surface(centre: Array, radius_m: float, label: int, owner: tuple[str, str] | None) -> Surface:
    """A ball as it looks from the origin: square to the line of sight, and as much nearer as the rays that touch it
    draw its outline."""
    far = float(np.linalg.norm(centre))
    normal = -centre / far if far > radius_m else np.array([0.0, 0.0, 1.0])
    nearer = math.sqrt(1 - (radius_m / far) ** 2) if far > radius_m else 1.0
    right = np.cross(normal, (0, 1, 0) if abs(normal[1]) < abs(normal[0]) else (1, 0, 0))
    right /= np.linalg.norm(right)
    angle = 2 * np.pi * np.arange(_BALL_CORNERS)[:, None] / _BALL_CORNERS
    corners = nearer * centre + radius_m * (np.cos(angle) * right + np.sin(angle) * np.cross(normal, right))
    return Surface(corners, normal, label, owner, (centre, radius_m))


def component_poses(model: ObjectModel, joints: Mapping[str, float]) -> dict[str, Pose]:
    """Each component's frame in the object's frame, T_object_component; joints that are not named are at zero."""
    q = np.array([[joints.get(name, 0.0) for name in model.joint_names]])
    frames = Kinematics(model).in_object(q)
    return {c.name: Pose(R, t) for c, R, t in zip(model.components, frames.R[0], frames.t[0], strict=True)}


def box_faces(box: Box, label: int) -> list[Surface]:
    """The six faces of a box in its component's frame."""
    faces = []
    for corners in _CUBE_FACES:
        cube = np.array(corners, float)
        outward = np.where(np.ptp(cube, axis=0) == 0, cube[0], 0.0)
        faces.append(Surface(cube * box.size / 2, outward, label).moved(box.T_component_box))
    return faces


def object_surfaces(model: ObjectModel, label: int, joints: Mapping[str, float]) -> list[Surface]:
    """All surfaces of an object in its own frame.

    :param label: class label of the components that name none of their own.
    """
    poses = component_poses(model, joints)
    return [s.moved(poses[c.name]) for c in model.components for s in component_surfaces(c, label)]


def component_surfaces(component: Component, label: int) -> list[Surface]:
    """Its surfaces in its own frame. :param label: see `object_surfaces`."""
    own = [face for box in component.bodies for face in box_faces(box, component.body_label or 0)]
    for marker in component.markers:
        if marker.T_component_marker is None:
            continue
        shown, owner = component.labels(label)[0], (component.name, marker.name)
        if marker.is_ball:
            own.append(ball_surface(marker.centre, marker.radius, shown, owner))
            continue
        own.append(
            Surface(in_space(marker.outline), np.array([0.0, 0.0, 1.0]), shown, owner).moved(marker.T_component_marker)
        )
    return own
