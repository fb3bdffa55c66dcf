"""What is true of a rendered scene: object poses, and of each marker how much of it shows and where."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..core.geometry.camera import Camera
from ..core.geometry.polygons import in_space, signed_area
from ..core.geometry.projection import project
from ..core.geometry.transforms import Array
from ..core.model.objects import ObjectModel
from .render import SUPERSAMPLING, Rendering, project_outline, to_pixel
from .scene import PlacedObject
from .surfaces import ball_surface, component_poses


@dataclass(frozen=True)
class MarkerTruth:
    """A marker that faces the camera.

    :param facing: cosine between its normal and the direction to the camera.
    :param full_px: area of its whole image, square pixels, even where hidden or outside the picture.
    :param visible_px: area that shows.
    :param centre: (2,) centre of the area that shows, pixels; None: nothing shows.
    :param tail, head: (2,) ends of its axis, pixels.
    :param bounds: x, y, width, height of what shows, pixels; None: nothing shows.
    """

    component: str
    marker: str
    facing: float
    full_px: float
    visible_px: float
    centre: Array | None
    tail: Array
    head: Array
    bounds: tuple[float, float, float, float] | None

    @property
    def visible_share(self) -> float:
        return self.visible_px / self.full_px if self.full_px > 0 else 0.0


@dataclass(frozen=True)
class ObjectTruth:
    """An object, and its markers that face the camera. :param balls_px: (2,) the centre of each component that is a
    ball, pixels."""

    placed: PlacedObject
    centre_px: Array
    markers: tuple[MarkerTruth, ...]
    balls_px: Mapping[str, Array] = field(default_factory=dict)


def measure(rendering: Rendering, objects: tuple[PlacedObject, ...], camera: Camera) -> tuple[ObjectTruth, ...]:
    """The truth of each object, in order."""
    truths = []
    for number, placed in enumerate(objects):
        axes = axis_ends(placed, camera)
        markers = [
            _measure_marker(rendering, index, camera, axes[surface.owner])
            for index, surface in enumerate(rendering.surfaces)
            if surface.owner is not None and rendering.objects[index] == number
        ]
        centre = project(camera, placed.T_camera_object.position[None])[0]
        truths.append(ObjectTruth(placed, centre, tuple(markers), _ball_centres(placed, camera)))
    return tuple(truths)


def _ball_centres(placed: PlacedObject, camera: Camera) -> dict[str, Array]:
    poses = component_poses(placed.target.model, placed.joints)
    places = {name: (placed.T_camera_object @ poses[name]).apply(c) for name, c in placed.target.balls.items()}
    return {name: project(camera, at[None])[0] for name, at in places.items()}


def axis_ends(placed: PlacedObject, camera: Camera) -> dict[tuple[str, str], Array]:
    """(component, marker) -> (2, 2) image of tail and head, of a ball of its centre and a point of its rim."""
    model: ObjectModel = placed.target.model
    poses = component_poses(model, placed.joints)
    ends = {}
    for component in model.components:
        for marker in component.markers:
            assert marker.T_component_marker is not None  # scenes are made of models with places only
            T = placed.T_camera_object @ poses[component.name]
            if marker.is_ball:
                ball = ball_surface(T.apply(marker.centre), marker.radius, 1, None)
                axis = np.stack([ball.corners.mean(axis=0), ball.corners[0]])
            else:
                axis = (T @ marker.T_component_marker).apply(in_space(np.stack([marker.tail, marker.head])))
            ends[component.name, marker.name] = project(camera, axis)
    return ends


def _measure_marker(rendering: Rendering, index: int, camera: Camera, axis: Array) -> MarkerTruth:
    surface = rendering.surfaces[index]
    assert surface.owner is not None
    outline = project_outline(camera, surface.corners)
    rows, columns = np.nonzero(rendering.index == index)
    centre = bounds = None
    if len(rows):
        u, v = to_pixel(columns), to_pixel(rows)
        centre = np.array([u.mean(), v.mean()])
        bounds = (float(u.min()), float(v.min()), float(np.ptp(u)), float(np.ptp(v)))
    component, marker = surface.owner
    visible = len(rows) / SUPERSAMPLING**2
    return MarkerTruth(
        component, marker, surface.facing, abs(signed_area(outline)), visible, centre, axis[0], axis[1], bounds
    )
