"""Scenes, and how long each method takes on them."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray
from rivals import aruco, contours_alone, generalized_hough, with_tags

from artrec_ros.core.constraints.constraint_set import ConstraintSet
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.parameters.parameter_file import Setup
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import pinhole_camera, simulate

APPARENT = (0.16, 0.2)  # objects' diameters as shares of the image's width: eight have room
PATCH = 0.04  # the same for a soccer robot's patch
SCENES = 3  # of each kind; a median is over all of their frames
REPEATS, SPACE_REPEATS, SLOW_REPEATS = 20, 6, 2
STAGES = ("segmentation", "blobs", "alignment", "grouping", "pose")


@dataclass(frozen=True)
class Scene:
    """One image as its segmenter, and as a camera, gives it. :param objects: 0 for noise."""

    objects: int
    labels: NDArray[np.uint8]
    colour: NDArray[np.uint8]
    camera: Camera


@dataclass(frozen=True)
class Times:
    """Milliseconds.

    :param stages: medians by stage; found: objects a frame; incomplete: share of frames that the time budget ended.
    """

    median: float
    p99: float
    stages: dict[str, float]
    found: float = 0.0
    incomplete: float = 0.0


def scenes(setup: Setup, size: tuple[int, int], objects: int, seed: int) -> Iterator[Scene]:
    camera = pinhole_camera(size, 60.0)
    look = SceneConfig(objects=(objects, objects), size=APPARENT, facing=1.0, distractors=0)
    for frame in simulate(setup.targets, camera, look, SensorConfig(), seed, SCENES):
        yield Scene(objects, frame.labels, frame.colour, camera)


def overhead_scenes(setup: Setup, size: tuple[int, int], objects: int, seed: int) -> Iterator[Scene]:
    """Soccer robots drawn flat: a team's patch and the accent where the constraint's middle has it."""
    rng = np.random.default_rng(seed)
    camera = pinhole_camera(size, 60.0)
    columns = int(np.ceil(np.sqrt(objects * size[0] / size[1])))
    cell = np.array([size[0] / columns, size[1] / np.ceil(objects / columns)])
    for _ in range(SCENES):
        labels = np.zeros(size[::-1], np.uint8)
        for n in range(objects):
            centre = (np.array([n % columns, n // columns]) + rng.uniform(0.4, 0.6, 2)) * cell
            _draw_robot(labels, setup.targets[n % len(setup.targets)], complex(*centre), rng.uniform(-np.pi, np.pi))
        grey = np.where(labels > 0, 60 + 50 * labels, 128)[..., None] + rng.normal(0, 6, (*labels.shape, 3))
        yield Scene(objects, labels, np.clip(grey, 0, 255).astype(np.uint8), camera)


def _draw_robot(labels: NDArray[np.uint8], target: Target, centre: complex, theta: float) -> None:
    """Two patches, joined as the only constraint has it. Drawn to 1/16 px."""
    assert isinstance(target.constraints, ConstraintSet)
    (pair,) = target.constraints.pairs
    middle = {d: (i.low + i.high) / 2 for d, i in pair.allowed.items()}
    patches = {c.name: (c.markers[0], c.label or target.label) for c in target.model.components}
    side_m = float(np.ptp(patches[pair.first[0]][0].outline[:, 0]))
    scale = PATCH * labels.shape[1] / side_m  # px / m
    place = scale * middle["distance_m"] * np.exp(1j * (theta + middle["bearing_rad"]))
    for key, at, angle in ((pair.first, centre, theta), (pair.second, centre + place, theta + middle["turn_rad"])):
        marker, label = patches[key[0]]
        corners = at + scale * (marker.image_outline @ np.array([1, 1j])) * np.exp(1j * (angle - marker.axis_angle))
        points = np.rint(16 * np.stack([corners.real, corners.imag], axis=1)).astype(np.int32)
        cv2.fillPoly(labels, [points], label, shift=4)


def noise(size: tuple[int, int], seed: int) -> Scene:
    """Every pixel one of eight classes by chance."""
    rng = np.random.default_rng(seed)
    labels = rng.integers(0, 8, size[::-1], dtype=np.uint8)
    return Scene(0, labels, rng.integers(0, 256, (*size[::-1], 3), dtype=np.uint8), pinhole_camera(size, 60.0))


def measure(works: list[Callable[[], object]], repeats: int, threads: int = 1) -> Times:
    """All runs of all works together, after one of each that is not counted."""
    cv2.setNumThreads(threads)
    clock = time.process_time if threads == 1 else time.perf_counter
    spent: list[float] = []
    results: list[FrameResult] = []
    for work in works:
        work()
        for _ in range(repeats):
            start = clock()
            result = work()
            spent.append(1e3 * (clock() - start))
            if isinstance(result, FrameResult):
                results.append(result)
    stages = {s: float(np.median([r.timing_ms[s] for r in results])) for s in STAGES} if results else {}
    incomplete = float(np.mean(["recognizer.time_budget_ms" in r.ended_by for r in results])) if results else 0.0
    found = float(np.mean([len(r.detections) for r in results])) if results else 0.0
    return Times(float(np.median(spent)), float(np.percentile(spent, 99)), stages, found, incomplete)


@dataclass(frozen=True)
class Bench:
    """Everything that is run on one kind of scene."""

    scenes: list[Scene]
    setup: Setup

    @property
    def classes(self) -> list[int]:
        return sorted({c.label or t.label for t in self.setup.targets for c in t.model.components})

    def plane(self, threads: int = 1, **changes: object) -> Times:
        """Recognition without calibration; `changes` to the recogniser's parameters."""
        engine = self._recognizer(**changes)
        return measure([partial(engine.recognize, s.labels) for s in self.scenes], REPEATS, threads)

    def space(self, threads: int = 1) -> Times:
        engine = self._recognizer()
        works: list[Callable[[], object]] = [partial(engine.recognize, s.labels, s.camera) for s in self.scenes]
        return measure(works, SPACE_REPEATS, threads)

    def floor(self) -> Times:
        return measure([contours_alone(s.labels, self.classes) for s in self.scenes], REPEATS)

    def aruco(self, rng: np.random.Generator) -> tuple[Times, float]:
        """And how many of a scene's tags are found, on average."""
        works, found = zip(*(aruco(with_tags(s.colour, s.objects, rng)) for s in self.scenes), strict=True)
        return measure(list(works), REPEATS), float(np.mean(found))

    def hough(self) -> Times:
        required = self.setup.targets[0].model.required.markers[0]
        return measure([generalized_hough(s.labels, self.classes, required) for s in self.scenes], SLOW_REPEATS)

    def _recognizer(self, **changes: object) -> Recognizer:
        changed = dataclasses.replace(self.setup.recognizer, **changes)  # type: ignore[arg-type]
        return dataclasses.replace(self.setup, recognizer=changed).build()
