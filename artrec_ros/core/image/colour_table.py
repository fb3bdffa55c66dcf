"""Which classes a colour may belong to, for every 16-bit colour once: reading an image is one look-up per pixel.

A class is given in one of two ways. By ranges of hue, saturation and value: a colour belongs to it or does not. Or
by reference colours: light and shade scale a colour, so the class is a stretch of a ray through the origin (bent
where a channel is full), and a colour belongs to the ray that makes it most likely. The scatter about a ray is a
share of its brightness plus the sensor's noise, which does not shrink in the dark: there chromaticity is worth
less, as it should be. In log-chromaticity the same says: shade shifts brightness alone, and noise grows with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import GREATEST_LABEL, ClassConfig, ImageConfig
from .codes import Codes

_LIGHTS = 24  # samples of a ray between its darkest and its brightest
_GREY = 2.0  # a reference within so many standard deviations of grey is a grey
_BY_RANGE = -100.0  # cost of a colour within a class' ranges: far below any reference's
_MOST = 1e9  # cost above any other
_FINEST = 16  # steps of a share
_AT_ONCE = 4096  # colours whose costs are told together: what is between stays in a processor's cache
_SURE = 8.0  # logarithm of what speaks for a class beyond all doubt

Colours = NDArray[np.float32]

_GREYS: Colours = np.linspace(0, 1, _LIGHTS, dtype=np.float32)[:, None].repeat(3, axis=1)


def colour_table(config: ImageConfig) -> tuple[NDArray[np.uint8], Codes]:
    """(65536,) code of every 16-bit colour (blue in the low 5 bits, green, red in the high 5), and what codes mean."""
    classes, scatter = tuple(config.classes.items()), (config.noise, config.light_spread, config.max_deviation)
    return _table(classes, (config.background, config.background_light), scatter)


@lru_cache(2)  # who tries how to sharpen images has the same colours each time
def _table(
    own: tuple[tuple[str, ClassConfig], ...],
    background: tuple[tuple[int, ...], tuple[float, ...]],
    scatter: tuple[float, float, float],
) -> tuple[NDArray[np.uint8], Codes]:
    noise, light_spread, most = scatter
    config = ImageConfig(
        classes=dict(own),
        background=background[0],
        background_light=background[1],
        noise=noise,
        light_spread=light_spread,
        max_deviation=most,
    )
    classes, labels = _classes(config)
    parts = [_costs(config, classes, code) for code in np.arange(1 << 16).reshape(-1, _AT_ONCE)]
    cost, held = (np.concatenate(of, axis=1) for of in zip(*parts, strict=True))
    weights = _weights(_of_labels(config, classes, labels, cost))
    table, meaning = coded(_first(classes, labels, held), weights, np.array(labels, np.uint8))
    table.setflags(write=False)
    return table, meaning


def shares(config: ImageConfig, codes: NDArray[np.uint16]) -> dict[int, Colours]:
    """Label -> (n,) how far 16-bit colours (n,) are of it, 0 to 1: what the table's codes mean, but for their steps."""
    classes, labels = _classes(config)
    found, of = np.unique(codes, return_inverse=True)
    cost, held = _costs(config, classes, found)
    first = _first(classes, labels, held)
    second, share = _pairs(first, _weights(_of_labels(config, classes, labels, cost)))
    shared = {label: np.zeros(len(found), np.float32) for label in labels}
    for row, label in enumerate(labels):
        shared[label] += share * (first == row) + (1 - share) * (second == row)
    return {label: share[of] for label, share in shared.items()}


def named(config: ImageConfig, codes: NDArray[np.uint16]) -> NDArray[np.uint8]:
    """(n,) labels of 16-bit colours (n,), as the table names them: for few, filling it takes much longer."""
    classes, labels = _classes(config)
    found, of = np.unique(codes, return_inverse=True)
    held = _costs(config, classes, found)[1]
    return np.array(labels, np.uint8)[_first(classes, labels, held)][of]


def _classes(config: ImageConfig) -> tuple[list[ClassConfig], list[int]]:
    """The classes, the background's colours last as one of label 0; and their labels, unknown first."""
    background = ClassConfig(label=0, rgb=config.background, light=config.background_light)
    classes = [*config.classes.values(), *([background] if config.background else [])]
    return classes, [0, *dict.fromkeys(cls.label for cls in classes)]


