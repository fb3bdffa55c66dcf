"""What a truth of poses or of annotated axes says of markers, by the object's model.

Poses: the required component's markers are projected; of joints, and of what hides what, nothing is known.
Axes: two points fix a marker's similarity, and so its centre and area. They were annotated, so they are visible.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...core.alignment.shapes import Shape
from ...core.alignment.symmetry import ANY_ANGLE
from ...core.base.errors import SourceError
from ...core.design.ambiguity import order_of
from ...core.geometry.camera import Camera
from ...core.geometry.polygons import in_space, signed_area
from ...core.geometry.projection import project
from ...core.geometry.transforms import Array, Pose, readonly
from ...core.model.marker import Marker
from ...core.model.objects import Component, ObjectModel
from ...io.base.yaml_files import nearest
from ...io.learned.annotations import instance_from_axis
from ...io.truth.records import TrueComponent, TrueObject
from ...simulation.render import polygon_mask, project_outline

_LEAST_DEPTH_M = 1e-3


def with_components(o: TrueObject, model: ObjectModel, camera: Camera | None) -> TrueObject:
    """A true object with the components that its axes or its pose tell. :raises SourceError: axes of other markers."""
    if o.components:
        return o
    if o.axes:
        return replace(o, components=dict(_from_axis(name, axis, model) for name, axis in o.axes.items()))
    if o.pose is None or camera is None:
        return o
    centre = project(camera, o.pose.position[None])[0] if o.pose.position[2] > _LEAST_DEPTH_M else None
    return replace(o, components=_from_pose(o.pose, model.required, camera), centre_px=centre)


def with_own_names(o: TrueObject, model: ObjectModel) -> TrueObject:
    """A true object whose names of components are not taken for sides of others: 'arm_tip' is no side of 'arm' where
    the model has an 'arm_tip'."""
    mine = {c.name for c in model.components}
    return replace(o, components={f"{name}@" if name in mine else name: c for name, c in o.components.items()})


def undirected(model: ObjectModel) -> frozenset[str]:
    """'COMPONENT/MARKER' of the markers that look the same in any turn, as discs: they have no direction of their own,
    and an annotated axis has whichever the annotator chose."""
    known = model.markers.items()
    return frozenset("/".join(key) for key, marker in known if order_of(Shape.from_marker(marker)) == ANY_ANGLE)


def slant_rad(T_camera_object: Pose, required: Component) -> float | None:
    """The least angle between a line of sight and the normal of a marker of the required component.

    None: it has no marker whose place is known.
    """
    angles = [
        np.arccos(np.clip(_facing(T_camera_object @ m.T_component_marker, m), -1, 1))
        for m in required.markers
        if m.T_component_marker is not None
    ]
    return float(min(angles)) if angles else None


def _from_axis(name: str, axis: Array, model: ObjectModel) -> tuple[str, TrueComponent]:
    markers = {"/".join(key): (key[0], m) for key, m in model.markers.items()}
    if name not in markers:
        raise SourceError(
            f"truth: the keypoints of '{name}' are of no marker of '{model.name}'{nearest(name, markers)}"
        )
    component, marker = markers[name]
    placed = instance_from_axis(component, marker, *axis)
    area_px = marker.area * placed.scale**2
    return f"{component}@{marker.name}", TrueComponent(area_px, area_px, readonly([placed.x, placed.y]))


def _from_pose(T_camera_object: Pose, required: Component, camera: Camera) -> dict[str, TrueComponent]:
    components = {}
    for marker in required.markers:
        if marker.T_component_marker is None:
            continue
        T = T_camera_object @ marker.T_component_marker
        corners = T.apply(in_space(marker.outline))
        if _facing(T, marker) > 0 and corners[:, 2].min() > _LEAST_DEPTH_M:
            components[f"{required.name}@{marker.name}"] = _seen(project_outline(camera, corners), camera.size)
    return components


def _seen(outline: Array, size: tuple[int, int]) -> TrueComponent:
    """A marker's image (n, 2), of which the part within the picture shows."""
    full_px = abs(signed_area(outline))
    rows, columns = np.nonzero(polygon_mask(outline, (size[1], size[0])))
    centre = readonly([columns.mean(), rows.mean()]) if len(rows) else None
    return TrueComponent(full_px, min(float(len(rows)), full_px), centre)


def _facing(T_camera_marker: Pose, marker: Marker) -> float:
    """Cosine between the marker's normal and the direction from its centre to the camera."""
    centre = T_camera_marker.apply(np.append(marker.centroid, 0.0)[None])[0]
    return float(-centre @ T_camera_marker.rotation[:, 2] / np.linalg.norm(centre))
