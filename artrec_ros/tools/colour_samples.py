"""Colours of classes and backgrounds in images of which somebody has told what they show."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from ..core.base.config import ImageConfig
from ..core.image.segmentation import as_light, evenly_lit, filtered
from ..core.learning.colour_learning import Pair, sample_beside, sample_colours
from ..core.learning.gamma import gamma_of
from ..core.learning.lens_blur import lens_blur
from ..core.learning.outline_reach import Outlines
from ..io.base.bars import bar
from ..io.learned.marked_objects import BESIDE, REST
from ..io.learned.regions import MarkedImage
from .marker_samples import MarkerSamples, Parts

# of `image`, by which colours are learned
GIVEN = "smoothing_px", "gamma", "blur_noise", "gain_percentile", "gain_level", "gain_limit"
_READ = partial(bar, desc="reading", unit="image", leave=False)
UNMARKED = 255  # number of the pixels that nobody has marked
_TRIED = 24  # images at most that sharpening is tried on, or blur and gamma are measured in

Samples = dict[str, NDArray[np.uint8]]


@dataclass
class Told:
    """Some of the images with their class numbers, and class number -> label; 0: background.

    :param by_segmenter: the numbers come from label images. :param camera: how images were made even and sharp before.
    :param parts: samples of classes that several markers show.
    :param exact: of each image the class and outline of its markers, as axes tell.
    :param marked: all images in which regions tell them. :param blank: rectangles that are not looked at.
    """

    labels: Mapping[int, int]
    by_segmenter: bool
    camera: ImageConfig
    pairs: list[Pair] = field(default_factory=list)
    parts: Parts = field(default_factory=dict)
    exact: Sequence[Outlines] = ()
    marked: Sequence[MarkedImage] = ()
    blank: tuple[int, ...] = ()

    def as_seen(self, image: ImageConfig) -> ImageConfig:
        """A configuration by which images are made even and sharp as these were."""
        return replace(image, **{name: getattr(self.camera, name) for name in (*GIVEN, "blur_px")})

    def read(self, marked: MarkedImage, numbers: dict[str, int]) -> Pair:
        """One of the images as samples were drawn from it, and each region's number."""
        return _prepared(marked.read(numbers, UNMARKED), self.blank, self.camera)


def samples_of_labels(
    pairs: Iterable[Pair], labels: dict[str, int], every: int, blank: tuple[int, ...], camera: ImageConfig
) -> tuple[Samples, Told]:
    """Colours by class from images with label images; other labels as 'label N'.

    :param blank, camera: as of `samples_of_regions`.
    """
    names = {n: f"label {n}" for n in range(UNMARKED)} | {label: name for name, label in labels.items()}
    used = (_prepared((image, told.copy()), blank, camera) for image, told in islice(pairs, 0, None, every))
    return _collect(used, names, labels, by_segmenter=True, camera=camera)


def samples_of_regions(
    marked: Iterable[MarkedImage],
    labels: dict[str, int],
    blank: tuple[int, ...],
    camera: ImageConfig,
    *,
    gamma_known: bool,
) -> tuple[Samples, Told]:
    """Colours by category from images with marked regions; where the lens has blurred them, with this undone.

    :param blank: rectangles that are not looked at. :param camera: how images are smoothed, and what is known of them.
    :param gamma_known: that is so of its gamma; else it is told by outlines that axes mark.
    """
    marked = list(marked)
    found = dict.fromkeys([*labels, *(name for m in marked for name, _ in m.regions)])
    names = {0: REST} | dict(enumerate((name for name in found if name != REST), start=1))
    numbers = {name: n for n, name in names.items()}
    camera = _measured(marked[:: 1 + len(marked) // _TRIED], numbers, blank, camera, gamma_known)
    by_marker = MarkerSamples.of(marked, numbers)
    pairs = by_marker.gathered((_prepared(m.read(numbers, UNMARKED), blank, camera) for m in marked), camera.blur_px)
    samples, told = _collect(pairs, names, labels, by_segmenter=False, camera=camera)
    exact = [m.exact for m in marked[: len(told.pairs)]]
    return samples, replace(told, parts=by_marker.parts, exact=exact, marked=marked, blank=blank)


def _measured(
    marked: Sequence[MarkedImage], numbers: dict[str, int], blank: tuple[int, ...], camera: ImageConfig, known: bool
) -> ImageConfig:
    """With the lens' blur, but where images are to be smooth: who wants that does not want them sharp; and with gamma,
    which matters where edges are blurred.

    :param known: whether gamma is.
    """
    if camera.smoothing_px > 0:
        return camera
    raw = [_prepared(m.read(numbers, UNMARKED), blank, camera) for m in marked]
    if not known:
        camera = replace(camera, blur_px=lens_blur(raw, UNMARKED))
        if camera.blur_px > 0:
            exact = [(image, [outline for _, outline in m.exact]) for (image, _), m in zip(raw, marked, strict=True)]
            camera = replace(camera, gamma=gamma_of(exact))
        if camera.gamma == 1.0:
            return camera
    lit = ((as_light(image, camera.gamma), told) for image, told in raw)
    return replace(camera, blur_px=lens_blur(lit, UNMARKED))


def _prepared(pair: Pair, blank: tuple[int, ...], image: ImageConfig) -> Pair:
    for x, y, width, height in np.reshape(blank, (-1, 4)).astype(int).tolist():
        pair[1][y : y + height, x : x + width] = UNMARKED
    return filtered(evenly_lit(pair[0], replace(image, blank=blank)), image), pair[1]


def _collect(
    pairs: Iterable[Pair],
    names: dict[int, str],
    labels: Mapping[str, int],
    by_segmenter: bool,
    camera: ImageConfig,
) -> tuple[Samples, Told]:
    rng = np.random.default_rng(0)
    found = defaultdict(list)
    told = Told({n: labels.get(name, 0) for n, name in names.items()}, by_segmenter, camera)
    for image, numbers in _READ(pairs):
        for name, colours in sample_colours(image, numbers, names, rng, told.camera.blur_px).items():
            found[name].append(colours)
        if names.get(0) == REST and len(colours := sample_beside(image, numbers, UNMARKED, rng, told.camera.blur_px)):
            found[BESIDE].append(colours)
        if len(told.pairs) < _TRIED:
            told.pairs.append((image, numbers))
    return {name: np.concatenate(parts) for name, parts in found.items()}, told