def _first(classes: Sequence[ClassConfig], labels: Sequence[int], held: Colours) -> NDArray[np.intp]:
    """(n,) the row among labels of the class that colours are named, by costs (classes, n)."""
    row = np.array([0, *(labels.index(cls.label, 1) for cls in classes)])
    return np.asarray(row[np.argmin(np.concatenate([np.full((1, held.shape[1]), _MOST, np.float32), held]), axis=0)])


def _of_labels(config: ImageConfig, classes: Sequence[ClassConfig], labels: Sequence[int], cost: Colours) -> Colours:
    """(labels, n) the least costs under classes with each label, unknown first, by costs (classes, n)."""
    unknown = np.full((1, cost.shape[1]), config.max_deviation**2, np.float32)
    return np.stack([*unknown, *(cost[[cls.label == label for cls in classes]].min(axis=0) for label in labels[1:])])


def _weights(cost: Colours) -> Colours:
    """(classes, n) what speaks for each class against the best of the others, unknown, the first row, being 1: where
    two are as likely, next to nothing is known."""
    least, second = np.partition(cost, 1, axis=0)[:2]
    others = np.where(cost == least, second, least)
    weights = np.exp(np.clip((others - cost) / 2, -_SURE, _SURE))
    weights[0] = 1.0
    return np.asarray(weights, np.float32)


def coded(first: NDArray[np.intp], weights: Colours, labels: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], Codes]:
    """Codes of colours that are named `first` (n,) and for whose classes so much speaks as `weights` (classes, n) say.

    A code is a pair, the class that is named and the weightiest other one, with the share of the first: in steps so
    fine that the pairs that occur have codes enough; where not even halves have, all are sure.
    """
    second, share = _pairs(first, weights)
    for steps in range(_FINEST, -1, -1):
        step = np.rint(share * steps).astype(int)
        other = np.where(step == steps, first, second)
        # the background is unknown, too: as one they have a code for every label there may be
        row = np.arange(len(labels)) * ((labels > 0) | (steps > 0))
        key = (row[first] * len(labels) + row[other]) * (steps + 1) + step
        found, code = np.unique(np.append(key, steps), return_inverse=True)  # and what is unknown for sure
        if len(found) <= GREATEST_LABEL + 1:
            break
    meaning = np.zeros((256, 256))
    meaning[np.arange(256), np.arange(256)] = 1.0
    pair, step = np.divmod(found, steps + 1)
    named, other = np.divmod(pair, len(labels))
    part = step / steps if steps else np.ones(len(found))
    label = np.arange(256, dtype=np.uint8)
    label[: len(found)] = labels[named]
    meaning[: len(found)] = 0.0
    np.add.at(meaning, (np.arange(len(found)), labels[named]), part)
    np.add.at(meaning, (np.arange(len(found)), labels[other]), 1 - part)
    return code[:-1].astype(np.uint8), Codes(label, meaning)


def _pairs(first: NDArray[np.intp], weights: Colours) -> tuple[NDArray[np.intp], Colours]:
    """(n,) the weightiest class of colours but the one that is named, and the share of the latter of both."""
    colours = np.arange(len(first))
    rest = weights.copy()
    rest[first, colours] = -1.0
    second = np.argmax(rest, axis=0)
    a, b = weights[first, colours], weights[second, colours]
    return second, np.asarray(a / np.maximum(a + b, 1e-30))


def _costs(config: ImageConfig, classes: Sequence[ClassConfig], code: NDArray) -> tuple[Colours, Colours]:
    """(classes, n) -2 log likelihood of 16-bit colours (n,) under each class; and the same with inf where a colour
    deviates too much from it, or is a grey."""
    bgr = np.stack([(code & 31) / 31, (code >> 5 & 63) / 63, (code >> 11) / 31], axis=-1).astype(np.float32)
    hsv = cv2.cvtColor(bgr[None], cv2.COLOR_BGR2HSV)[0]  # (n, 3) degrees, 0..1, 0..1
    costs = []
    for cls in classes:
        if cls.rgb:
            grey = as_grey(bgr, cls.spread, config.noise)
            both = [cost_of(bgr, _references_bgr(one)[0], one, config, grey) for one in lone(cls)]
            costs.append([np.min(c, axis=0) for c in zip(*both, strict=True)])
        else:
            costs.append([np.where(_in_class(hsv, cls), np.float32(_BY_RANGE), np.float32(np.inf))] * 2)
    cost, held = np.asarray(costs, np.float32).reshape(-1, 2, len(bgr)).swapaxes(0, 1)
    return cost, held


