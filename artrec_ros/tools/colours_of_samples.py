"""Classes' colours from samples, and how images are to be sharpened by them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType

from ..core.base.config import ClassConfig, ImageConfig
from ..core.learning.colour_learning import Learned, choose_sharpening, learn_colours
from ..core.learning.outline_reach import rings_px
from .colour_samples import Samples, Told
from .stray_colours import strays
from .taken_regions import mostly_in

_SHARPEN_PX = 1
_NONE: Mapping[str, ClassConfig] = MappingProxyType({})


def learn_from(
    samples: Samples,
    told: Told,
    labels: Mapping[str, int],
    shown: Callable[[Iterable[int]], Iterable[int]] = iter,
    ranged: Mapping[str, ClassConfig] = _NONE,
) -> Learned:
    """The classes' colours, and whether to sharpen.

    :param shown: as of `learn_colours`. :param ranged: classes that are given, and go before.

    :raises ConfigError: a class without enough samples.
    """
    doubtful = [name for name in samples if name not in labels] if told.by_segmenter else []
    learned = learn_colours(samples, labels, ImageConfig(), doubtful, shown=shown)
    image = sharpened(replace(learned.image, classes={**ranged, **learned.image.classes}), told)
    rings = rings_px(image, ((*pair, outlines) for pair, outlines in zip(told.pairs, told.exact, strict=False)))
    mostly = mostly_in(told, image, learned.confusion)
    odd = strays(samples, told, learned.image)
    return replace(learned, image=told.as_seen(image), rings_px=rings, mostly_in=mostly, strays=odd)


def sharpened(image: ImageConfig, told: Told) -> ImageConfig:
    """The configuration with what sharpening shall be: by what it brings where somebody has told the edges."""
    if told.by_segmenter:  # whose edges are those of images that were not sharpened
        return replace(image, sharpen_px=_SHARPEN_PX)
    return choose_sharpening(image, told.pairs, told.labels)
