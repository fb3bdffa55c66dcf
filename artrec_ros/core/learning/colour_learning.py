"""Reference colours of classes, learned from pixels that are known to show them, and how well they tell them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import product
from typing import NamedTuple, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import ClassConfig, ImageConfig, LearningConfig
from ..base.errors import ConfigError
from ..image.colour_table import Colours, deviation, ray
from ..image.segmentation import Segmenter
from .colour_choice import Offer, Reference, choose, clusters
from .colour_counts import Samples, confusion, worth

_LEARNING = LearningConfig()
_FEW = 8  # names that a message lists
_KEPT = 300  # samples a class that references are chosen by: bounds the time
_COUNTED = 6_000  # samples a class that are counted in the end
KEPT_PER_IMAGE = 1_000
"""Samples of a class that one image gives at most: no picture decides alone."""
_LARGE_PX = 20  # markers larger than this, square root of their area, gain by sharpening where it cannot be measured
_ALIKE = 0.005  # shares that differ by less are equal
_ENDED = 0.3  # share of what is around a region that is told where its outline is
_SAME = (0.8, 1.25)  # light in which a colour still is the same

Key = TypeVar("Key")
Pair = tuple[NDArray[np.uint8], NDArray[np.uint8]]  # colour image (H, W, 3) BGR, class numbers (H, W)


class Stray(NamedTuple):
    """A reference colour of another hue than most of its class, which stands for few of its pixels.

    :param rgb, usual: it, and the reference that stands for most. :param share: of the class' samples.
    :param where: the region that holds most of them, where regions were marked.
    """

    name: str
    rgb: tuple[int, int, int]
    usual: tuple[int, int, int]
    share: float
    where: str | None


@dataclass(frozen=True)
class Learned:
    """What was learned.

    :param image: the configuration with the classes' reference colours and the background's.
    :param confusion: class -> class (or 'unknown') -> its samples' share of it, as the recogniser weighs them: a colour
        that is as like one as the other counts half for either.
    :param samples: class -> number of its samples.
    :param rings_px: classes that go on just beyond their outlines all around -> how far, pixels.
    :param mostly_in: background and the class that takes much of it -> the one region, where one holds most of that.
    :param strays: references that may be of something else.
    :param markers: class that several markers show -> marker, '': what is drawn of it -> `confusion`'s of it.
    """

    image: ImageConfig
    confusion: Mapping[str, Mapping[str, float]]
    samples: Mapping[str, int]
    rings_px: Mapping[str, float] = field(default_factory=dict)
    mostly_in: Mapping[tuple[str, str], str] = field(default_factory=dict)
    strays: Sequence[Stray] = ()
    markers: Mapping[str, Mapping[str, Mapping[str, float]]] = field(default_factory=dict)


def sample_colours(
    image: NDArray[np.uint8],
    labels: NDArray[np.uint8],
    names: Mapping[int, Key],
    rng: np.random.Generator,
    blur_px: float = 0.0,
) -> dict[Key, NDArray[np.uint8]]:
    """Name -> (n, 3) colours of a part of the pixels with its label, none of them at an edge.

    Of a class whose pixels all lie near edges, as in patches of some 10 px, the third that lies deepest.

    :param image: (H, W, 3) uint8 BGR. :param labels: (H, W) class numbers; numbers without a name are passed over.
    :param blur_px: deviation of the lens' blur: edges reach farther, be it undone.
    """
    found = {}
    for label in np.unique(labels).tolist():
        if label not in names:
            continue
        inside = sampled(labels == label, blur_px, of_nothing=label == 0)
        if inside.any():
            found[names[label]] = _some(image[inside], KEPT_PER_IMAGE, rng)
    return found


def sampled(own: NDArray[np.bool_], blur_px: float = 0.0, *, of_nothing: bool = False) -> NDArray[np.bool_]:
    """(H, W) which pixels of a class (H, W) `sample_colours` draws from. :param of_nothing: they have no label."""
    pixels = own.astype(np.uint8)
    margin = round(blur_px) + (_LEARNING.margin_unknown_px if of_nothing else _LEARNING.margin_px)
    inside = cv2.erode(pixels, np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)) > 0
    if not of_nothing and np.count_nonzero(inside) < np.count_nonzero(pixels) / 3:
        depth = cv2.distanceTransform(pixels, cv2.DIST_L2, 3)
        inside = depth >= max(float(np.quantile(depth[own], 2 / 3)), 1e-3)
    return np.asarray(inside)


def sample_beside(
    image: NDArray[np.uint8],
    labels: NDArray[np.uint8],
    ignored: int,
    rng: np.random.Generator,
    blur_px: float = 0.0,
) -> NDArray[np.uint8]:
    """(n, 3) colours of a part of the pixels of number 0 that lie beside regions of other numbers, no farther off than
    `beside_share` of the median region's width: what outlines must be told from, and a small part of an image.

    :param image: (H, W, 3) uint8 BGR. :param labels: (H, W) class numbers. :param ignored: number of what is no region.
    :param blur_px: as of `sample_colours`.
    """
    regions = ((labels != 0) & (labels != ignored)).astype(np.uint8)
    areas = cv2.connectedComponentsWithStats(regions)[2][1:, cv2.CC_STAT_AREA]
    if not len(areas):
        return np.zeros((0, 3), np.uint8)
    off, off_any = (cv2.distanceTransform(1 - r, cv2.DIST_L2, 5) for r in (regions, (labels != 0).astype(np.uint8)))
    least = _LEARNING.beside_px + blur_px
    most = max(2 * least, _LEARNING.beside_share * float(np.median(np.sqrt(areas))))
    beside = (off > least) & (off <= most) & (off <= off_any)
    return _some(image[beside], KEPT_PER_IMAGE, rng)


def enough(samples: Samples, name: str) -> bool:
    """Whether a class has samples enough to be learned."""
    return len(samples.get(name, ())) >= _LEARNING.least_samples


def check_samples(samples: Samples, labels: Collection[str]) -> None:
    """:raises ConfigError: a class without enough samples."""
    for name in labels:
        count = len(samples.get(name, ()))
        if not enough(samples, name):
            others = [other for other in samples if other not in labels]
            more = f" and {len(others) - _FEW} more" if len(others) > _FEW else ""
            there = f"; there are also {', '.join(others[:_FEW])}{more}" if others and not count else ""
            least = _LEARNING.least_samples
            raise ConfigError(f"class '{name}': {count} pixels show it, at least {least} are needed{there}")


def learn_colours(
    samples: Samples,
    labels: Mapping[str, int],
    image: ImageConfig,
    doubtful: Collection[str] = (),
    shown: Callable[[Iterable[int]], Iterable[int]] = iter,
) -> Learned:
    """Reference colours from samples: of several draws of these the references that tell best what all are.

    Which draw it is can decide whether a class is told or half of it lost, for a choice that goes step by step ends
    where it began to go. How much the background counts in it can do the same: what glares white in a class is lost
    where white floor weighs more. The best has the greatest product of the shares that are right, of classes and
    backgrounds: a share near nothing is not made up for by others.

    :param samples: name -> (n, 3) uint8 BGR; names that are no class are background.
    :param labels: class -> its label.
    :param image: noise and the like; its classes and background are replaced.
    :param doubtful: backgrounds in which classes are seen, too, as in what a segmenter left without a label.
    :param shown: passes the draws on, and may show how far they are: they take seconds.
    :raises ConfigError: a class without enough samples, or of pixels too dark to have a colour.
    """
    check_samples(samples, labels)
    tried = list(product(range(_LEARNING.draws), _LEARNING.weights_background))
    drawn = lru_cache(1)(partial(_Draw.of, samples, labels, image, doubtful))  # it is the same for all weights
    draws = [drawn(tried[n][0]).learned(labels, image, tried[n][1]) for n in shown(range(len(tried)))]
    _, learned, counted = max(draws, key=lambda draw: draw[0])
    return Learned(learned, confusion(counted, learned), {name: len(c) for name, c in samples.items()})


@dataclass(frozen=True)
class _Draw:
    """One draw of the samples.

    :param offer: candidates of those that references are chosen by. :param counted: those that are counted in the end.
    """

    offer: Offer
    counted: Samples

    @classmethod
    def of(
        cls, samples: Samples, labels: Collection[str], image: ImageConfig, doubtful: Collection[str], seed: int
    ) -> _Draw:
        rng = np.random.default_rng(seed)
        own: dict[str | None, Sequence[Colours]] = {name: [_samples(name, samples, image, rng)] for name in labels}
        rest = {name: _scaled(_some(c, 3 * _KEPT, rng)) for name, c in samples.items() if name not in labels}
        rest = {name: _without_classes(c, own) if name in doubtful else c for name, c in rest.items()}
        offer = Offer.of({**own, None: [c for c in rest.values() if len(c) >= _LEARNING.least_samples]}, image)
        counted = {name: _some(colours, _COUNTED, rng) for name, colours in samples.items() if len(colours)}
        return cls(offer, counted)

    def learned(
        self, labels: Mapping[str, int], image: ImageConfig, weight: float
    ) -> tuple[float, ImageConfig, Samples]:
        """What it is worth, what it tells, and the samples that say so. :param weight: of the background."""
        chosen = choose(self.offer, image, weight)
        classes = {name: _class(label, [r for r in chosen if r.owner == name]) for name, label in labels.items()}
        rest = _class(0, [r for r in chosen if r.owner is None])
        learned = replace(image, kind="colour", classes=classes, background=rest.rgb, background_light=rest.light)
        return worth(self.counted, learned), learned, self.counted


def _samples(name: str, samples: Samples, image: ImageConfig, rng: np.random.Generator) -> Colours:
    """(n, 3) BGR 0..1, some of a class' samples; darker ones have no colour."""
    colours = _scaled(samples[name])
    colours = colours[np.linalg.norm(colours, axis=1) > 3 * image.noise]
    if len(colours) < max(_LEARNING.least_samples, len(samples[name]) / 10):
        raise ConfigError(
            f"class '{name}': its pixels are too dark to name a colour; give its range "
            f"instead, in the parameter file: image: {{{name}: {{value: [0.0, 0.2]}}}}"
        )
    return _some(colours, _KEPT, rng)


