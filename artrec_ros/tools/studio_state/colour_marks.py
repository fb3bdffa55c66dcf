"""Patches of classes and of background that somebody clicked on: a COCO file of regions that `artrec learn-colours`
reads; and what is learned from them."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.base.config import LearningConfig
from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array
from ...core.learning.colour_learning import Learned, check_samples
from ...io.base.whole_files import save_file
from ...io.learned.colours import save_colours
from ...io.learned.marked_objects import load_marked_objects
from ...io.learned.regions import load_regions
from ...io.parameters.sections import read_flat
from ..colour_samples import Samples, Told, samples_of_regions
from ..colour_setup import load_colour_setup
from ..colours_of_samples import learn_from
from .session import Session

REGIONS_FILE, COLOURS_FILE = "regions.json", "colours.yaml"
BACKGROUND = "background"
_SAME = 22  # of 255: how far a channel may be from the clicked pixel's for a neighbour to belong to its patch
_REACH_PX = 12  # how far from the click a patch goes at most


@dataclass(frozen=True)
class Patch:
    """A region of one class, or of background: outline (n, 2) in pixels, in the frame of this file."""

    file: Path
    name: str
    outline: Array


def patch_around(image: NDArray[np.uint8], x: float, y: float) -> Array:
    """(n, 2) outline of the pixels around a click that are of one colour with it and hang together.

    :param image: (H, W, 3) uint8 BGR. :raises ConfigError: the click is outside the image.
    """
    height, width = image.shape[:2]
    column, row = round(x), round(y)
    if not (0 <= column < width and 0 <= row < height):
        raise ConfigError(f"a click at {x:.0f}, {y:.0f} is outside the image of {width}x{height}")
    near = np.ones((height + 2, width + 2), np.uint8)
    cv2.circle(near, (column + 1, row + 1), _REACH_PX, 0, cv2.FILLED)
    blocked = near.copy()
    flags = 4 | cv2.FLOODFILL_MASK_ONLY | cv2.FLOODFILL_FIXED_RANGE | (2 << 8)
    cv2.floodFill(image.copy(), blocked, (column, row), 0, (_SAME,) * 3, (_SAME,) * 3, flags)
    own = np.asarray(blocked[1:-1, 1:-1] == 2, np.uint8)
    contours, _ = cv2.findContours(own, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    outline = max(contours, key=len).reshape(-1, 2).astype(float)
    return outline if len(outline) >= 3 else _box(outline.min(axis=0), outline.max(axis=0))


def box_between(first: tuple[float, float], second: tuple[float, float]) -> Array:
    """(4, 2) the box that was drawn between two points."""
    return _box(np.minimum(first, second), np.maximum(first, second))


def _box(low: Array, high: Array) -> Array:
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])], float)


@dataclass(frozen=True)
class Preview:
    """What has been learned so far. :param lacking: class -> how many marked pixels it still needs."""

    learned: Learned | None
    lacking: Mapping[str, int]


class ColourMarks:
    """The patches of a sitting, kept in a file after each change, and the colours that are learned from them.

    :ivar labels: class -> its label, as the parameter file tells.
    """

    def __init__(self, session: Session) -> None:
        """:raises ArtrecError: the images have no colours, or the file that an earlier sitting left is none."""
        self._session = session
        if session.setup.image.kind != "colour":
            raise ConfigError(
                f"image.kind is '{session.setup.image.kind}': the images tell each pixel's class, and there are no "
                "colours to learn"
            )
        self._setup = load_colour_setup([session.parameters] if session.parameters.exists() else session.given, {})
        self.labels = dict(self._setup.labels)
        self.patches: list[Patch] = []
        self._last: tuple[object, Preview] | None = None  # the marks that colours were learned from, and these
        self._lock = threading.Lock()
        if self.path.is_file():
            self.patches = [
                Patch(m.path, name, outline) for m in load_regions([self.path]) for name, outline in m.regions
            ]

    @property
    def path(self) -> Path:
        return self._session.folder / REGIONS_FILE

    @property
    def names(self) -> list[str]:
        """What can be marked: the classes, then what is no class."""
        others = [p.name for p in self.patches if p.name not in self.labels]
        return list(dict.fromkeys([*self.labels, BACKGROUND, *others]))

    def of(self, number: int) -> list[Patch]:
        """The patches of a frame."""
        return [p for p in self.patches if self._session.stills.number(p.file) == number]

    def add(self, number: int, name: str, outline: Array) -> Patch:
        patch = Patch(self._session.stills.files[number], name, outline)
        self.patches.append(patch)
        self.save()
        return patch

    def remove(self, patch: Patch) -> None:
        self.patches = [p for p in self.patches if p is not patch]
        self.save()

    def at(self, number: int, x: float, y: float) -> Patch | None:
        """The newest patch of a frame that holds this point."""
        own = [p for p in self.of(number) if cv2.pointPolygonTest(np.float32(p.outline), (x, y), False) >= 0]
        return own[-1] if own else None

    def save(self) -> None:
        """Writes the file. :raises ConfigError: that is not possible."""
        save_file(self.path, json.dumps(self._coco()))

    def _coco(self) -> Mapping[str, object]:
        files = list(dict.fromkeys(p.file for p in self.patches))
        ids = {name: i for i, name in enumerate(dict.fromkeys(p.name for p in self.patches), start=1)}
        return {
            "info": {"description": "patches marked in artrec studio, for artrec learn-colours"},
            "images": [{"id": i, "file_name": relative(file, self._session.folder)} for i, file in enumerate(files, 1)],
            "categories": [{"id": i, "name": name} for name, i in ids.items()],
            "annotations": [
                {"id": i, "image_id": files.index(p.file) + 1, "category_id": ids[p.name]}
                | {"segmentation": [np.round(p.outline, 2).ravel().tolist()], "bbox": _bounds(p.outline)}
                for i, p in enumerate(self.patches, 1)
            ],
        }

    def learn(self) -> Learned:
        """Colours from the patches, as `artrec learn-colours --annotations regions.json --classes ...` learns them.

        :raises ConfigError: a class has too few marked pixels.
        """
        preview = self.preview()
        if preview.learned is None or preview.lacking:
            check_samples(self._samples(self.labels)[0], self.labels)
        assert preview.learned is not None
        return preview.learned

    def preview(self) -> Preview:
        """The same of the classes that have enough pixels already. What was learned last is kept: pages are opened
        again, and saved, without a mark more."""
        with self._lock:  # windows that ask at once learn once
            marked = tuple((p.file, p.name, p.outline.tobytes()) for p in self.patches)
            if self._last is None or self._last[0] != marked:
                self._last = marked, self._preview()
            return self._last[1]

    def _preview(self) -> Preview:
        least = LearningConfig().least_samples
        samples, told = self._samples(self.labels)
        lacking = {name: least - len(samples.get(name, ())) for name in self.labels}
        lacking = {name: count for name, count in lacking.items() if count > 0}
        labels = {name: label for name, label in self.labels.items() if name not in lacking}
        if not labels:
            return Preview(None, lacking)
        if lacking:
            samples, told = self._samples(labels)
        return Preview(learn_from({k: v for k, v in samples.items() if k not in lacking}, told, labels), lacking)

    def _samples(self, labels: dict[str, int]) -> tuple[Samples, Told]:
        if not self.patches:
            raise ConfigError(f"nothing is marked yet: click patches of {', '.join(self.labels)}, and background")
        marked = [m.smaller_before() for m in load_regions([self.path])]
        return samples_of_regions(
            marked, labels, self._setup.blank, self._setup.camera, gamma_known=self._setup.gamma_known
        )

    def learn_from_axes(self, annotations: Path) -> Learned:
        """Colours from marked axes, as `artrec learn-colours --annotations ... --params-file ...` learns them."""
        names = {label: name for name, label in self.labels.items()}
        marked = load_marked_objects([annotations], self._setup.targets, names)
        samples, told = samples_of_regions(
            marked, self.labels, self._setup.blank, self._setup.camera, gamma_known=self._setup.gamma_known
        )
        return learn_from(samples, told, self.labels)

    def keep(self, learned: Learned) -> Path:
        """Writes the colours, and the parameter file with them. Returns the colours' file."""
        path = self._session.folder / COLOURS_FILE
        self._session.folder.mkdir(parents=True, exist_ok=True)
        save_colours(path, learned.image)
        self._session.keep(read_flat(path))
        return path


def relative(file: Path, folder: Path) -> str:
    """A file's name as it is told in a file of this folder."""
    return os.path.relpath(file.absolute(), folder.absolute())


def _bounds(outline: Array) -> list[float]:
    low, high = outline.min(axis=0), outline.max(axis=0)
    return [float(v) for v in np.round([*low, *(high - low + 1)], 2)]
