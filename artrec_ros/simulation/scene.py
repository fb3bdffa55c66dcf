"""Random scenes: objects that stand on one floor before a camera, and things that belong to nothing.

Camera's optical frame throughout: x right, y down, z along the line of sight, metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.base.errors import ConfigError
from ..core.geometry.camera import Camera
from ..core.geometry.transforms import Array, Pose, rotation_from_rotvec
from ..core.model.objects import ObjectModel
from ..core.model.target import Target
from .config import SceneConfig
from .extent import Extent, joints_at
from .identities import all_taken, alternative_labels, drawn, shown_as
from .surfaces import Surface, object_surfaces

_SIDE_DEG, _ABOVE_DEG = (0.0, 25.0), (65.0, 90.0)
_TRIES = 400
_HEADINGS = 60  # an object with one flat marker turns it to the camera in one of three
_FACING = 0.5  # cosine of the angle under which a marker counts as turned to the camera


@dataclass(frozen=True)
class PlacedObject:
    """An object in a scene.

    :param T_camera_object: its frame in the camera's optical frame.
    :param joints: name -> radians (metres for prismatic joints).
    :param identity: which one it is, where it has identities; the target's components then have one class each.
    """

    target: Target
    T_camera_object: Pose
    joints: dict[str, float]
    identity: str | None = None

    def surfaces(self) -> list[Surface]:
        """Its surfaces in the camera's frame."""
        own = object_surfaces(self.target.model, self.target.label, self.joints)
        return [s.moved(self.T_camera_object) for s in own]


@dataclass(frozen=True)
class Floor:
    """The plane normal @ x = offset, seen from the side that `normal` points to."""

    normal: Array
    offset: float
    label: int


@dataclass(frozen=True)
class Scene:
    """What the camera looks at."""

    objects: tuple[PlacedObject, ...]
    distractors: tuple[Surface, ...]
    floor: Floor | None


@dataclass(frozen=True)
class _Ground:
    """A frame of the floor: columns right, forward, up; and a point on it."""

    axes: Array
    point: Array


def require_places(model: ObjectModel) -> None:
    """Raise `ConfigError` where a marker's place on the object is not known."""
    for (component, name), marker in model.markers.items():
        if marker.T_component_marker is None:
            raise ConfigError(
                f"object '{model.name}': marker '{name}' of component '{component}' has no pose; "
                "a scene needs to know where each marker sits"
            )


def sample_scene(targets: Sequence[Target], camera: Camera, config: SceneConfig, rng: np.random.Generator) -> Scene:
    """A random scene. It may hold fewer objects than drawn: no free place is found for more, or each is there already.

    :raises ConfigError: a target's model lacks a marker's place.
    """
    count = int(rng.integers(config.objects[0], config.objects[1] + 1))
    chosen = [targets[i] for i in rng.integers(0, len(targets), count)]
    extents = {t.name: Extent(t.model, config.joint_range) for t in targets}
    ground = _sample_ground(targets, extents, camera, config, rng)
    placed: list[PlacedObject] = []
    for target in chosen:
        same = [p for p in placed if p.target.name == target.name]
        taken = [p.identity for p in same if p.identity is not None]
        position = _find_place(target, extents, placed, ground, camera, config, rng)
        if position is not None and not all_taken(target.model, taken, stands=bool(same)):
            identity = drawn(target.model, taken, rng)
            one = _place(shown_as(target, identity), position, extents[target.name], ground, config, rng)
            placed.append(replace(one, identity=identity))
    floor = None
    up = ground.axes[:, 2]
    if config.floor_label and up @ ground.point < 0:  # a floor above the camera would hide what stands on it
        floor = Floor(up, float(up @ ground.point), config.floor_label)
    return Scene(tuple(placed), tuple(sample_distractors(targets, placed, camera, config, rng)), floor)


def depth_range(radius: float, camera: Camera, config: SceneConfig) -> tuple[float, float]:
    """Least and greatest depth (m) at which a sphere of that radius has the apparent size that is asked for."""
    at_full_width = camera.matrix[0, 0] * 2 * radius / camera.size[0]
    near = max(at_full_width / config.size[1], 1.5 * radius)  # never behind the camera
    return near, max(at_full_width / config.size[0], near)


def _elevation_range(targets: Sequence[Target], config: SceneConfig) -> tuple[float, float]:
    """Degrees. Markers that look up are looked at from above."""
    if config.elevation_deg:
        return config.elevation_deg[0], config.elevation_deg[1]
    upward = [
        s.normal[2] > np.sqrt(0.5) for t in targets for s in object_surfaces(t.model, 1, {}) if s.owner is not None
    ]
    return _ABOVE_DEG if np.mean(upward) > 0.5 else _SIDE_DEG


