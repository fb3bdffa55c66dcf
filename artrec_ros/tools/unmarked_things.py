"""What a class takes where nobody has drawn a region: longer things than any that is marked of it.

Drawn regions tell little of most of an image. What is seen of a class there may be more of it; what is much longer than
all that was marked is more likely something that was never shown as background, and is searched in every frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..core.base.config import ImageConfig
from ..core.image.colour_table import named
from ..core.image.segmentation import packed, rectangles
from .colour_samples import UNMARKED, Told

_LONGER = 2.0  # than the longest thing of the class that a region touches
_SHARE = 0.1  # of the largest one's pixels: less is a thread of noise


class _Thing(NamedTuple):
    """Connected pixels of a class. :ivar touched: by a region. :ivar box: x, y, width, height. :ivar picture: name."""

    pixels: int
    touched: bool
    box: list[int]
    picture: str

    @property
    def length(self) -> float:
        """Pixels, of its box' diagonal."""
        return math.hypot(*self.box[2:])


def unmarked_things(told: Told, image: ImageConfig) -> Iterator[str]:
    """A line for each class that takes such things. :param image: what was learned of these images."""
    pictures = [_labels(told, image, colours) for colours, _ in told.pairs[: len(told.marked)]]
    for name, cls in image.classes.items():
        things = list(_things(told, pictures, cls.label))
        own = [t for t in things if t.touched]
        longest, most = max((t.length for t in own), default=0.0), max((t.pixels for t in own), default=0)
        longer = [t for t in things if not t.touched and t.length > _LONGER * longest > 0 and t.pixels > _SHARE * most]
        if not longer:
            continue
        first, where = max(longer, key=lambda t: t.length), len({t.picture for t in longer})
        yield (
            f"{name} takes {len(longer)} things, in {where} of {len(told.pairs)} pictures, that no region touches "
            f"and that are more than twice as long as all that is marked of it: the longest in {first.picture} "
            f"{first.box} (x, y, width, height). Mark such a thing as one of a category of its own, a background; or, "
            f"if it is {name}, as that"
        )


def _labels(told: Told, image: ImageConfig, colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(H, W) what a picture's colours are named; 0 where nobody looks."""
    labels = named(image, packed(colours).ravel()).reshape(colours.shape[:2])
    for part in rectangles(told.blank):
        labels[part] = 0
    return labels


def _things(told: Told, pictures: Sequence[NDArray[np.uint8]], label: int) -> Iterator[_Thing]:
    for labels, (_, numbers), marked in zip(pictures, told.pairs, told.marked, strict=False):
        mine = labels == label
        count, parts, boxes, _ = cv2.connectedComponentsWithStats(mine.astype(np.uint8), connectivity=8)
        touched = np.zeros(count, bool)
        touched[np.unique(parts[numbers != UNMARKED])] = True
        for n in range(1, count):
            box, pixels = boxes[n, : cv2.CC_STAT_AREA].tolist(), int(boxes[n, cv2.CC_STAT_AREA])
            yield _Thing(pixels, bool(touched[n]), box, marked.path.name)
