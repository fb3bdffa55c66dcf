"""Which class a colour belongs to, for every 16-bit colour once: classifying an image is one look-up per pixel.

A class is given in one of two ways. By ranges of hue, saturation and value: a colour belongs to it or does not. Or
by reference colours: light and shade scale a colour, so the class is a stretch of a ray through the origin (bent
where a channel is full), and a colour belongs to the ray that makes it most likely. The scatter about a ray is a
share of its brightness plus the sensor's noise, which does not shrink in the dark: there chromaticity is worth
less, as it should be. In log-chromaticity the same says: shade shifts brightness alone, and noise grows with it.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import ClassConfig, ImageConfig

_LIGHTS = 24  # samples of a ray between its darkest and its brightest
_GREY = 2.0  # a reference within so many standard deviations of grey is a grey
_BY_RANGE = -1.0  # cost of a colour within a class' ranges: below any reference's

Colours = NDArray[np.float32]


def colour_table(config: ImageConfig) -> NDArray[np.uint8]:
    """(65536,) class number of every 16-bit colour (blue in the low 5 bits, green, red in the high 5)."""
    code = np.arange(1 << 16)
    bgr = np.stack([(code & 31) / 31, (code >> 5 & 63) / 63, (code >> 11) / 31], axis=-1).astype(np.float32)
    hsv = cv2.cvtColor(bgr[None], cv2.COLOR_BGR2HSV)[0]  # (65536, 3) degrees, 0..1, 0..1
    table = np.zeros(len(code), np.uint8)
    least = np.full(len(code), np.inf, np.float32)
    background = ClassConfig(label=0, rgb=config.background)
    for cls in (*config.classes.values(), *([background] if config.background else [])):
        if cls.rgb:
            cost = np.min([_cost(bgr, references_bgr(one)[0], one, config) for one in lone(cls)], axis=0)
        else:
            cost = np.where(_in_class(hsv, cls), _BY_RANGE, np.inf)
        better = cost < least  # of equals the first listed
        table[better] = cls.label
        least[better] = cost[better]
    return table


def references_bgr(cls: ClassConfig) -> Colours:
    """(n, 3) a class' reference colours, channels blue, green, red, 0..1."""
    return np.asarray(np.reshape(cls.rgb, (-1, 3))[:, ::-1] / 255, np.float32)


def lone(cls: ClassConfig) -> list[ClassConfig]:
    """A class with reference colours as classes of one each, with the light of that one."""
    colours, lights = np.reshape(cls.rgb, (-1, 3)).tolist(), np.reshape(cls.light, (-1, 2)).tolist()
    lights = lights * len(colours) if len(lights) == 1 else lights
    return [
        replace(cls, rgb=tuple(colour), light=tuple(light)) for colour, light in zip(colours, lights, strict=True)
    ]


def ray(reference: Colours, light: tuple[float, ...]) -> tuple[Colours, Colours]:
    """A reference colour (3,) in less and more light: the factors (n,) and the colours (n, 3)."""
    factors = np.geomspace(light[0], light[1], _LIGHTS, dtype=np.float32)
    return factors, np.minimum(factors[:, None] * reference, 1.0)


def deviation(bgr: Colours, shown: Colours, spread: float, noise: float) -> tuple[Colours, Colours]:
    """How far colours (N, 3) are from a ray's (n, 3).

    :return: (N, n) squared distances in units of the scatter there; (n,) what greater scatter costs: -2 log of the
        Gaussian's height, over the two dimensions across the ray, and 0 in the dark.
    """
    scatter = np.hypot(noise, spread * np.linalg.norm(shown, axis=1))
    squared = np.sum(bgr**2, axis=1)[:, None] - 2 * bgr @ shown.T + np.sum(shown**2, axis=1)
    return np.maximum(squared, 0) / scatter**2, 4 * np.log(scatter / noise)


def _cost(bgr: Colours, reference: Colours, cls: ClassConfig, config: ImageConfig) -> Colours:
    """(N,) -2 log likelihood of colours on a reference's ray, up to a constant; inf for those that deviate too much.

    Light itself is likelier to be as it was than much darker or brighter (log-normal): what tells white in
    the shade from grey. What is more like some grey is not for a class that is none: greys are everywhere.
    """
    factors, shown = ray(reference, cls.light)
    squared, across = deviation(bgr, shown, cls.spread, config.noise)
    light = (np.log(factors) / config.light_spread) ** 2
    cost = np.full(len(bgr), np.inf, np.float32)
    near = np.flatnonzero(squared.min(axis=1) <= config.max_deviation**2)
    squared = squared[near]
    cost[near] = np.where(squared <= config.max_deviation**2, squared + across + light, np.inf).min(axis=1)
    greys = np.linspace(0, 1, _LIGHTS, dtype=np.float32)[:, None].repeat(3, axis=1)
    if deviation(reference[None], greys, cls.spread, config.noise)[0].min() > _GREY**2:
        as_grey = np.add(*deviation(bgr[near], greys, cls.spread, config.noise)).min(axis=1)
        cost[near[as_grey < np.min(squared + across, axis=1)]] = np.inf
    return cost


def _in_class(hsv: Colours, cls: ClassConfig) -> NDArray[np.bool_]:
    hue, saturation, value = hsv.T
    inside = (saturation >= cls.saturation[0]) & (saturation <= cls.saturation[1])
    inside &= (value >= cls.value[0]) & (value <= cls.value[1])
    if not cls.hue:
        return inside
    ranges = np.reshape(cls.hue, (-1, 2)).tolist()
    arcs = [(hue - first) % 360 <= last - first + (360 if last < first else 0) for first, last in ranges]
    return inside & np.logical_or.reduce(arcs)
