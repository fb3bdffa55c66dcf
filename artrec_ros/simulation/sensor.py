"""From what each sample point shows to images: light, lens, sensor, and a colour segmenter."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from .config import SensorConfig
from .render import SUPERSAMPLING, Rendering

_NAMED_RGB = (
    (55, 53, 56),  # what is behind everything
    (40, 160, 45),
    (30, 60, 190),
    (200, 30, 40),
    (240, 140, 30),
    (225, 225, 225),
    (235, 220, 30),
    (90, 190, 240),
)
_LUT_BITS = 5
_GAINS = (0.5, 1.5)  # light in which a class is still told
_TOLERANCE = 0.13  # greatest distance from a class's colour in the best light, as a share of full scale
_LIGHT_FROM = np.array([0.3, -0.8, -0.5]) / np.linalg.norm([0.3, -0.8, -0.5])  # above, behind the camera
_UNLIT = 0.8  # brightness of a face that is turned away from the light


@lru_cache(maxsize=1)
def palette() -> NDArray[np.uint8]:
    """(256, 3) BGR of each class: black, green, blue, red, orange, white, yellow, sky blue, then spread in hue."""
    hue = (np.arange(256) * 0.618034 % 1 * 180).astype(np.uint8)  # golden ratio: neighbours differ
    hsv = np.stack([hue, np.full(256, 210, np.uint8), np.full(256, 220, np.uint8)], axis=-1)
    colours = cv2.cvtColor(hsv[None], cv2.COLOR_HSV2BGR)[0]
    colours[: len(_NAMED_RGB)] = np.array(_NAMED_RGB, np.uint8)[:, ::-1]
    colours.setflags(write=False)
    return colours


def majority_labels(sample_labels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(H, W) the class that fills most of each pixel; of equals the lowest."""
    classes = np.unique(sample_labels)
    size = (sample_labels.shape[1] // SUPERSAMPLING, sample_labels.shape[0] // SUPERSAMPLING)
    shares = [cv2.resize((sample_labels == c).astype(np.float32), size, interpolation=cv2.INTER_AREA) for c in classes]
    return classes[np.argmax(shares, axis=0)]


def colour_image(rendering: Rendering, config: SensorConfig, rng: np.random.Generator) -> NDArray[np.uint8]:
    """(H, W, 3) BGR, what a camera gives of the scene."""
    shade = [_UNLIT + (1 - _UNLIT) * max(0.0, float(s.normal @ _LIGHT_FROM)) for s in rendering.surfaces] + [1.0, 1.0]
    shown = palette()[rendering.sample_labels] * np.array(shade, np.float32)[rendering.index, None]
    size = (shown.shape[1] // SUPERSAMPLING, shown.shape[0] // SUPERSAMPLING)
    image = cv2.resize(shown, size, interpolation=cv2.INTER_AREA)
    if config.light > 0:
        image *= _light(size, config.light, rng)[..., None]
    if config.blur_px > 0:
        image = cv2.GaussianBlur(image, (0, 0), config.blur_px)
    if config.motion_blur_px > 0:
        image = smeared(image, rng.uniform(0, config.motion_blur_px), rng.uniform(0, np.pi))
    if config.pixel_noise > 0:
        image += rng.normal(0, config.pixel_noise * 255, image.shape)
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def _light(size: tuple[int, int], sigma: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """(H, W) gain that varies slowly over the image."""
    coarse = rng.normal(0, sigma, (4, 5)).astype(np.float32)
    return np.exp(cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC))


def smeared(image: NDArray[np.float32], way_px: float, direction_rad: float) -> NDArray[np.float32]:
    """The mean of the image along a way of that length."""
    steps = int(np.ceil(way_px)) * 2 + 1
    offsets = np.linspace(-way_px / 2, way_px / 2, steps)
    size = (image.shape[1], image.shape[0])
    total = np.zeros_like(image)
    for offset in offsets:
        dx, dy = offset * np.cos(direction_rad), offset * np.sin(direction_rad)
        shift = np.array([[1, 0, dx], [0, 1, dy]])
        total += cv2.warpAffine(image, shift, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(total / steps, np.float32)


def segment(image: NDArray[np.uint8], classes: tuple[int, ...]) -> NDArray[np.uint8]:
    """(H, W) labels of a BGR image by its nearest class colour under any light; 0 where none is near."""
    b, g, r = (image[..., i] >> (8 - _LUT_BITS) for i in range(3))
    return _class_table(classes)[b, g, r]


@lru_cache(maxsize=8)
def _class_table(classes: tuple[int, ...]) -> NDArray[np.uint8]:
    """(32, 32, 32) label of each colour, indexed by blue, green, red."""
    levels = (np.arange(1 << _LUT_BITS) + 0.5) / (1 << _LUT_BITS)
    colours = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1)  # (32, 32, 32, 3)
    known = palette()[list(classes)] / 255.0  # (n, 3)
    gain = np.clip(colours @ known.T / np.sum(known**2, axis=1), *_GAINS)  # (32, 32, 32, n)
    distance = np.linalg.norm(colours[..., None, :] - gain[..., None] * known, axis=-1)
    nearest = np.array(classes, np.uint8)[np.argmin(distance, axis=-1)]
    return np.where(distance.min(axis=-1) <= _TOLERANCE, nearest, 0).astype(np.uint8)


def add_speckle(
    labels: NDArray[np.uint8], share: float, classes: tuple[int, ...], rng: np.random.Generator
) -> NDArray[np.uint8]:
    """The labels with that share of the pixels given a class by chance."""
    hit = rng.random(labels.shape) < share
    return np.where(hit, rng.choice(np.array(classes, np.uint8), labels.shape), labels)


def add_spots(
    labels: NDArray[np.uint8], most: int, classes: tuple[int, ...], rng: np.random.Generator
) -> NDArray[np.uint8]:
    """The labels with up to so many discs of a class drawn by chance, 0.5 to 2 % of the image's width in radius."""
    spotted = labels.copy()
    height, width = labels.shape
    for _ in range(int(rng.integers(0, most + 1))):
        centre = int(rng.integers(width)), int(rng.integers(height))
        radius = max(1, round(float(rng.uniform(0.005, 0.02)) * width))
        cv2.circle(spotted, centre, radius, int(rng.choice(classes)), cv2.FILLED)
    return spotted


def label_image(
    rendering: Rendering, image: NDArray[np.uint8], config: SensorConfig, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """(H, W) what a segmenter makes of `image`; with an ideal sensor the class that fills most of each pixel."""
    if config.is_ideal:
        return majority_labels(rendering.sample_labels)
    labels = [s.label for s in rendering.surfaces] + [rendering.floor_label]
    classes = tuple(sorted(set(labels) | {0}))
    labels_seen = add_speckle(segment(image, classes), config.speckle, classes, rng)
    return add_spots(labels_seen, config.spots, classes, rng) if config.spots else labels_seen
