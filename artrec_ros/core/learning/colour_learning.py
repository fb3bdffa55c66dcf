"""Reference colours of classes, learned from pixels that are known to show them.

Greedy cover: of many samples taken as rays, the one whose ray holds most of the others; its reference is the median
of those; they are taken away, and what remains is looked at again, till too little remains to be a colour. So wrong
samples do not pull a reference, and a class of several colours gets several.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import ClassConfig, ImageConfig, LearningConfig
from ..base.errors import ConfigError
from ..image.colour_table import Colours, deviation, ray, references_bgr
from ..image.segmentation import Segmenter

_LEARNING = LearningConfig()
_TRIED = 48  # samples tried as rays: of a colour that a twentieth has, one is among them nine times in ten
_KEPT = 6_000  # samples a class that are looked at: bounds the time
_KEPT_PER_IMAGE = 1_000
_SAME_LIGHT = (0.5, 2.0)  # a background colour that is a class' colour in such light is the class', not labelled

Samples = Mapping[str, NDArray[np.uint8]]


@dataclass(frozen=True)
class Learned:
    """What was learned.

    :param image: the configuration with the classes' reference colours and the background's.
    :param confusion: class -> class (or 'unknown') -> share of its samples that get that class' label.
    :param samples: class -> number of its samples.
    """

    image: ImageConfig
    confusion: Mapping[str, Mapping[str, float]]
    samples: Mapping[str, int]


def sample_colours(
    image: NDArray[np.uint8], labels: NDArray[np.uint8], names: Mapping[int, str], rng: np.random.Generator
) -> dict[str, NDArray[np.uint8]]:
    """Name -> (n, 3) colours of a part of the pixels with its label, none of them at an edge.

    :param image: (H, W, 3) uint8 BGR. :param labels: (H, W) class numbers; numbers without a name are passed over.
    """
    found = {}
    for label in np.unique(labels).tolist():
        if label not in names:
            continue
        margin = _LEARNING.margin_px if label else _LEARNING.margin_unknown_px
        square = np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)
        colours = image[cv2.erode((labels == label).astype(np.uint8), square) > 0]
        if len(colours):
            found[names[label]] = _some(colours, _KEPT_PER_IMAGE, rng)
    return found


def learn_colours(samples: Samples, labels: Mapping[str, int], image: ImageConfig, seed: int = 0) -> Learned:
    """Reference colours from samples.

    :param samples: name -> (n, 3) uint8 BGR; names that are no class are background.
    :param labels: class -> its label.
    :param image: noise and the like; its classes and background are replaced.
    :raises ConfigError: a class without enough samples.
    """
    rng = np.random.default_rng(seed)
    kept = {name: _some(colours, _KEPT, rng) for name, colours in samples.items()}
    classes = {}
    for name, label in labels.items():
        count = len(kept.get(name, ()))
        if count < _LEARNING.least_samples:
            raise ConfigError(f"class '{name}': {count} pixels show it, at least {_LEARNING.least_samples} are needed")
        usual = ClassConfig(label=label)
        references = _cover(_scaled(kept[name]), usual, image, _LEARNING.least_share, rng)
        if not references:
            raise ConfigError(f"class '{name}': its pixels are too dark or too unlike each other to name a colour")
        classes[name] = replace(usual, rgb=_as_rgb(references))
    background = [
        reference
        for name, colours in kept.items()
        if name not in labels and len(colours) >= _LEARNING.least_samples
        for reference in _cover(_scaled(colours), ClassConfig(), image, _LEARNING.least_share_background, rng)
        if not any(_is_shown(reference, cls, image) for cls in classes.values())
    ]
    learned = replace(image, kind="colour", classes=classes, background=_as_rgb(background))
    return Learned(learned, _confusion(kept, learned), {name: len(c) for name, c in samples.items()})


def _cover(
    colours: Colours, cls: ClassConfig, image: ImageConfig, least_share: float, rng: np.random.Generator
) -> list[Colours]:
    """(3,) BGR 0..1 reference colours, the one that holds most first."""
    rest = colours[np.linalg.norm(colours, axis=1) > 3 * image.noise]  # darker ones have no colour
    least, references = max(least_share * len(colours), 1), list[Colours]()
    while len(references) < _LEARNING.most_colours and len(rest) >= least:
        tried = rest[rng.choice(len(rest), min(_TRIED, len(rest)), replace=False)]
        held = max((_held(rest, reference, cls, image) for reference in tried), key=np.count_nonzero)
        if np.count_nonzero(held) < least:
            break
        reference = np.median(rest[held], axis=0).astype(np.float32)
        held |= _held(rest, reference, cls, image)
        references.append(reference)
        rest = rest[~held]
    return references


def _held(colours: Colours, reference: Colours, cls: ClassConfig, image: ImageConfig) -> NDArray[np.bool_]:
    """(N,) whether a colour is a reference's in more or less light."""
    shown = ray(reference, cls.light)[1]
    squared, _ = deviation(colours, shown, cls.spread, image.noise)
    return np.asarray(squared.min(axis=1) <= (image.max_deviation / 2) ** 2)


def _is_shown(reference: Colours, cls: ClassConfig, image: ImageConfig) -> bool:
    near = replace(cls, light=_SAME_LIGHT)
    return any(bool(_held(reference[None], own, near, image)[0]) for own in references_bgr(cls))


def _confusion(samples: Samples, image: ImageConfig) -> dict[str, dict[str, float]]:
    names = {cls.label: name for name, cls in image.classes.items()} | {0: "unknown"}
    segmenter = Segmenter(replace(image, sharpen_px=0, smoothing_px=0, gain_percentile=0, blank=()))
    confusion = {}
    for name, colours in samples.items():
        labels, counts = np.unique(segmenter.labels(colours[None]), return_counts=True)
        confusion[name] = {names[k]: n / len(colours) for k, n in zip(labels.tolist(), counts.tolist(), strict=True)}
    return confusion


def _some(colours: NDArray[np.uint8], most: int, rng: np.random.Generator) -> NDArray[np.uint8]:
    if len(colours) <= most:
        return colours
    return colours[np.sort(rng.choice(len(colours), most, replace=False))]


def _scaled(colours: NDArray[np.uint8]) -> Colours:
    return np.asarray(colours / 255, np.float32)


def _as_rgb(references: list[Colours]) -> tuple[int, ...]:
    return tuple(int(round(255 * float(v))) for reference in references for v in reference[::-1])
