"""Scenes in which the objects move smoothly from frame to frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.base.config import param, validate
from ..core.geometry.camera import Camera
from ..core.geometry.transforms import Array, Pose, rotation_from_rotvec
from ..core.model.target import Target
from .config import SceneConfig, SensorConfig
from .render import Renderer
from .scene import PlacedObject, Scene, require_places, sample_scene
from .simulator import PERIOD_NS, SimulatedFrame, render_frame


@dataclass(frozen=True)
class MotionConfig:
    """How objects move. All of it is smooth and stays around where the scene put them."""

    speed: float = param(0.3, "greatest speed of an object along each axis of the floor", unit="m/s", low=0, high=10)
    reach: float = param(
        0.3, "how far an object goes from its first place, along each axis", unit="m", low=0.01, high=10
    )
    turn: float = param(0.5, "how far an object turns to either side", unit="rad", low=0, high=3.1416)
    swing_hz: float = param(0.4, "how often a joint goes through its range", unit="Hz", low=0, high=10)

    def __post_init__(self) -> None:
        validate(self, "motion.")


@dataclass(frozen=True)
class _Path:
    """One object's motion: a sine on each axis of the floor, of its turn and of its joints.

    :param rate: (3,) of x, y and turn, rad/s. :param phase: (3,) rad. :param joint_range: see `SceneConfig`.
    """

    start: PlacedObject
    motion: MotionConfig
    rate: Array
    phase: Array
    joint_range: float

    @classmethod
    def random(cls, start: PlacedObject, motion: MotionConfig, rng: np.random.Generator, joint_range: float) -> _Path:
        rate = 2 * motion.speed / motion.reach * rng.uniform(0.5, 1.0, 3)
        return cls(start, motion, rate, rng.uniform(-np.pi, np.pi, 3), joint_range)

    def at(self, time_s: float) -> PlacedObject:
        """Where the object is; at time 0 where the scene put it."""
        x, y, turn = np.sin(self.rate * time_s + self.phase) - np.sin(self.phase)
        reach, T = self.motion.reach / 2, self.start.T_camera_object
        heading = rotation_from_rotvec([0.0, 0.0, self.motion.turn / 2 * turn])
        moved = T @ Pose(heading, np.array([reach * x, reach * y, 0.0]))
        return replace(self.start, T_camera_object=moved, joints=self._joints(time_s))

    def _joints(self, time_s: float) -> dict[str, float]:
        joints = {}
        model = self.start.target.model
        for name, joint in model.joints.items():
            low, high = joint.span
            middle, half = (low + high) / 2, max(self.joint_range * (high - low) / 2, 1e-9)
            phase = np.arcsin(np.clip((self.start.joints[name] - middle) / half, -1, 1))
            swing = np.sin(2 * np.pi * self.motion.swing_hz * time_s + phase)
            joints[name] = float(middle + half * swing)
        return joints


def moving_scenes(
    start: Scene, motion: MotionConfig, rng: np.random.Generator, joint_range: float = 1.0
) -> Iterator[Scene]:
    """The scene as time goes on, a frame's period apart, without end; the first is `start` itself.

    :param joint_range: share of each joint's limits that is used, as where the scene was made.
    """
    paths = [_Path.random(placed, motion, rng, joint_range) for placed in start.objects]
    number = 0
    while True:
        time_s = number * PERIOD_NS * 1e-9
        yield replace(start, objects=tuple(path.at(time_s) for path in paths))
        number += 1


def simulate_motion(
    targets: Sequence[Target],
    camera: Camera,
    scene: SceneConfig,
    motion: MotionConfig,
    sensor: SensorConfig,
    seed: int,
    frames: int,
) -> Iterator[SimulatedFrame]:
    """Frames of one random scene whose objects move. Objects keep their order from frame to frame.

    :raises ConfigError: a target's model lacks a marker's place.
    """
    for target in targets:
        require_places(target.model)
    renderer = Renderer(camera)
    rng = np.random.default_rng(seed)
    scenes = moving_scenes(sample_scene(targets, camera, scene, rng), motion, rng, scene.joint_range)
    for index, made in zip(range(frames), scenes, strict=False):
        yield render_frame(index, renderer, made, sensor, rng)
