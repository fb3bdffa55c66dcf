"""Flat objects made up at random, and scenes of them as an uncalibrated camera sees them: what
`benchmarks/acceptance_facing.py` fits and measures on.

Half of them are trees of flat parts (`random_solids.random_tree`, those of which all markers lie face up), limbs with a
colour of their own at times on bodies of the object's; half are small rigid patterns, a base that is cut into a few
pieces of several classes, as robots bear them that are seen from above; where it is asked for, some are equal dots on a
body or on limbs. They are tilted by up to twenty degrees, stand
among clutter and strangers, and are segmented exactly or badly; or they are painted, blurred and compressed, as a
camera's colours are, for the recogniser to read itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from random_patterns import random_clutter, shaded
from random_solids import BODY, LABELS, OTHER, SHARES, SIZES, World, random_tree

from artrec_ros.core.base.config import ClassConfig, ImageConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, sample_scene
from artrec_ros.simulation.sensor import smeared
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera, render_frame
from artrec_ros.simulation.surfaces import component_poses
from artrec_ros.simulation.truth import ObjectTruth

THIRD = 4  # a further class
PAINTED = (*LABELS, THIRD, BODY, OTHER)
UP = np.eye(3)
# Share of the worlds in which things of other shapes bear the objects' colours. These are chosen for that to be seldom:
# with 0.6, of robots that others drew as a poor camera shows them, 0.87 are told, not 0.96
STRANGE = 0.2
# Share of the trees whose limbs of other colours sit on bodies of the object's own, as a toy's hands do on its arms
SELF_COLOURED = 1 / 2
DOT_M, HINGED = 0.03, (0.0, 0.5, 1.0)  # radius of dots, and the share of an object's that joints carry
# Share of the painted scenes that move during the exposure, and how far at most
MOVING, MOTION_PX = 1 / 3, 8.0
PATCHES = 16  # of a background of several colours
# Share of the scenes in which the border takes a required component, and how far beyond it is, in its sizes
CUT, BEYOND = 1 / 4, (0.4, 1.2)
LEAST_PX, MOST_PX = 8.0, 60.0  # of a required component, where no object is
# Share of the scenes with strays, how many at most, and the greatest share of components that are hidden beside them
STREWN, STRAYS, HIDDEN = 0.4, 8, 0.4
AS_LARGE = 0.15  # logarithm, by which strays are larger or smaller than an object's markers
GAP = np.ones((5, 5), np.uint8)  # two pixels between a stray and anything else


class FlatScene(NamedTuple):
    """A scene of a world. :param picture: (H, W, 3) what a camera makes of it; None: labels are read. :param way_px: of
    the image during the exposure."""

    frame: SimulatedFrame
    picture: NDArray[np.uint8] | None = None
    way_px: float = 0.0


def flat_world(seed: int, dotted: float = 0.0) -> World:
    """One or two random targets, of one class in every third case, and at times a stranger of the first one's.

    :param dotted: share of the worlds whose objects are equal dots.
    """
    rng = np.random.default_rng([21, seed])
    label = LABELS[0] if rng.random() < 1 / 3 else LABELS[1]
    make = flat_tree if rng.random() < 0.5 else flat_pattern
    if np.random.default_rng([26, seed]).random() < dotted:
        make = flat_dots
    both = (Target("one", make("one", rng, LABELS[0]), LABELS[0]), Target("two", make("two", rng, label), label))
    strangers = (Target("stranger", make("stranger", rng, LABELS[0]), LABELS[0]),) if rng.random() < STRANGE else ()
    return World(both[: int(rng.integers(1, 3))], strangers)


def flat_tree(name: str, rng: np.random.Generator, label: int) -> ObjectModel:
    """A tree of parts that face up. :param label: the object's class."""
    while True:
        model = random_tree(name, rng)
        place = model.required.markers[0].T_component_marker
        if model.is_flat and place is not None and np.allclose(place.rotation, UP):
            break
    if rng.random() >= SELF_COLOURED:
        return model
    parts = (replace(c, body_label=label) if c.bodies and c.label is not None else c for c in model.components)
    return replace(model, components=tuple(parts))


def flat_pattern(name: str, rng: np.random.Generator, _label: int) -> ObjectModel:
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


def flat_dots(name: str, rng: np.random.Generator, _label: int) -> ObjectModel:
    """Three to nine equal discs, each fixed beside one before it or on a joint there, most of them of one class."""
    hinged, other = rng.choice(HINGED), float(rng.choice([0.0, 0.0, 0.4]))
    parts, at = [Component("c0", (disc(np.zeros(2)),), True)], [np.zeros(2)]
    for n in range(1, int(rng.integers(3, 10))):
        parent = int(rng.integers(n)) if rng.random() < 0.5 else 0
        while True:
            turn = rng.uniform(-np.pi, np.pi)
            way = rng.uniform(2.5, 6) * DOT_M * np.array([np.cos(turn), np.sin(turn)])
            if min(np.linalg.norm(at[parent] + way - place) for place in at) > 2.4 * DOT_M:
                break
        label = OTHER if rng.random() < other else None
        reach = float(rng.uniform(0.2, 1.2)) if rng.random() < hinged else 0.0
        joint = Joint(
            f"c{parent}",
            parts[parent].markers[0].T_component_marker or Pose.identity(),
            UP[2], -reach, reach, "revolute" if reach else "fixed", f"j{n}",
        )  # fmt: skip
        parts.append(Component(f"c{n}", (disc(way),), False, label, joint))
        at.append(at[parent] + way)
    return ObjectModel(name, tuple(parts))


