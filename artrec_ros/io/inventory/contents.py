"""What files and folders hold, as far as `inventory.py` looks into them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...core.geometry.camera import Camera
from ...core.model.objects import ObjectModel
from ..bags.reader import Topic
from ..images.decoding import Image
from ..learned.annotations import Annotations
from ..parameters.parameter_file import Setup


@dataclass(frozen=True)
class Sample:
    """A few images of one topic or folder.

    :param camera: the calibration beside them; None: none that can be used, and `camera_problem` says why.
    :param lossy: some are JPEG files.
    :param passed_over: what lies beside the images of a folder and is not read; empty: nothing.
    """

    name: str
    count: int
    images: tuple[Image, ...] = field(repr=False)
    problems: tuple[str, ...] = ()
    camera: Camera | None = None
    camera_problem: str | None = None
    passed_over: str = ""
    lossy: bool = False

    @property
    def size(self) -> tuple[int, int] | None:
        """(width, height) of the first."""
        return (self.images[0].shape[1], self.images[0].shape[0]) if self.images else None

    @property
    def channels(self) -> int:
        """1 or 3; 0: none could be read."""
        return 0 if not self.images else 1 if self.images[0].ndim == 2 else 3

    @property
    def labels(self) -> Mapping[int, int]:
        """label -> how many of the images show it; of label images alone."""
        shown = [set(np.unique(i).tolist()) for i in self.images if i.ndim == 2]
        return dict(sorted(Counter(v for values in shown for v in values).items()))


@dataclass(frozen=True)
class BagContent:
    """A bag. :param samples: of its image topics. :param problems: a line for each."""

    topics: tuple[Topic, ...]
    duration_s: float
    samples: tuple[Sample, ...]
    problems: tuple[str, ...]


@dataclass(frozen=True)
class ConstraintContent:
    """A constraint file. :param pairs: how many it has. :param classes: their names."""

    object: str
    coverage: float
    pairs: int
    classes: tuple[str, ...]


@dataclass(frozen=True)
class TruthContent:
    """A file of truth. :param stamps: of its frames, ns. :param labels: label -> objects that have it."""

    frames: int
    stamps: frozenset[int]
    labels: Mapping[int, int]


@dataclass(frozen=True)
class ResultContent:
    """Results of a replay. :param stamps: of its frames, ns. :param objects: name -> how many were found."""

    frames: int
    stamps: frozenset[int]
    objects: Mapping[str, int]


@dataclass(frozen=True)
class Report:
    """A file that is told of in a few lines. :param kind: with its article."""

    kind: str
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Supplement:
    """A parameter file without objects: it is read after another one, whose values it replaces."""

    names: tuple[str, ...]


Content = (
    BagContent | Sample | ObjectModel | ConstraintContent | Setup | Annotations | TruthContent | ResultContent
    | Camera | Supplement | Report
)  # fmt: skip


MISSING = "missing"
"""The kind of a path where nothing is."""


@dataclass(frozen=True)
class Item:
    """A path and what it holds, or the reason (`error`) why that cannot be told."""

    path: Path
    kind: str
    content: Content | None = None
    error: str | None = None
