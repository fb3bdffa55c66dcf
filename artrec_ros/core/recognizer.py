"""The whole method for one image: labels, blobs, alignment, grouping."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .alignment import ContourMap
from .blobs import Blob, find_blobs
from .candidates import ShapeOf, candidates_of
from .config import RecognizerConfig
from .constraints import ConstraintSet
from .datatypes import Camera, Detection, FrameResult, Rejection, Target
from .deadline import Deadline
from .errors import ConfigError
from .grouping import GroupSearch
from .matching import Matches, find_matches
from .paper import align_literally, group_literally
from .report import detections_of, rejections_of
from .shapes import Shape
from .solution import solve

_ALIGNMENT = 0.7  # of the time that is left may go into alignment


class Labeller(Protocol):
    """What turns an image into class labels: `segmentation.Segmenter`."""

    @property
    def blank(self) -> tuple[int, ...]:
        """Ignored rectangles x,y,width,height,..."""

    def labels(self, image: NDArray) -> NDArray[np.uint8]:
        """(H, W) class numbers."""


class Stopwatch:
    """Milliseconds per named stage."""

    def __init__(self) -> None:
        self._start = time.perf_counter()
        self.ms = dict.fromkeys(("segmentation", "blobs", "alignment", "grouping", "pose", "total"), 0.0)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.ms[name] += 1e3 * (time.perf_counter() - start)

    def stop(self) -> dict[str, float]:
        self.ms["total"] = 1e3 * (time.perf_counter() - self._start)
        return self.ms


class Recognizer:
    """Finds objects in images. Models are made ready once; nothing is remembered between images."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig, segmenter: Labeller) -> None:
        """:raises ConfigError: two targets of one name, or constraints that are not the target's model's."""
        self._targets = tuple(targets)
        self._config = config
        self._segmenter = segmenter
        names = [t.name for t in self._targets]
        if len(set(names)) != len(names):
            raise ConfigError(f"objects: {', '.join(names)}: each needs a name of its own")
        for target in self._targets:
            if isinstance(target.constraints, ConstraintSet):
                target.constraints.check_model(target.model)
        self._shapes, self._shape_of = _distinct_shapes(self._targets)
        self._wanted = {
            (self._shape_of[n][c.name, m.name], target.label if c.label is None else c.label)
            for n, target in enumerate(self._targets)
            for c in target.model.components
            for m in c.markers
        }

    def recognize(self, image: NDArray, camera: Camera | None = None) -> FrameResult:
        """All objects in one image.

        :param image: as the segmenter reads it.
        :param camera: calibration; without it no metric poses.
        :raises ImageError: the image does not fit the segmenter's configuration.
        """
        watch = Stopwatch()
        deadline = Deadline(self._config.time_budget_ms / 1e3)
        with watch.stage("segmentation"):
            labels = self._segmenter.labels(image)
        with watch.stage("blobs"):
            blobs = find_blobs(labels, {label for _, label in self._wanted}, self._config, self._segmenter.blank)
        with watch.stage("alignment"):
            matches = self._align(blobs, (labels.shape[1], labels.shape[0]), deadline.part(_ALIGNMENT))
        with watch.stage("grouping"):
            detections, rejected, exact = self._group(matches, deadline)
        size = (int(labels.shape[1]), int(labels.shape[0]))
        return FrameResult(size, detections, rejected, watch.stop(), exact and not deadline.hit, labels)

    def _align(self, blobs: tuple[Blob, ...], size: tuple[int, int], deadline: Deadline) -> Matches:
        if not blobs:
            return Matches.none(self._shapes)
        if self._config.profile == "paper":
            return align_literally(blobs, size, self._shapes, self._wanted, self._config, deadline)
        cmap = ContourMap.build(blobs, size)
        return find_matches(blobs, cmap, self._shapes, self._wanted, self._config, deadline, self._segmenter.blank)

    def _group(self, matches: Matches, deadline: Deadline) -> tuple[tuple[Detection, ...], tuple[Rejection, ...], bool]:
        if not len(matches):
            return (), (), True
        if self._config.profile == "paper":
            groups = [
                g
                for target, shape_of in zip(self._targets, self._shape_of, strict=True)
                for g in group_literally(target, shape_of, matches, self._config, deadline)
            ]
            return detections_of(groups, matches, self._targets), (), True
        searches = [
            GroupSearch(candidates_of(target, shape_of, matches, self._config), matches, self._config, deadline)
            for target, shape_of in zip(self._targets, self._shape_of, strict=True)
        ]
        solution = solve(searches, matches, self._config, deadline)
        detections = detections_of(solution.accepted, matches, self._targets)
        return detections, rejections_of(solution, searches, matches, self._config), solution.exact


def _distinct_shapes(targets: tuple[Target, ...]) -> tuple[list[Shape], list[ShapeOf]]:
    """Each outline once, however many components and targets show it, and which one each marker has."""
    shapes: list[Shape] = []
    number: dict[bytes, int] = {}
    shape_of: list[ShapeOf] = []
    for target in targets:
        mine: ShapeOf = {}
        for component in target.model.components:
            for marker in component.markers:
                shape = Shape.from_marker(marker)
                key = shape.key()
                if key not in number:
                    number[key] = len(shapes)
                    shapes.append(shape)
                mine[component.name, marker.name] = number[key]
        shape_of.append(mine)
    return shapes, shape_of
