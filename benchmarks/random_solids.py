"""Spatial objects made up at random, and scenes of them: what `benchmarks/acceptance.py` fits and measures on.

An object is a tree of one to twelve flat or solid parts, a chain, or a hand (up to sixteen). Its markers are polygons,
silhouettes with notches, ribbons and discs, on one side or on several; bodies are there in another class, in an unknown
colour, or not at all. Scenes hold up to ten objects of one or two targets and of a stranger that nobody looks for and
that bears their class (an object of its own, or a part of a target), clutter in their classes, a floor of its own class
or nothing known around, and are segmented exactly or badly.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from random_patterns import random_clutter, shaded

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Array, Pose, rotation_from_rotvec
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import sample_scene
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera, render_frame

LABELS, OTHER, BODY = (3, 2), 6, 5  # of targets; of components with a class of their own; of bodies
SIZES, SHARES = ((208, 160), (320, 240), (640, 480)), (0.35, 0.5, 0.15)  # of images; how often
COUNTS = (0, 1, 2, 3, 3, 4, 5, 5)  # of objects in a scene
CLUTTERED = 0.15  # share of scenes with patches of the first target's class over much of the image
CROWDED = 0.4  # share of scenes with up to ten, as far as there is room, and none of them small
FACING = (0.85, 0.85, 0.4)  # shares of objects that turn the required component to the camera
CHAINS, HANDS = 0.15, 0.15  # shares of objects
LARGEST = 0.8  # apparent diameter, a share of the image's width
FEW = 4  # parts of objects that are seen as small as any
LEAST_PX = 25.0  # apparent diameter of the smallest objects
# Frames of an object's sides: columns right, up, out; its own: x forward, y left, z up
RIGHT = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
LEFT = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]], float)
FRONT = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], float)
UP = np.eye(3)
TURNED = np.diag([-1.0, 1.0, -1.0])  # of a marker on the back of a part
THICK_M, LAYER_M = 0.006, 0.012  # half a part's thickness; how far one part lies before another


@dataclass(frozen=True)
class World:
    """Targets to look for, and strangers that stand among them."""

    targets: tuple[Target, ...]
    strangers: tuple[Target, ...]


@dataclass(frozen=True)
class _Style:
    """What an object's parts have in common."""

    bodies: bool
    body_label: int | None
    classes: float  # share of components with a class of their own
    doubled: float  # share of parts with a marker on their back
    alike: bool  # all limbs have the same shape
    bare: tuple[float, float]  # least and greatest size of a body, of the marker's on it

    @classmethod
    def random(cls, rng: np.random.Generator) -> _Style:
        bodies = rng.random() < 0.7
        label = BODY if bodies and rng.random() < 0.75 else None
        bare = ((1.05, 1.2), (1.1, 1.8))[int(rng.integers(2))]
        classes, doubled = rng.choice([0.0, 0.0, 0.4]), rng.choice([0.0, 0.0, 0.5, 1.0])
        return cls(bodies, label, classes, doubled, rng.random() < 0.4, bare)


def random_world(seed: int) -> World:
    """One or two random targets, of one class in every third case, and at times a stranger of the first one's."""
    rng = np.random.default_rng([11, seed])
    label = LABELS[0] if rng.random() < 1 / 3 else LABELS[1]
    both = (Target("one", random_model("one", rng), LABELS[0]), Target("two", random_model("two", rng), label))
    parts = [c.markers[0] for c in both[0].model.components if not c.required and c.label is None]
    if parts and rng.random() < 0.4:
        part = replace(parts[int(rng.integers(len(parts)))], T_component_marker=Pose(RIGHT, np.zeros(3)))
        other = ObjectModel("stranger", (Component("c0", (part,), required=True),))
    else:
        other = random_model("stranger", rng)
    strangers = (Target("stranger", other, LABELS[0]),) if rng.random() < 0.6 else ()
    return World(both[: int(rng.integers(1, 3))], strangers)


def random_frames(world: World, seed: int, scenes: int, *, exact: bool = False) -> Iterator[SimulatedFrame]:
    """Scenes of a world, each with a camera, crowding, clutter and a segmentation of its own. What has many parts is
    seen larger, or there would be nothing of each to see.

    :param exact: each pixel has the class of what is there, for a camera to see.
    """
    parts = max(len(target.model.components) for target in world.targets)
    larger = max(parts / FEW, 1.0) ** 0.5
    for rng in (np.random.default_rng([12, seed, n]) for n in range(scenes)):
        size, count = SIZES[rng.choice(len(SIZES), p=SHARES)], int(rng.choice(COUNTS))
        least = np.exp(rng.uniform(np.log(LEAST_PX / size[0]), np.log(0.45)))
        if rng.random() < CROWDED:
            count, least = int(rng.integers(5, 11)), rng.uniform(0.15, 0.3)
        least = min(least * larger, LARGEST)
        scene = SceneConfig(
            objects=(count, count),
            size=(float(least), float(min(least * rng.uniform(1, 2.5), LARGEST))),
            margin=float(rng.choice([1.0, 0.5, 0.0])),
            facing=float(rng.choice(FACING)),
            distractors=int(rng.choice([0, 3, 8])),
            floor_label=int(rng.choice([0, 1, 1])),
        )
        sensor = SensorConfig(spots=int(rng.choice([0, 10])), motion_blur_px=float(rng.choice([0.0, 2.0])))
        sensor = sensor.scaled(float(rng.choice([0.0, 0.5, 1.0, 1.5])) * (not exact))
        camera: Camera = pinhole_camera(size, 60)
        drawn = sample_scene([*world.targets, *world.strangers], camera, scene, rng)
        if rng.random() < CLUTTERED:
            depth = max((p.T_camera_object.position[2] for p in drawn.objects), default=1.0)
            clutter = random_clutter(camera, LABELS[0], rng.uniform(0.05, 0.35), float(depth), rng)
            drawn = replace(drawn, distractors=(*drawn.distractors, *clutter))
        frame = render_frame(0, Renderer(camera), drawn, sensor, rng)
        yield frame if exact else shaded(frame, rng)


