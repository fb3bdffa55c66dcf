"""Flat objects made up at random, and scenes of them as an uncalibrated camera sees them: what
`benchmarks/acceptance_facing.py` fits and measures on.

Half of them are trees of flat parts (`random_solids.random_model`, those of which all markers lie face up); half are
small rigid patterns, a base that is cut into a few pieces of several classes, as robots bear them that are seen from
above. They are tilted by up to twenty degrees, stand among clutter and strangers, and are segmented exactly or badly.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from random_patterns import random_clutter, shaded
from random_solids import LABELS, OTHER, SHARES, SIZES, World, random_model

from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.model.objects import Component, Marker, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import sample_scene
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera, render_frame

THIRD = 4  # a further class
UP = np.eye(3)


def flat_world(seed: int) -> World:
    """One or two random targets, of one class in every third case, and at times a stranger of the first one's."""
    rng = np.random.default_rng([21, seed])
    label = LABELS[0] if rng.random() < 1 / 3 else LABELS[1]
    make = flat_tree if rng.random() < 0.5 else flat_pattern
    both = (Target("one", make("one", rng), LABELS[0]), Target("two", make("two", rng), label))
    strangers = (Target("stranger", make("stranger", rng), LABELS[0]),) if rng.random() < 0.6 else ()
    return World(both[: int(rng.integers(1, 3))], strangers)


def flat_tree(name: str, rng: np.random.Generator) -> ObjectModel:
    """A tree of parts that face up."""
    while True:
        model = random_model(name, rng)
        if model.is_flat and np.allclose(model.required.markers[0].T_component_marker.rotation, UP):
            return model


def flat_pattern(name: str, rng: np.random.Generator) -> ObjectModel:
    """A polygon cut by lines through a point: two to four pieces, the first one of the object's class."""
    corners = int(rng.integers(4, 7))
    angles = 2 * np.pi * (np.arange(corners) + rng.uniform(-0.2, 0.2, corners)) / corners
    base = 0.06 * rng.uniform(0.8, 1, (corners, 1)) * np.column_stack([np.cos(angles), np.sin(angles)])
    pieces = [base]
    for _ in range(int(rng.integers(1, 4))):
        widest = max(range(len(pieces)), key=lambda i: _area(pieces[i]))
        angle = rng.uniform(0, np.pi)
        normal, middle = np.array([np.cos(angle), np.sin(angle)]), pieces[widest].mean(axis=0)
        halves = [_half(pieces[widest], middle, sign * normal) for sign in (1, -1)]
        if min(map(_area, halves)) > 0.2 * _area(base):
            pieces[widest : widest + 1] = halves
    order = sorted(pieces, key=lambda p: -_area(p))
    components = []
    for n, piece in enumerate(order):
        low, high = piece.min(axis=0), piece.max(axis=0)
        middle = (low + high) / 2
        marker = Marker(
            "m", piece, np.array([low[0], middle[1]]), np.array([high[0], middle[1]]), None, Pose.identity()
        )
        label = None if n == 0 else int(rng.choice([OTHER, THIRD]))
        components.append(Component(f"c{n}", (marker,), n == 0, label))
    return ObjectModel(name, tuple(components))


def _half(polygon: Array, point: Array, normal: Array) -> Array:
    """What of a convex polygon (n, 2) lies on one side of a line."""
    side, out = (polygon - point) @ normal, []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if side[i] >= 0:
            out.append(polygon[i])
        if side[i] * side[j] < 0:
            out.append(polygon[i] + side[i] / (side[i] - side[j]) * (polygon[j] - polygon[i]))
    return np.array(out)


def _area(polygon: Array) -> float:
    x, y = polygon.T
    return float(abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2)


def flat_frames(world: World, seed: int, scenes: int) -> Iterator[SimulatedFrame]:
    """Scenes of a world, each with a size, crowding, clutter and a segmentation of its own, seen from above."""
    for rng in (np.random.default_rng([22, seed, n]) for n in range(scenes)):
        size, count = SIZES[rng.choice(len(SIZES), p=SHARES)], int(rng.integers(0, 11))
        least = np.exp(rng.uniform(np.log(max(12 / size[0], 0.021)), np.log(0.4)))
        scene = SceneConfig(
            objects=(count, count),
            size=(float(least), float(min(least * rng.uniform(1, 1.5), 0.6))),
            margin=float(rng.choice([1.0, 0.5, 0.0])),
            elevation_deg=(float(rng.choice([90.0, 80.0, 70.0])), 90.0),
            distractors=int(rng.choice([0, 3, 8])),
        )
        sensor = SensorConfig(spots=int(rng.choice([0, 10])), motion_blur_px=float(rng.choice([0.0, 2.0])))
        sensor = sensor.scaled(float(rng.choice([0.0, 0.5, 1.0, 1.5])))
        camera = pinhole_camera(size, 40)
        drawn = sample_scene([*world.targets, *world.strangers], camera, scene, rng)
        if rng.random() < 0.3:
            depth = max((p.T_camera_object.position[2] for p in drawn.objects), default=1.0)
            clutter = random_clutter(camera, LABELS[0], rng.uniform(0.05, 0.35), float(depth), rng)
            drawn = replace(drawn, distractors=(*drawn.distractors, *clutter))
        yield shaded(render_frame(0, Renderer(camera), drawn, sensor, rng), rng)
