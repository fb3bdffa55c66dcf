"""Classes' colours from samples, and how images are to be sharpened by them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ..core.base.config import ClassConfig, ImageConfig, VotesConfig
from ..core.learning.colour_counts import confusion, speaks
from ..core.learning.colour_learning import Learned, choose_sharpening, learn_colours
from ..core.learning.outline_reach import rings_px
from .colour_samples import Samples, Told
from .marker_samples import Parts, evened
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
    learn = partial(learn_colours, labels=labels, image=ImageConfig(), doubtful=doubtful, shown=shown)
    parts = {name: of for name, of in told.parts.items() if name in labels and len(of) > 1}
    samples, learned = _with_lost_markers(samples, parts, learn(samples), learn)
    image = sharpened(replace(learned.image, classes={**ranged, **learned.image.classes}), told)
    rings = rings_px(image, ((*pair, outlines) for pair, outlines in zip(told.pairs, told.exact, strict=False)))
    mostly = mostly_in(told, image, learned.confusion)
    odd = strays(samples, told, learned.image)
    markers = {name: confusion(of, learned.image) for name, of in parts.items()}
    image = told.as_seen(image)
    return replace(learned, image=image, markers=markers, rings_px=rings, mostly_in=mostly, strays=odd)


def _with_lost_markers(
    samples: Samples, parts: Parts, learned: Learned, learn: Callable[[Samples], Learned]
) -> tuple[Samples, Learned]:
    """Samples, and what is learned of them. Where a marker is lost, for those of its class that are larger outweigh it,
    each of them weighs the same, if that helps: an object is lost with its marker, however small that is.

    :param parts: samples of classes that several markers show. :param learned: of all samples.
    """
    lost = {name: of for name, of in parts.items() if not _all_speak(name, of, learned)}
    if lost:
        even = {**samples, **{name: evened(of) for name, of in lost.items()}}
        again = learn(even)
        if all(_all_speak(name, of, again) for name, of in lost.items()):
            counts = {name: sum(map(len, of.values())) for name, of in lost.items()}
            return even, replace(again, samples={**again.samples, **counts})
    return samples, learned


def _all_speak(name: str, parts: Mapping[str, NDArray[np.uint8]], learned: Learned) -> bool:
    """Whether each of a class' markers is told well enough to speak for its objects."""
    told = confusion(parts, learned.image).values()
    return all(speaks(name, shares, VotesConfig().inside) for shares in told)


def sharpened(image: ImageConfig, told: Told) -> ImageConfig:
    """The configuration with what sharpening shall be: by what it brings where somebody has told the edges."""
    if told.by_segmenter:  # whose edges are those of images that were not sharpened
        return replace(image, sharpen_px=_SHARPEN_PX)
    return choose_sharpening(image, told.pairs, told.labels)