def random_model(name: str, rng: np.random.Generator) -> ObjectModel:
    """A tree of one to eight parts, at times of up to twelve, a chain, or a hand."""
    kind = rng.random()
    if kind < CHAINS:
        return _chain(name, rng)
    return _hand(name, rng) if kind < CHAINS + HANDS else random_tree(name, rng)


def random_tree(name: str, rng: np.random.Generator) -> ObjectModel:
    """A tree of one to eight parts, at times of up to twelve."""
    style, count = _Style.random(rng), int(rng.integers(1, 9)) if rng.random() < 0.9 else int(rng.integers(9, 13))
    solid = rng.random() < 0.5
    depth = rng.uniform(0.05, 0.14) if solid else 2 * THICK_M
    sides = [RIGHT, LEFT] if solid else [UP if rng.random() < 0.3 else RIGHT]
    components, reach, like = [_root(style, sides, depth, rng)], [rng.uniform(0.05, 0.09)], int(rng.integers(1 << 31))
    for n in range(1, count):
        parent = int(rng.integers(n)) if rng.random() < 0.4 else 0
        place = _at_root(sides, depth, reach[0], rng) if parent == 0 else _at_end(reach[parent], rng)
        shape = np.random.default_rng(like) if style.alike else rng
        limb, length = _limb(f"c{n}", f"c{parent}", place, style, shape)
        components.append(limb)
        reach.append(length)
    return ObjectModel(name, tuple(components))


def _root(style: _Style, sides: list[Array], depth: float, rng: np.random.Generator) -> Component:
    size = rng.uniform(0.09, 0.2, 2)
    shown = [*sides, *([FRONT] if len(sides) > 1 and rng.random() < 0.5 else [])]
    markers = []
    for n, side in enumerate(shown):
        fits = size if side is not FRONT else np.array([depth, size[1]])
        out = depth / 2 if side is not FRONT else size[0] / 2
        markers.append(_marker(f"m{n}", random_outline(fits, rng), Pose(side, (out + 1e-3) * side[:, 2])))
    if len(sides) == 1 and rng.random() < style.doubled:
        back = sides[0] @ TURNED
        markers.append(_marker("back", random_outline(size, rng), Pose(back, (depth / 2 + 1e-3) * back[:, 2])))
    across = sides[0] @ np.array([*size * rng.uniform(*style.bare, 2), depth])
    box = Box(Pose.identity(), np.abs(across))
    return Component("c0", tuple(markers), True, None, None, (box,) * style.bodies, style.body_label)


def _chain(name: str, rng: np.random.Generator) -> ObjectModel:
    """Three to twelve parts in a row, in one plane, as a rule alike."""
    style, side, like = _Style.random(rng), (UP, RIGHT)[int(rng.integers(2))], int(rng.integers(1 << 31))
    components = [_root(style, [side], 2 * THICK_M, rng)]
    place = Pose(side, _rim(components[0], 0.0) * side[:, 0])
    for n in range(1, int(rng.integers(3, 13))):
        shape = np.random.default_rng(like) if rng.random() < 0.9 else rng
        limb, reach = _limb(f"c{n}", f"c{n - 1}", place, style, shape)
        components.append(limb)
        place = Pose(UP, np.array([0.95 * reach, 0.0, 0.0]))
    return ObjectModel(name, tuple(components))


def _hand(name: str, rng: np.random.Generator) -> ObjectModel:
    """Two to five fingers of one to three parts in the plane of a palm; fingers' parts alike, and bending less than
    a chain's."""
    style, fingers, like = _Style.random(rng), int(rng.integers(2, 6)), rng.integers(1 << 31, size=3)
    side, bones = (UP, RIGHT)[int(rng.integers(2))], int(rng.integers(1, 4))
    components = [_root(style, [side], 2 * THICK_M, rng)]
    fan = rng.uniform(0.25, 0.75) * np.pi / max(fingers - 1, 1)
    for f in range(fingers):
        angle, parent = fan * (f - (fingers - 1) / 2) + rng.uniform(-0.05, 0.05), "c0"
        turn = side @ rotation_from_rotvec([0.0, 0.0, angle])
        place = Pose(turn, _rim(components[0], angle) * turn[:, 0])
        for b in range(bones):
            child, shape = f"c{len(components)}", np.random.default_rng(like[b])
            limb, reach = _limb(child, parent, place, style, shape, bend=0.4)
            components.append(limb)
            parent, place = child, Pose(UP, np.array([0.95 * reach, 0.0, 0.0]))
    return ObjectModel(name, tuple(components))


