"""Is a part on a joint where it is told as often as its score says, where another blob like it lies in its reach?

Drawn arms of one to three joints, sliders, and animals of four legs of one class, each with a second patch of one of
its parts' classes: its like in reach, of another size, partly covered, or beyond the joints' limits. Half of the worlds
are seen by a camera of known calibration.

python benchmarks/other_blobs.py --save found.npz [--first 0] [--worlds 60] [--scenes 12]
python benchmarks/other_blobs.py --load found.npz [more.npz ...]
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from acceptance_fit import tell
from kept_rows import rows_of
from numpy.typing import NDArray
from tqdm import tqdm

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array, Pose, rotation_from_rotvec
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

SIZE, FOCAL_PX, PX_PER_M = (480, 360), 520.0, 100.0
KINDS = "arm", "slider", "animal"
GRADES = "none", "alike", "size", "covered", "beyond"  # of the second patch
WIDER = 0.15  # logarithm, by which limits of the scale are wider than the world's
COLUMNS = "world", "space", "kind", "grade", "score", "right", "whole", "as_told"
Z = np.array([0.0, 0, 1])


class World(NamedTuple):
    """:ivar known: whether the camera's calibration is."""

    kind: str
    target: Target
    known: bool


class Scene(NamedTuple):
    """:ivar at: (C, 2) pixels of the components. :ivar part: the component of which there is another."""

    labels: NDArray[np.uint8]
    at: Array
    part: int
    grade: str


def world_of(seed: int) -> World:
    rng = np.random.default_rng([71, seed])
    kind = KINDS[seed % len(KINDS)]
    model = {"arm": _arm, "slider": _slider, "animal": _animal}[kind](rng)
    return World(kind, Target(kind, model, 1), bool(rng.random() < 0.5))


def _arm(rng: np.random.Generator) -> ObjectModel:
    n, labels = int(rng.integers(1, 4)), rng.permutation([2, 3, 4])
    parts, parent, reach = [_root(rng, turns=True)], "c0", 0.55
    for k in range(n):
        origin, reach = Pose(np.eye(3), np.array([reach, 0, 0])), rng.uniform(0.45, 0.8)
        middle, half = rng.uniform(-0.5, 0.5), rng.uniform(0.5, 1.5)
        joint = Joint(parent, origin, Z, middle - half, middle + half)
        parent = f"c{k + 1}"
        parts.append(Component(parent, (_patch(rng, np.array([reach, 0, 0])),), False, int(labels[k]), joint))
    return ObjectModel("arm", tuple(parts))


def _slider(rng: np.random.Generator) -> ObjectModel:
    far, way = rng.uniform(0.9, 1.2), rng.uniform(0.25, 0.6)
    joint = Joint("c0", Pose(np.eye(3), np.array([far, 0, 0])), np.array([1.0, 0, 0]), -way, way, "prismatic")
    root = _root(rng, turns=bool(rng.random() < 0.5))
    return ObjectModel("slider", (root, Component("c1", (_patch(rng, np.zeros(3)),), False, 2, joint)))


def _animal(rng: np.random.Generator) -> ObjectModel:
    parts, width = [_root(rng, turns=True)], rng.uniform(0.25, 0.4)
    marker = _patch(rng, np.array([0.35, 0, 0]))
    for k, (x, side) in enumerate(((0.5, 1), (0.5, -1), (-0.5, 1), (-0.5, -1))):
        turn = Pose(rotation_from_rotvec(Z * side * np.pi / 2), np.array([x, side * width, 0]))
        parts.append(Component(f"c{k + 1}", (marker,), False, 2, Joint("c0", turn, Z, -0.7, 0.7)))
    return ObjectModel("animal", tuple(parts))


def _root(rng: np.random.Generator, *, turns: bool) -> Component:
    if not turns:
        return Component("c0", (_disc(0.14, np.zeros(3)),), True)
    outline = np.array([(-0.5, -0.16), (0.3, -0.16), (0.5, 0.0), (0.3, 0.16), (-0.5, 0.16)]) * rng.uniform(0.8, 1.1)
    return Component("c0", (Marker("m", outline, outline[0] * [1, 0], outline[2], None, Pose.identity()),), True)


