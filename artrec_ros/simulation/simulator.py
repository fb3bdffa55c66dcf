"""Frames of random scenes, one after another, each with its truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..core.geometry.camera import Camera
from ..core.model.target import Target
from .config import SceneConfig, SensorConfig
from .render import Renderer
from .scene import Scene, require_places, sample_scene
from .sensor import colour_image, label_image
from .truth import ObjectTruth, measure

START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 33_333_333  # 30 frames a second


@dataclass(frozen=True)
class SimulatedFrame:
    """One frame: images as the camera and its segmenter give them, and the truth.

    :param labels: (H, W) class labels.
    :param colour: (H, W, 3) BGR.
    """

    index: int
    camera: Camera
    scene: Scene
    labels: NDArray[np.uint8]
    colour: NDArray[np.uint8]
    truths: tuple[ObjectTruth, ...]

    @property
    def stamp_ns(self) -> int:
        return START_NS + self.index * PERIOD_NS


def simulate(
    targets: Sequence[Target], camera: Camera, scene: SceneConfig, sensor: SensorConfig, seed: int, frames: int
) -> Iterator[SimulatedFrame]:
    """Frames of random scenes of these objects. Frame i depends on the seed and i alone, not on how many follow.

    :raises ConfigError: a target's model lacks a marker's place.
    """
    for target in targets:
        require_places(target.model)
    renderer = Renderer(camera)
    for index, child in enumerate(np.random.SeedSequence(seed).spawn(frames)):
        rng = np.random.default_rng(child)
        yield render_frame(index, renderer, sample_scene(targets, camera, scene, rng), sensor, rng)


def render_frame(
    index: int, renderer: Renderer, scene: Scene, sensor: SensorConfig, rng: np.random.Generator
) -> SimulatedFrame:
    """What the camera and its segmenter make of a scene, and the truth."""
    rendering = renderer.render(scene)
    colour = colour_image(rendering, sensor, rng)
    labels = label_image(rendering, colour, sensor, rng)
    truths = measure(rendering, scene.objects, renderer.camera)
    return SimulatedFrame(index, renderer.camera, scene, labels, colour, truths)


def pinhole_camera(size: tuple[int, int], view_angle_deg: float) -> Camera:
    """A camera without distortion whose image is `view_angle_deg` wide, its axis through the image's centre."""
    focal_px = size[0] / 2 / np.tan(np.radians(view_angle_deg) / 2)
    return Camera.pinhole(size, float(focal_px), "camera_optical_frame")
