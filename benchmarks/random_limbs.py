"""Limbs made up at random, of patches in a row on joints, and label images of them: what `benchmarks/left_over.py` fits
and measures on.

Some are as their model says, some a little longer or shorter here and there, and some swing out of the plane, so that
links look much shorter. Patches are lost, hidden or beyond the border, and things of their colours lie about, in some
worlds none, in others several. Half of the worlds are seen by a camera of known calibration.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array, Pose, rotation_from_rotvec
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target

SIZE, FOCAL_PX = (480, 320), 520.0
CLASSES = (1, 2, 3, 4, 5)
JOINTED, ROUND, DISTINCT = (
    0.8,
    0.6,
    0.7,
)  # shares of links on joints, of patches that are discs, of worlds without twins
EXACT, OFF = (
    0.4,
    0.3,
)  # shares of the worlds with exact lengths, and with such as are off by up to MOST_OFF; others swing
MOST_OFF, MOST_SWING = 0.15, np.pi / 3
LOST = 0.12  # share of patches that are not seen
STRAYS = (0.0, 0.0, 0.3, 1.5)  # of each class in an image, on average, world by world


class Limb(NamedTuple):
    """One in the image. :param joints: their true values. :param directions: of its first axis in the image, rad.
    :param at: (2,) pixels of its first patch."""

    joints: dict[str, float]
    direction: float
    at: Array


class LimbWorld(NamedTuple):
    """A target, and how those are that it is made of. :param camera: the one that sees it, which lies flat without
    calibration where `known` is false."""

    target: Target
    camera: Camera
    known: bool
    kind: str
    strays: float
    px_per_m: float


def limb_world(seed: int) -> LimbWorld:
    rng = np.random.default_rng([31, seed])
    n, twins = int(rng.integers(3, 6)), rng.random() >= DISTINCT
    labels = rng.permutation(CLASSES)[:n]
    if twins:
        labels[int(rng.integers(1, n))] = labels[int(rng.integers(0, n))]
    model = _model(rng, labels, rng.uniform(0.4, 1.0, n))
    kind = str(rng.choice(["exact", "off", "swinging"], p=[EXACT, OFF, 1 - EXACT - OFF]))
    known = bool(rng.random() < 0.5)
    target, px_per_m = Target("limb", model, int(labels[0])), float(rng.uniform(60, 130))
    return LimbWorld(target, Camera.pinhole(SIZE, FOCAL_PX), known, kind, float(rng.choice(STRAYS)), px_per_m)


def _model(rng: np.random.Generator, labels: NDArray[np.int_], lengths: Array) -> ObjectModel:
    """A row of links, with a patch at the end of each but the first, which bears one at its begin."""
    radius, parts, parent = rng.uniform(0.08, 0.12), list[Component](), ""
    for k, (label, length) in enumerate(zip(labels.tolist(), lengths.tolist(), strict=True)):
        at = np.array([length * (k > 0), 0, 0])
        marker = _disc(radius, at) if rng.random() < ROUND else _bar(radius, at)
        origin = Pose(np.eye(3), np.array([lengths[k - 1] * (k > 1), 0, 0]))
        if k == 0:
            joint = None
        elif rng.random() < JOINTED and not (k == 1 and parts[0].markers[0].disc_radius):  # a disc tells no turn
            middle, half = rng.uniform(-0.8, 0.8), rng.uniform(0.5, 1.5)
            joint = Joint(parent, origin, np.array([0.0, 0.0, 1.0]), middle - half, middle + half)
        else:
            turn = Pose(rotation_from_rotvec([0, 0, rng.uniform(-1, 1)]), origin.position)
            joint = Joint(parent, turn, np.array([0.0, 0.0, 1.0]), 0.0, 0.0, "fixed")
        parent = f"c{k}"
        parts.append(Component(parent, (marker,), k == 0, None if k == 0 else int(label), joint))
    return ObjectModel("limb", tuple(parts))


def _disc(radius: float, at: Array) -> Marker:
    angles = 2 * np.pi * np.arange(24) / 24
    outline = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return Marker("m", outline, np.array([-radius, 0]), np.array([radius, 0]), radius, Pose(np.eye(3), at))


def _bar(radius: float, at: Array) -> Marker:
    outline = radius * np.array([(-1.5, -0.7), (1.5, -0.7), (1.5, 0.7), (-1.5, 0.7)])
    return Marker("m", outline, radius * np.array([-1.5, 0]), radius * np.array([1.5, 0]), None, Pose(np.eye(3), at))


def limb_scene(world: LimbWorld, seed: int, number: int) -> tuple[NDArray[np.uint8], list[Limb]]:
    """(H, W) labels, and the limbs in them: one or none, at times two."""
    rng = np.random.default_rng([32, seed, number])
    labels, limbs, model = np.zeros(SIZE[::-1], np.uint8), list[Limb](), world.target.model
    _draw_strays(labels, world, rng)
    for _ in range(int(rng.choice([0, 1, 2], p=[0.1, 0.7, 0.2]))):
        limbs.append(_draw_limb(labels, world, model, rng))
    noise = rng.random(labels.shape)
    labels[noise < rng.choice([0.0, 0.02])] = 0
    return labels, limbs


def _draw_limb(labels: NDArray[np.uint8], world: LimbWorld, model: ObjectModel, rng: np.random.Generator) -> Limb:
    n = len(model.components)
    stretch = np.ones(n)
    if world.kind == "off":
        stretch = 1 + rng.uniform(-MOST_OFF, MOST_OFF, n)
    elif world.kind == "swinging":
        stretch = np.where(rng.random(n) < 0.6, np.cos(rng.uniform(0, MOST_SWING, n)), 1.0)
    kin = Kinematics(model)
    q = rng.uniform(kin.lower, kin.upper)
    depth = FOCAL_PX / world.px_per_m * rng.uniform(0.9, 1.1)
    tilt = rng.uniform(-0.5, 0.5, 2) if world.known else rng.uniform(-0.15, 0.15, 2)
    R = (
        rotation_from_rotvec([*tilt, 0])
        @ rotation_from_rotvec([0, 0, rng.uniform(-np.pi, np.pi)])
        @ np.diag([1.0, -1, -1])
    )
    at_px = rng.uniform(0, SIZE)
    t = np.array([*((at_px - np.array(SIZE) / 2) / FOCAL_PX), 1.0]) * depth
    ends = _ends(model, q, stretch)
    for (turn, place), component in reversed(list(zip(ends, model.components, strict=True))):
        if rng.random() < LOST and not component.required:
            continue
        outline = component.markers[0].outline
        X = np.column_stack([outline, np.zeros(len(outline))]) @ turn.T + place
        _fill(labels, project(world.camera, X @ R.T + t), component.label or world.target.label)
    axis = project(world.camera, np.array([[0, 0, 0], [0.1, 0, 0]]) @ R.T + t)
    way = axis[1] - axis[0]
    return Limb(dict(zip(model.joint_names, q.tolist(), strict=True)), float(np.arctan2(way[1], way[0])), axis[0])


def _ends(model: ObjectModel, q: Array, stretch: Array) -> list[tuple[Array, Array]]:
    """Turn and place of each patch in the object's frame, where each link is so many times as long as modelled."""
    out, R, t, joints = list[tuple[Array, Array]](), np.eye(3), np.zeros(3), iter(q.tolist())
    for k, component in enumerate(model.components):
        if component.joint is not None:
            T = component.joint.T_parent_joint
            t = t + R @ (T.position * stretch[k - 1])
            R = R @ T.rotation
            R = R if component.joint.kind == "fixed" else R @ rotation_from_rotvec([0, 0, next(joints)])
        place = component.markers[0].T_component_marker
        assert place is not None
        out.append((R, t + R @ (place.position * stretch[k])))
    return out


def _draw_strays(labels: NDArray[np.uint8], world: LimbWorld, rng: np.random.Generator) -> None:
    for component in world.target.model.components:
        outline = component.markers[0].outline * world.px_per_m
        for _ in range(int(rng.poisson(world.strays))):
            c, s = np.cos(a := rng.uniform(0, 2 * np.pi)), np.sin(a)
            placed = rng.uniform(0.6, 1.5) * outline @ np.array([[c, s], [-s, c]]) + rng.uniform((0, 0), SIZE)
            _fill(labels, placed, component.label or world.target.label)


def _fill(labels: NDArray[np.uint8], outline: Array, label: int) -> None:
    cv2.fillPoly(labels, [np.rint(outline * 16).astype(np.int32)], label, shift=4)