def _patch(rng: np.random.Generator, at: Array) -> Marker:
    radius = rng.uniform(0.08, 0.14)
    if rng.random() < 0.6:
        return _disc(radius, at)
    outline = radius * np.array([(-1.5, -0.7), (1.5, -0.7), (1.5, 0.7), (-1.5, 0.7)])
    return Marker("m", outline, radius * np.array([-1.5, 0]), radius * np.array([1.5, 0]), None, Pose(np.eye(3), at))


def _disc(radius: float, at: Array) -> Marker:
    angles = 2 * np.pi * np.arange(24) / 24
    outline = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return Marker("m", outline, np.array([-radius, 0]), np.array([radius, 0]), radius, Pose(np.eye(3), at))


def scene_of(world: World, seed: int, number: int) -> Scene:
    """One object with all of its parts in view, and another patch like one of them."""
    rng = np.random.default_rng([72, seed, number])
    model, camera = world.target.model, Camera.pinhole(SIZE, FOCAL_PX)
    kin, grade = Kinematics(model), GRADES[number % len(GRADES)]
    part = int(rng.integers(1, len(model.components)))
    for _ in range(200):
        R, t, q = _placed(world, rng)
        outlines = _outlines(model, kin, camera, R, t, q)
        other = kin.bound(rng.uniform(kin.lower, kin.upper))
        if grade == "beyond":
            moved = kin.joint_of[part]
            other = q.copy()
            other[moved] = rng.choice(
                [kin.lower[moved] - rng.uniform(0.25, 0.6), kin.upper[moved] + rng.uniform(0.25, 0.6)]
            )
        if world.kind == "arm":  # what carries it is where it is
            other = np.where(np.arange(len(q)) == kin.joint_of[part], other, q)
        turn = R
        if model.required.markers[0].disc_radius:
            turn = R @ rotation_from_rotvec(Z * rng.uniform(0.5, 2 * np.pi - 0.5))
        second = _outlines(model, kin, camera, turn, t, other)[part]
        if grade == "size":
            second = second.mean(axis=0) + (second - second.mean(axis=0)) * np.exp(
                rng.choice([-1, 1]) * rng.uniform(0.08, 0.4)
            )
        every = outlines if grade == "none" else [*outlines, second]
        if _clear(every):
            break
    labels = np.zeros(SIZE[::-1], np.uint8)
    for component, outline in zip(model.components, outlines, strict=True):
        _fill(labels, outline, component.label or 1)
    if grade != "none":
        _fill(labels, second, model.components[part].label or 1)
    if grade == "covered":
        _cover(labels, second, rng)
    noise = rng.random(labels.shape)
    labels[noise < rng.choice([0.0, 0.02])] = 0
    if rng.random() < 0.5:
        labels = _ragged(labels, rng)
    return Scene(labels, np.array([o.mean(axis=0) for o in outlines]), part, grade)