def _without_classes(colours: Colours, classes: Mapping[str | None, Sequence[Colours]]) -> Colours:
    """Colours of a background (n, 3) less those that more of a class' samples have than of the background's: what
    nobody has labelled, or marked, shows classes too."""
    kept = np.ones(len(colours), bool)
    for centre in clusters(colours, _LEARNING.clusters_background, 0.0):
        mine = _held(colours, centre)
        if any(_held(c, centre).mean() > mine.mean() for groups in classes.values() for c in groups):
            kept &= ~mine
    return colours[kept]


def _held(colours: Colours, centre: Colours) -> NDArray[np.bool_]:
    """(n,) whether colours are as good as this one."""
    image = ImageConfig()
    squared, _ = deviation(colours, ray(centre, _SAME)[1], ClassConfig().spread / 2, image.noise)
    return np.asarray(squared.min(axis=0) <= (image.max_deviation / 2) ** 2)


def _class(label: int, references: list[Reference]) -> ClassConfig:
    """:param references: none: no colour, in the light that is usual."""
    lights = [r.light for r in references]
    once = lights[:1] if len(set(lights)) == 1 else lights
    light = tuple(v for light in once for v in light) or ClassConfig().light
    return ClassConfig(label, _as_rgb([r.colour for r in references]), light)


