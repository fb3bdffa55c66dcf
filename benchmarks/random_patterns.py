"""Patterns made up at random, and scenes of them among clutter of their class: grids, rings and rows of 4 to 24 equal
squares, discs or ribbons on a plate, which the object file declares or not.

Part of such a pattern looks like all of it moved by a pitch, or turned. `benchmarks/patterns.py` measures on them, and
`benchmarks/acceptance.py` fits on others of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array, Pose, rotation_from_rotvec
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.simulation.config import SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, Scene
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera, render_frame
from artrec_ros.simulation.surfaces import Surface, component_poses

PATTERN = "pattern"  # their name
LABEL, PLATE = 3, 5  # of markers and clutter; of plates
KINDS, SHAPES = ("grid", "ring", "row"), ("square", "disc", "ribbon")
LEAST_SIDE_PX = 12.0  # of a marker
SHADED = 0.04  # share of markers that lose their labels
FACING = np.diag([1.0, -1.0, -1.0])  # a plate's frame (x right, y up, z out) in a camera that faces it
PLATE_M = 0.004


ACROSS, ALONG = 1 / 3, 0.05  # how far a marker may be off: across the view of its size, along it of its range


@dataclass(frozen=True)
class Pattern:
    """:param target: what is looked for; shown: what is there, with its plate."""

    target: Target
    shown: Target
    kind: str
    shape: str

    @property
    def centres(self) -> Array:
        """(n, 3) of its markers, in its own frame."""
        return np.array([c.markers[0].centre for c in self.target.model.components])


def random_pattern(seed: int) -> Pattern:
    rng = np.random.default_rng([21, seed])
    kind, shape, count = KINDS[seed % 3], SHAPES[seed // 3 % 3], int(rng.integers(4, 25))
    width = 0.06
    height = width * (rng.uniform(0.3, 0.5) if shape == "ribbon" else 1.0)
    at, turn = _places(kind, count, width * rng.uniform(1.15, 1.7), height * rng.uniform(1.15, 1.7), rng)
    required = int(np.argmin(np.linalg.norm(at - at.mean(axis=0), axis=1)))
    markers = [_marker(shape, width, height, p, a) for p, a in zip(at, turn, strict=True)]
    low, high = at.min(axis=0) - 0.8 * width, at.max(axis=0) + 0.8 * width
    plate = Box(Pose(np.eye(3), np.append((low + high) / 2, -PLATE_M)), np.append(high - low, PLATE_M))
    bare = [Component(f"c{n}", (m,), n == required) for n, m in enumerate(markers)]
    solid = [*bare]
    solid[required] = Component(f"c{required}", (markers[required],), True, None, None, (plate,), PLATE)
    shown = Target(PATTERN, ObjectModel(PATTERN, tuple(solid)), LABEL)
    declared = shown if rng.random() < 0.3 else Target(PATTERN, ObjectModel(PATTERN, tuple(bare)), LABEL)
    return Pattern(declared, shown, kind, shape)


def _places(kind: str, count: int, across: float, up: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """(n, 2) centres and (n,) turns of `count` markers or a few less."""
    if kind == "row":
        return np.arange(count)[:, None] * [across, 0.0], np.zeros(count)
    if kind == "ring":
        angles = 2 * np.pi * np.arange(count) / count
        radius = max(across, up) / (2 * np.sin(np.pi / count))
        return radius * np.column_stack([np.cos(angles), np.sin(angles)]), angles
    columns = int(rng.integers(2, int(count**0.5) + 1))
    rows = count // columns
    grid = np.stack(np.meshgrid(np.arange(rows), np.arange(columns)), axis=-1).reshape(-1, 2)
    return grid * [across, up], np.zeros(len(grid))


def _marker(shape: str, width: float, height: float, at: Array, turn: float) -> Marker:
    T, half = Pose(rotation_from_rotvec([0.0, 0.0, turn]), np.append(at, 0.0)), np.array([width, height]) / 2
    if shape == "disc":
        angles = 2 * np.pi * np.arange(48) / 48
        outline, radius = half[0] * np.column_stack([np.cos(angles), np.sin(angles)]), float(half[0])
    else:
        outline, radius = half * [[-1, -1], [1, -1], [1, 1], [-1, 1]], None
    return Marker("m", outline, np.array([-half[0], 0]), np.array([half[0], 0]), radius, T)


def same_places(model: ObjectModel, told: Pose, true: Pose) -> bool:
    """Whether each marker of a rigid object, all of one kind, lies on one of it in its true pose, and none of these is
    left over. How it is turned is asked as far as its markers tell."""
    centres = np.array([c.markers[0].centre for c in model.components])
    there, here = told.apply(centres), true.apply(centres)
    away, range_m, size = there[:, None] - here, np.linalg.norm(here, axis=1), model.required.markers[0].area ** 0.5
    along = np.einsum("ijk,jk->ij", away, here) / range_m
    across = np.sqrt(np.maximum(np.sum(away**2, axis=2) - along**2, 0))
    near = (across < ACROSS * size) & (np.abs(along) < ALONG * range_m)
    return bool(near.any(axis=0).all() and near.any(axis=1).all())


def pattern_frames(
    pattern: Pattern, seed: int, scenes: int, size: tuple[int, int] = (640, 480)
) -> Iterator[SimulatedFrame]:
    """Scenes of one pattern, in every sixth of none, with clutter of its class over a tenth to two fifths of the image,
    segmented exactly or badly."""
    camera = pinhole_camera(size, 60)
    renderer = Renderer(camera)
    for n in range(scenes):
        rng = np.random.default_rng([22, seed, n])
        placed = () if n % 6 == 5 else (_place(pattern, camera, rng),)
        depth = float(placed[0].T_camera_object.position[2]) if placed else 1.0
        clutter = random_clutter(camera, LABEL, rng.uniform(0.1, 0.4), depth, rng)
        sensor = SensorConfig(speckle=0.0).scaled(float(rng.choice([0.0, 0.5, 1.0])))
        yield shaded(render_frame(n, renderer, Scene(placed, tuple(clutter), None), sensor, rng), rng)


def shaded(frame: SimulatedFrame, rng: np.random.Generator, share: float = SHADED) -> SimulatedFrame:
    """The same frame with some markers so deep in shade that a segmenter knows nothing of them."""
    labels = frame.labels.copy()
    for truth in frame.truths:
        model, poses = truth.placed.target.model, component_poses(truth.placed.target.model, truth.placed.joints)
        for seen in truth.markers:
            if rng.random() < share:
                marker = model.component(seen.component).marker(seen.marker)
                assert marker.T_component_marker is not None  # scenes are made of models with places only
                T = truth.placed.T_camera_object @ poses[seen.component] @ marker.T_component_marker
                outline = project(frame.camera, T.apply(np.pad(marker.outline, ((0, 0), (0, 1)))))
                mask = np.zeros_like(labels)
                cv2.fillPoly(mask, [np.rint(np.clip(outline, -1e4, 1e4)).astype(np.int32)], 1)
                labels[cv2.dilate(mask, np.ones((3, 3), np.uint8)).astype(bool)] = 0
    return replace(frame, labels=labels)


def _place(pattern: Pattern, camera: Camera, rng: np.random.Generator) -> PlacedObject:
    centres = pattern.centres
    middle, radius = centres.mean(axis=0), float(np.linalg.norm(np.ptp(centres, axis=0))) / 2 + 0.05
    area = pattern.target.model.required.markers[0].area
    share = max(rng.uniform(0.3, 0.75), 2 * radius * LEAST_SIDE_PX / area**0.5 / camera.size[0])
    depth = camera.focal_px * 2 * radius / (share * camera.size[0])
    tilt, way = rng.uniform(0, 0.9), rng.uniform(-np.pi, np.pi)
    R = rotation_from_rotvec([tilt * np.cos(way), tilt * np.sin(way), 0.0]) @ FACING
    R = R @ rotation_from_rotvec([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
    free = np.maximum((np.array(camera.size) - share * camera.size[0]) / 2, 0)
    pixel = np.array(camera.size) / 2 + rng.uniform(-1, 1, 2) * free
    ray = np.linalg.inv(camera.matrix) @ np.append(pixel, 1.0)
    return PlacedObject(pattern.shown, Pose(R, ray * depth - R @ middle), {})


def random_clutter(camera: Camera, label: int, share: float, depth: float, rng: np.random.Generator) -> list[Surface]:
    """Patches of a class over about that share of the image, ragged, long or small; most of them behind an object."""
    left, out, width = share * camera.size[0] * camera.size[1], list[Surface](), camera.size[0]
    while left > 0 and len(out) < 200:
        ahead, kind = rng.random() < 0.1, rng.choice(["ragged", "long", "small"], p=[0.4, 0.3, 0.3])
        reach = width * (rng.uniform(0.01, 0.03) if ahead or kind == "small" else rng.uniform(0.04, 0.18))
        corners = 4 if kind == "long" else int(rng.integers(4, 16))
        angles = 2 * np.pi * (np.arange(corners) + rng.uniform(-0.4, 0.4, corners)) / corners
        radii = reach * rng.uniform(0.3 if kind == "ragged" else 0.7, 1, corners)
        outline = radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        if kind == "long":
            outline *= (1.0, rng.uniform(0.05, 0.3))
        turn = rng.uniform(0, np.pi)
        outline = outline @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        x, y = outline.T
        left -= abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2
        pixels = outline + rng.uniform((0, 0), camera.size)
        rays = np.column_stack([pixels, np.ones(corners)]) @ np.linalg.inv(camera.matrix).T
        z = depth * (0.5 if ahead else rng.uniform(2.0, 2.5))
        out.append(Surface(rays * z, np.array([0.0, 0.0, -1.0]), label))
    return out