def _rim(root: Component, angle: float) -> float:
    """How far a flat root's marker reaches in a direction."""
    along = np.array([np.cos(angle), np.sin(angle)])
    return float((root.markers[0].outline @ along).max())


def _at_root(sides: list[Array], depth: float, reach: float, rng: np.random.Generator) -> Pose:
    """Where a limb hangs on the root: on one of its sides, pointing away from its middle."""
    side, angle = sides[int(rng.integers(len(sides)))], rng.uniform(-np.pi, np.pi)
    at = np.array([reach * np.cos(angle), reach * np.sin(angle), depth / 2 + LAYER_M * rng.uniform(0.8, 2)])
    return Pose(side @ rotation_from_rotvec([0.0, 0.0, angle]), side @ at) @ _tilt(rng)


def _at_end(reach: float, rng: np.random.Generator) -> Pose:
    turn = rotation_from_rotvec([0.0, 0.0, rng.uniform(-1, 1)])
    return Pose(turn, np.array([0.95 * reach, 0.0, LAYER_M * rng.uniform(0.8, 2)])) @ _tilt(rng)


def _tilt(rng: np.random.Generator) -> Pose:
    """Some limbs move out of the plane they hang on."""
    tilted = rng.random() < 0.2
    return Pose(rotation_from_rotvec([0.0, tilted * rng.uniform(-0.6, 0.1), 0.0]), np.zeros(3))


def _limb(
    name: str, parent: str, place: Pose, style: _Style, rng: np.random.Generator, bend: float = 1.2
) -> tuple[Component, float]:
    """A part from its joint along x, and its length. :param bend: how far it may turn either way at most, radians."""
    length, kind = rng.uniform(0.06, 0.16), rng.choice(["revolute", "revolute", "revolute", "prismatic", "fixed"])
    width = length * (rng.uniform(0.17, 0.4) if rng.random() < 0.7 else rng.uniform(0.5, 0.9))
    middle = np.array([0.1 * length + length / 2, 0.0, 0.0])
    markers = [_marker("m", random_outline(np.array([length, width]), rng), Pose(UP, middle + (0, 0, THICK_M)))]
    if rng.random() < style.doubled:
        outline = random_outline(np.array([length, width]), rng)
        markers.append(_marker("back", outline, Pose(TURNED, middle - (0, 0, THICK_M))))
    low, high, axis = -rng.uniform(0.2, bend), rng.uniform(0.2, bend), np.array([0.0, 0.0, 1.0])
    if kind == "prismatic":
        low, high, axis = 0.0, rng.uniform(0.02, 0.08), np.array([1.0, 0.0, 0.0])
    elif kind == "fixed":
        low = high = 0.0
    flat = np.array([length, width]) * rng.uniform(*style.bare, 2)
    box = Box(Pose(UP, middle), np.array([*flat, 2 * THICK_M - 1e-3]))
    joint = Joint(parent, place, axis, low, high, str(kind))
    label = OTHER if rng.random() < style.classes else None
    limb = Component(name, tuple(markers), False, label, joint, (box,) * style.bodies, style.body_label)
    return limb, 1.1 * length


def _marker(name: str, shape: tuple[Array, float | None], T: Pose) -> Marker:
    outline, radius = shape
    return Marker(name, outline, np.array([outline[:, 0].min(), 0]), np.array([outline[:, 0].max(), 0]), radius, T)


def random_outline(size: Array, rng: np.random.Generator) -> tuple[Array, float | None]:
    """(n, 2) about the origin within a rectangle of that size, and the radius where it is a disc."""
    kind, half = rng.choice(["ribbon", "disc", "polygon", "silhouette"], p=[0.35, 0.1, 0.3, 0.25]), size / 2
    if kind == "ribbon":
        return half * [[-1, -1], [1, -1], [1, 1], [-1, 1]], None
    if kind == "disc":
        radius, angles = float(half.min()), 2 * np.pi * np.arange(48) / 48
        return radius * np.column_stack([np.cos(angles), np.sin(angles)]), radius
    corners = int(rng.integers(3, 8)) if kind == "polygon" else int(rng.integers(8, 14))
    least = 0.75 if kind == "polygon" else 0.45
    angles = 2 * np.pi * (np.arange(corners) + rng.uniform(-0.35, 0.35, corners)) / corners
    return half * rng.uniform(least, 1, (corners, 1)) * np.column_stack([np.cos(angles), np.sin(angles)]), None