def _sample_ground(
    targets: Sequence[Target],
    extents: dict[str, Extent],
    camera: Camera,
    config: SceneConfig,
    rng: np.random.Generator,
) -> _Ground:
    """A floor that lies below the camera, and so that a first object on its point fits into the view."""
    extent = extents[targets[int(rng.integers(len(targets)))].name]
    size = np.array(camera.size, float)
    for _ in range(_TRIES):
        elevation = np.radians(rng.uniform(*_elevation_range(targets, config)))
        roll = rotation_from_rotvec([0.0, 0.0, rng.normal(0, 0.03)])
        up = roll @ (0.0, -np.cos(elevation), -np.sin(elevation))
        right = roll @ (1.0, 0.0, 0.0)
        depth = rng.uniform(*depth_range(extent.radius, camera, config))
        inset = np.minimum(config.margin * camera.matrix[0, 0] * extent.radius / depth, size / 2)
        ray = np.linalg.inv(camera.matrix) @ np.append(rng.uniform(inset, size - inset) - 0.5, 1.0)
        point = depth * ray - extent.below * up
        if up @ point < 0:
            break
    return _Ground(np.column_stack([right, np.cross(up, right), up]), point)


def _find_place(
    target: Target,
    extents: dict[str, Extent],
    placed: Sequence[PlacedObject],
    ground: _Ground,
    camera: Camera,
    config: SceneConfig,
    rng: np.random.Generator,
) -> Array | None:
    """(3,) a place for the object's centre in view, clear of the other objects; None where none was found."""
    extent = extents[target.name]
    near, far = depth_range(extent.radius, camera, config)
    offsets = rng.uniform(-far, far, (_TRIES, 2))
    offsets[0] = 0.0  # the ground's own point was chosen to be in view
    positions = ground.point + offsets @ ground.axes[:, :2].T + extent.below * ground.axes[:, 2]  # (tries, 3)
    depth = positions[:, 2]
    ahead = np.maximum(depth, 1e-6)
    pixels = (positions @ camera.matrix.T)[:, :2] / ahead[:, None]
    inset = np.minimum(config.margin * camera.matrix[0, 0] * extent.radius / ahead[:, None], np.array(camera.size) / 2)
    inside = np.all((pixels >= inset - 0.5) & (pixels <= np.array(camera.size) - 0.5 - inset), axis=1)
    free = inside & (depth >= near * 0.999) & (depth <= far * 1.001)
    for other in placed:
        # 0.8: boxes that touch at the corners of their spheres are rare, robots that brush past are not
        least = 0.8 * (extent.radius + extents[other.target.name].radius)
        there = other.T_camera_object.apply(extents[other.target.name].centre)
        free &= np.linalg.norm(positions - there, axis=1) >= least
    found = np.flatnonzero(free)
    return positions[found[0]] if len(found) else None


def _place(
    target: Target, position: Array, extent: Extent, ground: _Ground, config: SceneConfig, rng: np.random.Generator
) -> PlacedObject:
    """The object with its centre at that position, a random heading, a little tilt and random joints."""
    at = rng.uniform(-config.joint_range, config.joint_range, len(target.model.joint_components))
    joints = joints_at(target.model, at)
    wanted = rng.random() < config.facing
    for _ in range(_HEADINGS):
        heading = rotation_from_rotvec([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
        tilt = rotation_from_rotvec(rng.normal(0, config.tilt_rad, 3))
        rotation = ground.axes @ heading @ tilt
        placed = PlacedObject(target, Pose(rotation, position - rotation @ extent.centre), joints)
        if not wanted or _turns_to_camera(placed):
            break
    return _above(placed, extent, ground) if config.floor_label else placed


def _above(placed: PlacedObject, extent: Extent, ground: _Ground) -> PlacedObject:
    """The same lifted as far as its tilt would have it sink into the floor."""
    at, up = placed.T_camera_object, ground.axes[:, 2]
    lowest = float(up @ (at.position - ground.point)) + extent.lowest(up @ at.rotation)
    return replace(placed, T_camera_object=Pose(at.rotation, at.position - min(lowest, 0.0) * up))


def _turns_to_camera(placed: PlacedObject) -> bool:
    required = placed.target.model.required.name
    return any(s.facing > _FACING for s in placed.surfaces() if s.owner is not None and s.owner[0] == required)


def sample_distractors(
    targets: Sequence[Target],
    placed: Sequence[PlacedObject],
    camera: Camera,
    config: SceneConfig,
    rng: np.random.Generator,
) -> list[Surface]:
    """Upright polygons of the objects' colours, mostly behind the objects, of about the size of a marker or a body."""
    own = {s.label for t in targets for s in object_surfaces(t.model, t.label, {})}
    labels = sorted((own | alternative_labels(targets)) - {0})
    depths = [p.T_camera_object.position[2] for p in placed] or [1.0]
    surfaces = []
    for _ in range(int(rng.integers(0, config.distractors + 1))):
        depth = max(depths) * rng.uniform(1.3, 1.6) if rng.random() < 0.8 else min(depths) * rng.uniform(0.6, 0.8)
        pixel = rng.uniform((0, 0), camera.size)
        angles = np.sort(rng.uniform(-np.pi, np.pi, int(rng.integers(3, 8))))
        reach_px = rng.uniform(0.01, 0.06) * camera.size[0] * rng.uniform(0.5, 1.5, len(angles))
        outline = pixel + reach_px[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        rays = np.column_stack([outline, np.ones(len(outline))]) @ np.linalg.inv(camera.matrix).T
        surfaces.append(Surface(rays * depth, np.array([0.0, 0.0, -1.0]), int(rng.choice(labels))))
    return surfaces