def _placed(world: World, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    kin = Kinematics(world.target.model)
    tilt = rng.uniform(-0.4, 0.4, 2) if world.known else rng.uniform(-0.1, 0.1, 2)
    flat = rotation_from_rotvec([0, 0, rng.uniform(-np.pi, np.pi)]) @ np.diag([1.0, -1, -1])
    depth = FOCAL_PX / PX_PER_M * rng.uniform(0.9, 1.1)
    at = (rng.uniform(0.25, 0.75, 2) - 0.5) * SIZE / FOCAL_PX
    return rotation_from_rotvec([*tilt, 0]) @ flat, np.array([*at, 1.0]) * depth, rng.uniform(kin.lower, kin.upper)


def _outlines(model: ObjectModel, kin: Kinematics, camera: Camera, R: Array, t: Array, q: Array) -> list[Array]:
    frames, out = kin.forward(R[None], t[None], q[None]), list[Array]()
    for c, component in enumerate(model.components):
        place = component.markers[0].T_component_marker
        assert place is not None
        outline = np.column_stack([component.markers[0].outline, np.zeros(len(component.markers[0].outline))])
        out.append(project(camera, (outline + place.position) @ frames.R[0, c].T + frames.t[0, c]))
    return out


def _clear(outlines: Sequence[Array]) -> bool:
    """Whether all are in view and none touches another."""
    drawn = np.zeros(SIZE[::-1], np.uint8)
    for outline in outlines:
        one = np.zeros_like(drawn)
        _fill(one, outline, 1)
        if (
            (outline < 4).any()
            or (outline > np.array(SIZE) - 5).any()
            or (drawn & cv2.dilate(one, np.ones((7, 7)))).any()
        ):
            return False
        drawn |= one
    return True


def _cover(labels: NDArray[np.uint8], outline: Array, rng: np.random.Generator) -> None:
    """A half-plane takes a tenth to a half of what it covers."""
    way = np.array([np.cos(a := rng.uniform(0, 2 * np.pi)), np.sin(a)])
    (low, high), box = (np.floor(outline.min(axis=0)) - 2, np.ceil(outline.max(axis=0)) + 2), labels
    y, x = np.mgrid[int(low[1]) : int(high[1]) + 1, int(low[0]) : int(high[0]) + 1]
    least = np.quantile(outline @ way, 1 - rng.uniform(0.1, 0.5))
    box[y, x] = np.where(x * way[0] + y * way[1] > least, 0, box[y, x])


def _ragged(labels: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Borders that lie a little elsewhere."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]].astype(np.float32)
    by = [cv2.GaussianBlur(rng.normal(0, 1, labels.shape).astype(np.float32), (0, 0), 3) * 6 for _ in range(2)]
    return cv2.remap(labels, x + by[0], y + by[1], cv2.INTER_NEAREST)


def _fill(labels: NDArray[np.uint8], outline: Array, label: int) -> None:
    cv2.fillPoly(labels, [np.rint(outline * 16).astype(np.int32)], label, shift=4)


def recognizer(world: World) -> Recognizer:
    scale = {"min_scale": PX_PER_M * np.exp(-WIDER), "max_scale": PX_PER_M * np.exp(WIDER)}
    config = RecognizerConfig(**scale, time_budget_ms=60000.0)
    return Recognizer((world.target,), config, Segmenter(ImageConfig()), calibrated=world.known)


def watch(first: int, worlds: int, scenes: int) -> Array:
    """(n, columns) of the parts of which there is another, of objects that are told."""
    rows = list[list[float]]()
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        world = world_of(number)
        engine = recognizer(world)
        for n in range(scenes):
            scene = scene_of(world, number, n)
            camera = Camera.pinhole(SIZE, FOCAL_PX) if world.known else None
            for d in engine.recognize(scene.labels, camera).detections:
                rows += _rows(number, world, scene, d)
    return np.array(rows)


def _rows(number: int, world: World, scene: Scene, d: Detection) -> list[list[float]]:
    """Those of one detection, if it is the object. Of an animal a second patch may be any leg of its side."""
    radius = np.sqrt([c.markers[0].area / np.pi for c in world.target.model.components]) * PX_PER_M
    names = [c.name for c in world.target.model.components]
    head = [world.known, KINDS.index(world.kind), GRADES.index(scene.grade)]
    if np.hypot(d.image.x - scene.at[0, 0], d.image.y - scene.at[0, 1]) > radius[0]:
        return []
    off = {p.component: np.hypot(*(scene.at[names.index(p.component)] - (p.x, p.y))) for p in d.components}
    right = {name: off[name] < radius[names.index(name)] for name in off}
    return [
        [number, *head, p.score, right[p.component], all(right.values()), d.as_told]
        for p in d.components
        if p.component != "c0" and (world.kind == "animal" or names[scene.part] == p.component)
    ]


def main() -> None:
    rows = rows_of(__doc__, COLUMNS, watch, 60, 10)
    for g, grade in enumerate(GRADES):
        some = rows["grade"] == g
        tell(f"{grade}: parts of a class of which there is another", rows["score"][some], rows["right"][some])
    tell("all with another", rows["score"][rows["grade"] > 0], rows["right"][rows["grade"] > 0])


if __name__ == "__main__":
    main()
