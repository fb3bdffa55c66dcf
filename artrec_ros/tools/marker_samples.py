"""Samples of classes that several markers show, by marker: a small one has few pixels, and none far from its edges."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..core.base.config import LearningConfig
from ..core.learning.colour_learning import Pair, sample_colours
from ..io.learned.regions import MarkedImage

Parts = Mapping[str, Mapping[str, NDArray[np.uint8]]]
"""Class -> marker, '': what is drawn of it -> (n, 3) BGR."""


@dataclass(frozen=True)
class MarkerSamples:
    """:param numbers: of each class that several markers show, in the images' numbers."""

    marked: Sequence[MarkedImage]
    numbers: Mapping[str, int]
    _found: dict[str, dict[str, list[NDArray[np.uint8]]]] = field(default_factory=dict)

    @classmethod
    def of(cls, marked: Sequence[MarkedImage], numbers: Mapping[str, int]) -> MarkerSamples:
        """Of all images, before they are read. :param numbers: of each category."""
        shown = defaultdict[str, set[str]](set)
        for m in marked:
            for (name, _), marker in zip(m.exact, m.markers, strict=True):
                shown[name].add(marker)
        return cls(marked, {name: numbers[name] for name, markers in shown.items() if len(markers) > 1})

    def gathered(self, pairs: Iterable[Pair], blur_px: float) -> Iterator[Pair]:
        """The images as they are, in their order, of which samples are kept. :param blur_px: as of `sample_colours`."""
        rng = np.random.default_rng(0)
        for marked, (image, numbers) in zip(self.marked, pairs, strict=True):
            for name, number in self.numbers.items():
                own = self._found.setdefault(name, {})
                for marker, mine in marked.parts(name, numbers == number):
                    for colours in sample_colours(image, mine.astype(np.uint8), {1: marker}, rng, blur_px).values():
                        own.setdefault(marker, []).append(colours)
            yield image, numbers

    @property
    def parts(self) -> Parts:
        """What was kept, of markers that are shown by enough."""
        whole = {name: {m: np.concatenate(c) for m, c in own.items()} for name, own in self._found.items()}
        return {
            name: {m: colours for m, colours in own.items() if len(colours) >= LearningConfig.least_samples}
            for name, own in whole.items()
        }


def evened(parts: Mapping[str, NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """A class' samples (n, 3), of each of its markers as many."""
    most = max(map(len, parts.values()))
    return np.concatenate([np.resize(colours, (most, 3)) for colours in parts.values()])