def choose_sharpening(image: ImageConfig, pairs: Iterable[Pair], labels: Mapping[int, int]) -> ImageConfig:
    """The configuration, sharpened or not, whichever gets more of the marked pixels right; of equals, and where nobody
    has told where classes end, sharpened where markers are large and lose nothing by it inside, as rough ones do.

    :param pairs: images and the class numbers that somebody has told, edges included.
    :param labels: class number -> label; 0: the background's. Numbers that it does not have are passed over.
    """
    tried = [replace(image, sharpen_px=radius) for radius in (0, 1)]
    segmenters = [Segmenter(config) for config in tried]
    shares, inside, marked, seen, ended = [], [], list[float](), list[float](), []
    for colours, told in pairs:
        read, known = [segmenter.labels(colours) for segmenter in segmenters], np.isin(told, list(labels))
        for number in np.unique(told).tolist():
            if number in labels:
                own = told == number
                shares.append([np.mean(labelled[own] == labels[number]) for labelled in read])
                if labels[number]:
                    inside.append(shares[-1])
                    marked += _sizes_px(own, own)
                    seen += _sizes_px(read[0] == labels[number], own)
                    ended.append(_told_around(own, known))
    gain, gain_inside = (float(np.diff(np.mean(of, axis=0))[0]) if of else 0.0 for of in (shares, inside))
    told_ends = not ended or float(np.median(ended)) > _ENDED
    if told_ends and abs(gain) >= _ALIKE:
        return tried[int(gain > 0)]
    sizes = marked if told_ends or not seen else seen  # a region drawn inside of a marker says little of its size
    large = bool(sizes) and float(np.median(sizes)) > _LARGE_PX
    return tried[int(large and gain_inside > -_ALIKE)]


def _sizes_px(pixels: NDArray[np.bool_], regions: NDArray[np.bool_]) -> list[float]:
    """Roots of the areas of the connected pixels that reach into a region."""
    _, number, stats, _ = cv2.connectedComponentsWithStats(pixels.astype(np.uint8))
    met = np.unique(number[regions & pixels])
    return [float(size) for size in np.sqrt(stats[met, cv2.CC_STAT_AREA])]


def _told_around(own: NDArray[np.bool_], told: NDArray[np.bool_]) -> float:
    """The share of the pixels around a class' regions of which somebody has told what they are."""
    ring = cv2.dilate(own.astype(np.uint8), np.ones((3, 3), np.uint8)) > own
    return float(told[ring].mean()) if ring.any() else 0.0


def _some(colours: NDArray, most: int, rng: np.random.Generator) -> NDArray:
    if len(colours) <= most:
        return colours
    return colours[np.sort(rng.choice(len(colours), most, replace=False))]


def _scaled(colours: NDArray[np.uint8]) -> Colours:
    return np.asarray(colours / 255, np.float32)


def _as_rgb(references: list[Colours]) -> tuple[int, ...]:
    return tuple(int(round(255 * float(v))) for reference in references for v in reference[::-1])
