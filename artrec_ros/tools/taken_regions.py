"""Where that of a background lies which a class takes: one box over something of its colour makes no likeness."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping

import numpy as np

from ..core.base.config import ImageConfig
from ..core.geometry.transforms import Array
from ..core.image.colour_table import named
from ..core.image.segmentation import packed
from ..core.learning.colour_learning import KEPT_PER_IMAGE, sampled
from ..io.learned.regions import MarkedImage, covered
from .colour_samples import Told

MUCH = 0.02
"""Share of a background that a class may take before something should be done: a robot or two."""
_MOST = 0.5  # of what is taken


def mostly_in(
    told: Told, image: ImageConfig, confusion: Mapping[str, Mapping[str, float]]
) -> dict[tuple[str, str], str]:
    """Background and class that takes much of it -> the one region that most of that lies in, where there is one.

    :param confusion: as of `Learned`. Images are read once more, those alone that have such a background.
    """
    found = {}
    for name in confusion.keys() - image.classes.keys():
        for other in image.classes:
            if confusion[name].get(other, 0.0) >= MUCH:
                parts = list(taken(told, image, name, image.classes[other].label))
                where, most = max(parts, key=lambda region: region[1], default=("", 0.0))
                if most > _MOST * sum(pixels for _, pixels in parts):
                    found[name, other] = where
    return found


def taken(told: Told, image: ImageConfig, name: str, label: int) -> Iterator[tuple[str, float]]:
    """Each region of a category, and how many of its samples get a label."""
    for marked in told.marked:
        outlines = [outline for category, outline in marked.regions if category == name]
        if not outlines:
            continue
        colours, numbers = told.read(marked, defaultdict(int, {name: 1}))
        drawn = sampled(numbers == 1, told.camera.blur_px)
        own = np.zeros(drawn.shape, bool)
        own[drawn] = named(image, packed(colours[drawn][None])[0]) == label
        share = min(1.0, KEPT_PER_IMAGE / max(int(drawn.sum()), 1))
        for outline in outlines:
            yield _called(marked, outline), share * int((own & covered(outline, own.shape)).sum())


def _called(marked: MarkedImage, outline: Array) -> str:
    """A region as its file has it: picture, and x, y, width and height of its box."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    box = ", ".join(f"{v:.4g}" for v in (*low, *(high - low + 1)))
    return f"{marked.path.name} [{box}] (x, y, width, height)"