def disc(at: Array) -> Marker:
    """One of the dots. :param at: (2,) in its component's frame."""
    outline = DOT_M * np.column_stack([f(2 * np.pi * np.arange(48) / 48) for f in (np.cos, np.sin)])
    return Marker("m", outline, np.array([-DOT_M, 0]), np.array([DOT_M, 0]), DOT_M, Pose(UP, np.append(at, 0.0)))


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


def world_colours(seed: int) -> ImageConfig:
    """How a world's painted scenes are read: a colour for each class, far enough apart, and a background."""
    rng, rgb = np.random.default_rng([23, seed]), list[tuple[int, ...]]()
    while len(rgb) < len(PAINTED) + 1:
        grey = len(rgb) == len(PAINTED)
        colour = rng.integers(25, 230, 3) if not grey else rng.integers(20, 200) + rng.integers(-12, 13, 3)
        if all(np.linalg.norm(colour - np.array(other)) > 70 for other in rgb):
            rgb.append(tuple(int(c) for c in colour))
    classes = {f"c{label}": ClassConfig(label=label, rgb=c) for label, c in zip(PAINTED, rgb[:-1], strict=True)}
    return ImageConfig(kind="colour", classes=classes, background=rgb[-1])


def painted(frame: SimulatedFrame, colours: ImageConfig, rng: np.random.Generator) -> FlatScene:
    """What a camera makes of labels: light that falls off, blur of up to a pixel and a half, at times motion during the
    exposure, noise, JPEG. What is of no class is a patchwork where the background has several colours."""
    grounds, (height, width) = np.reshape(colours.background, (-1, 3)).astype(float), frame.labels.shape
    table = np.tile(grounds[0], (256, 1))
    for cls in colours.classes.values():
        table[cls.label] = cls.rgb
    image = table[frame.labels]
    if len(grounds) > 1:
        bare = ~np.isin(frame.labels, [cls.label for cls in colours.classes.values()])
        image[bare] = grounds[patchwork((width, height), len(grounds), rng)[bare]]
    image = image[..., ::-1]
    x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
    light = rng.uniform(0.7, 1.25) * (1 + rng.uniform(-0.25, 0.25) * x + rng.uniform(-0.25, 0.25) * y)
    image = cv2.GaussianBlur(image * light[..., None], (0, 0), rng.uniform(0.3, 1.5))
    way_px = rng.uniform(0, MOTION_PX) * (rng.random() < MOVING)
    if way_px:
        image = smeared(image, way_px, rng.uniform(0, np.pi))
    image += rng.normal(0, rng.uniform(1, 6), image.shape)
    coded = cv2.imencode(".jpg", np.clip(image, 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 85])[1]
    return FlatScene(frame, np.asarray(cv2.imdecode(coded, cv2.IMREAD_COLOR), np.uint8), float(way_px))


def patchwork(size: tuple[int, int], kinds: int, rng: np.random.Generator) -> NDArray[np.int_]:
    """(height, width) which of several kinds lies where: each pixel is of the nearest of a few points' kind, half of
    these of the first."""
    points = rng.uniform((0, 0), size, (PATCHES, 2))
    kind = rng.integers(0, kinds, PATCHES) * (rng.random(PATCHES) < 0.5)
    pixels = np.stack(np.meshgrid(*map(np.arange, size)), axis=-1)
    off = np.stack([np.sum((pixels - point) ** 2, axis=-1) for point in points])
    return np.asarray(kind[np.argmin(off, axis=0)])


def cut(camera: Camera, objects: Sequence[PlacedObject], rng: np.random.Generator) -> Camera:
    """One that looks elsewhere, so that its border takes the required component of one object and leaves as many of the
    others as may be, two at least; the same where that can't be."""
    size, beyond = np.array(camera.size), rng.uniform(*BEYOND)
    most, best = 1, np.zeros(2)
    for placed in objects:
        model, poses = placed.target.model, component_poses(placed.target.model, placed.joints)
        middles = [
            (placed.T_camera_object @ poses[c.name]).apply(c.markers[0].centre[None])[0] for c in model.components
        ]
        root = model.components.index(model.required)
        px = project(camera, np.array(middles))
        far = beyond * np.sqrt(model.required.markers[0].area) * camera.focal_px / middles[root][2]
        for axis, wanted in ((0, -far), (0, size[0] + far), (1, -far), (1, size[1] + far)):
            shift = (wanted - px[root, axis]) * np.eye(2)[axis]
            left = int(((px + shift > 0) & (px + shift < size)).all(axis=1).sum())
            most, best = (left, shift) if left > most else (most, best)
    matrix = camera.matrix.copy()
    matrix[:2, 2] += best
    return replace(camera, matrix=matrix)