def _references_bgr(cls: ClassConfig) -> Colours:
    """(n, 3) a class' reference colours, channels blue, green, red, 0..1."""
    return np.asarray(np.reshape(cls.rgb, (-1, 3))[:, ::-1] / 255, np.float32)


def lone(cls: ClassConfig) -> list[ClassConfig]:
    """A class with reference colours as classes of one each, with the light of that one."""
    colours, lights = np.reshape(cls.rgb, (-1, 3)).tolist(), np.reshape(cls.light, (-1, 2)).tolist()
    lights = lights * len(colours) if len(lights) == 1 else lights
    return [replace(cls, rgb=tuple(colour), light=tuple(light)) for colour, light in zip(colours, lights, strict=True)]


def ray(reference: Colours, light: tuple[float, ...]) -> tuple[Colours, Colours]:
    """A reference colour (3,) in less and more light: the factors (n,) and the colours (n, 3)."""
    factors = np.geomspace(light[0], light[1], _LIGHTS, dtype=np.float32)
    return factors, np.minimum(factors[:, None] * reference, 1.0)


def deviation(bgr: Colours, shown: Colours, spread: float, noise: float) -> tuple[Colours, Colours]:
    """How far colours (N, 3) are from a ray's (n, 3).

    :return: (n, N) squared distances in units of the scatter there; (n, 1) what greater scatter costs: -2 log of the
        Gaussian's height, over the two dimensions across the ray, and 0 in the dark. A ray's colours are rows: the
        least along columns is told many times faster than along short rows.
    """
    scatter = np.hypot(noise, spread * np.linalg.norm(shown, axis=1))[:, None]
    squared = shown @ (-2 * bgr).T
    squared += np.sum(bgr**2, axis=1)
    squared += np.sum(shown**2, axis=1)[:, None]
    np.maximum(squared, 0, out=squared)
    squared /= scatter**2
    return squared, 4 * np.log(scatter / noise)


def as_grey(bgr: Colours, spread: float, noise: float) -> Colours:
    """(N,) -2 log likelihood of colours (N, 3) as the grey that is most like each, light apart."""
    return np.asarray(np.add(*deviation(bgr, _GREYS, spread, noise)).min(axis=0), np.float32)


def is_grey(reference: Colours, spread: float, noise: float) -> bool:
    """Whether a reference colour (3,) is one, and its hue chance."""
    return bool(deviation(reference[None], _GREYS, spread, noise)[0].min() <= _GREY**2)


def cost_of(
    bgr: Colours, reference: Colours, cls: ClassConfig, config: ImageConfig, grey: Colours
) -> tuple[Colours, Colours]:
    """(N,) -2 log likelihood of colours on a reference's ray, up to a constant; and the same with inf for those that
    deviate too much.

    Light itself is likelier to be as it was than much darker or brighter (log-normal): what tells white in
    the shade from grey. What is more like some grey is not for a class that is none: greys are everywhere.

    :param grey: what `as_grey` says of the colours.
    """
    factors, shown = ray(reference, cls.light)
    squared, across = deviation(bgr, shown, cls.spread, config.noise)
    every = squared + across
    as_own = every.min(axis=0)
    every += ((np.log(factors) / config.light_spread) ** 2)[:, None]
    cost = every.min(axis=0)
    np.putmask(every, squared > config.max_deviation**2, np.inf)
    held = every.min(axis=0)
    if not is_grey(reference, cls.spread, config.noise):
        cost += 2 * np.logaddexp(0, (as_own - grey) / 2)
        held = np.where(grey < as_own, np.inf, held)
    return cost.astype(np.float32), held.astype(np.float32)


def _in_class(hsv: Colours, cls: ClassConfig) -> NDArray[np.bool_]:
    hue, saturation, value = hsv.T
    inside = (saturation >= cls.saturation[0]) & (saturation <= cls.saturation[1])
    inside &= (value >= cls.value[0]) & (value <= cls.value[1])
    if not cls.hue:
        return inside
    ranges = np.reshape(cls.hue, (-1, 2)).tolist()
    arcs = [(hue - first) % 360 <= last - first + (360 if last < first else 0) for first, last in ranges]
    return inside & np.logical_or.reduce(arcs)