def strewn(frame: SimulatedFrame, rng: np.random.Generator, world: World) -> SimulatedFrame:
    """A frame with a few strays in it, in a share of the scenes, in half of which components of objects are hidden."""
    if rng.random() >= STREWN:
        return frame
    frame = shaded(frame, rng, float(rng.uniform(0, HIDDEN)) * (rng.random() < 0.5))
    return strays(frame, rng, world, int(rng.integers(1, STRAYS, endpoint=True)))


def strays(frame: SimulatedFrame, rng: np.random.Generator, world: World, count: int) -> SimulatedFrame:
    """A frame with at most so many patches that are like components of its objects, where nothing is: of those of
    several, for what is like all of an object is one."""
    markers = [(m, t.label if c.label is None else c.label) for t in world.targets if len(t.model.components) > 1
               for c in t.model.components for m in c.markers]  # fmt: skip
    if not markers:
        return frame
    area = world.targets[0].model.required.markers[0].area
    any_one = np.exp(rng.uniform(*np.log([LEAST_PX, MOST_PX]))) / np.sqrt(area)
    scale, labels = np.median(true_scales(frame.truths, frame) or [any_one]), frame.labels.copy()
    for _ in range(count):
        marker, label = markers[rng.integers(len(markers))]
        turn, size = rng.uniform(-np.pi, np.pi), scale * np.exp(rng.uniform(-AS_LARGE, AS_LARGE))
        R = np.array([[np.cos(turn), np.sin(turn)], [np.sin(turn), -np.cos(turn)]])
        outline = (marker.outline - marker.outline.mean(axis=0)) @ R * size + rng.uniform((0, 0), labels.shape[::-1])
        mask = np.zeros_like(labels)
        cv2.fillPoly(mask, [np.rint(outline).astype(np.int32)], 1)
        if not labels[cv2.dilate(mask, GAP) > 0].any():
            labels[mask > 0] = label
    return replace(frame, labels=labels)


def true_scales(truths: Sequence[ObjectTruth], frame: SimulatedFrame) -> list[float]:
    """Pixels per metre of the required components of objects."""
    out = []
    for placed in (truth.placed for truth in truths):
        model = placed.target.model
        T = placed.T_camera_object @ component_poses(model, placed.joints)[model.required.name]
        out.append(frame.camera.focal_px / T.apply(model.required.markers[0].centre[None])[0, 2])
    return out


def alone(frame: SimulatedFrame, rng: np.random.Generator) -> SimulatedFrame:
    """A frame with nothing more in it."""
    return frame


def flat_frames(
    world: World, seed: int, scenes: int, crowd: Callable[[SimulatedFrame, np.random.Generator], SimulatedFrame] = alone
) -> Iterator[FlatScene]:
    """Scenes of a world, each with a size, crowding, clutter and a segmentation of its own, seen from above; every
    second one is painted. :param crowd: what more is put into each."""
    colours = world_colours(seed)
    for number in range(scenes):
        rng, in_colour = np.random.default_rng([22, seed, number]), number % 2 == 1
        size, count = SIZES[rng.choice(len(SIZES), p=SHARES)], int(rng.integers(0, 11))
        least = np.exp(rng.uniform(np.log(max(12 / size[0], 0.021)), np.log(0.25 if rng.random() < 0.7 else 0.5)))
        scene = SceneConfig(
            objects=(count, count),
            size=(float(least), float(min(least * rng.uniform(1, 1.5), 0.6))),
            margin=float(rng.choice([1.0, 0.5, 0.0])),
            elevation_deg=(float(rng.choice([90.0, 80.0, 70.0])), 90.0),
            distractors=int(rng.choice([0, 3, 8])),
        )
        sensor = SensorConfig(spots=int(rng.choice([0, 10])), motion_blur_px=float(rng.choice([0.0, 2.0])))
        sensor = sensor.scaled(float(rng.choice([0.0, 0.5, 1.0, 1.5])) * (not in_colour))
        camera = pinhole_camera(size, 40)
        drawn = sample_scene([*world.targets, *world.strangers], camera, scene, rng)
        if rng.random() < CUT:
            camera = cut(camera, [p for p in drawn.objects if p.target in world.targets], rng)
        if rng.random() < 0.3:
            depth = max((p.T_camera_object.position[2] for p in drawn.objects), default=1.0)
            clutter = random_clutter(camera, LABELS[0], rng.uniform(0.05, 0.35), float(depth), rng)
            drawn = replace(drawn, distractors=(*drawn.distractors, *clutter))
        frame = crowd(render_frame(0, Renderer(camera), drawn, sensor, rng), rng)
        yield painted(frame, colours, rng) if in_colour else FlatScene(shaded(frame, rng))
