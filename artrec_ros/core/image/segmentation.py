"""From an image to class labels (paper, step 1): each pixel one class number, 0 for background or unknown.

Colour costs next to nothing: OpenCV packs a pixel into 16 bits (5 of blue, 6 of green, 5 of red), and those index a
table that was filled once from the classes' ranges or reference colours (core/image/colour_table.py). A frame's gain is
applied before, so that the table never changes.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import GREATEST_LABEL, ImageConfig
from ..base.errors import ImageError
from .codes import LABELS
from .colour_table import colour_table

Image = NDArray[np.uint8]
_CUT_OFF = 0.02  # of a filter's taps, whose sum is 1, in sum at most
_FREQUENCIES = 256  # that a filter is made from: many more than it has taps


class Segmenter:
    """Reads images as an `ImageConfig` says. Holds no state between frames.

    :ivar meaning: of the codes that it reads.
    """

    def __init__(self, config: ImageConfig) -> None:
        self._config = config
        self._read = {"labels": self._from_labels, "palette": self._from_palette, "colour": self._from_colour}[
            config.kind
        ]
        self._table, self.meaning = colour_table(config) if config.kind == "colour" else (np.zeros(0, np.uint8), LABELS)
        self._nothing = int(np.flatnonzero(self.meaning.unknown)[0])

    @property
    def gamma(self) -> float:
        """Values of colour images grow with light to the power of its reciprocal."""
        return self._config.gamma

    @property
    def blank(self) -> tuple[int, ...]:
        """Ignored rectangles x,y,width,height,..., pixels: what ends there was not seen to end."""
        return self._config.blank

    def labels(self, image: NDArray) -> Image:
        """Class numbers (H, W) of an image's pixels, 0 is background or unknown; may be `image` itself. As `codes`."""
        codes = self.codes(image)
        return codes if self.meaning is LABELS else cv2.LUT(codes, self.meaning.label)

    def codes(self, image: NDArray) -> Image:
        """What an image's pixels show.

        :param image: kind `labels`: (H, W) uint8 or uint16, numbers above GREATEST_LABEL are unknown;
            `palette` and `colour`: (H, W, 3) uint8, channels blue, green, red.
        :return: (H, W) uint8, of the meaning `meaning`; may be `image` itself.
        :raises ImageError: the image does not fit the kind.
        """
        if image.size == 0:
            raise ImageError(f"the image is empty (shape {image.shape})")
        codes = self._read(image)
        if self._config.blank:
            codes = np.array(codes)
            for rectangle in rectangles(self._config.blank):
                codes[rectangle] = self._nothing
        return codes

    def _from_labels(self, image: NDArray) -> Image:
        if image.ndim != 2 or image.dtype not in (np.uint8, np.uint16):
            raise ImageError(
                f"image.kind 'labels' needs one channel (mono8, 8UC1, mono16, 16UC1), got {_kind(image)};"
                " set image.kind to palette or colour for colour images; an indexed PNG is read as one: save it as"
                " 8-bit grey, or set image.kind: palette"
            )
        if image.max() > GREATEST_LABEL:
            image = cv2.threshold(image, GREATEST_LABEL, 0, cv2.THRESH_TOZERO_INV)[1]
        return image.astype(np.uint8, copy=False)

    def _from_palette(self, image: NDArray) -> Image:
        _require_colour(image, self._config.kind)
        labels = np.zeros(image.shape[:2], np.uint8)
        for cls in reversed(self._config.classes.values()):  # the first listed is written last
            for rgb in np.reshape(cls.rgb, (-1, 3)).astype(int):
                low, high = (
                    np.clip(rgb[::-1] + d, 0, 255).tolist() for d in (-self._config.tolerance, self._config.tolerance)
                )
                labels[cv2.inRange(image, np.array(low, np.uint8), np.array(high, np.uint8)) > 0] = cls.label
        return labels

    def _from_colour(self, image: NDArray) -> Image:
        _require_colour(image, self._config.kind)
        image = filtered(evenly_lit(image, self._config), self._config)
        if self._config.sharpen_px > 0:
            image = unblur(image, self._config.sharpen_px, self._config.sharpen_amount)
            image = sharpen(image, self._config.sharpen_px, self._config.sharpen_step, self._config.gamma)
        return np.take(self._table, packed(image))


def packed(image: Image) -> NDArray[np.uint16]:
    """(H, W) the 16-bit colours, by which the table goes, of an image (H, W, 3) uint8 BGR."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2BGR565).view(np.uint16)[..., 0])


def evenly_lit(image: Image, config: ImageConfig) -> Image:
    """A colour image (H, W, 3) uint8 scaled so that the percentile of its brightness (largest channel), but for what is
    blank, is `gain_level`, as far as `gain_limit` lets it; may be `image` itself."""
    if config.gain_percentile == 0:
        return image
    step = max(1, min(image.shape[:2]) // 120)  # some 120 rows tell the percentile well enough
    sample = np.ascontiguousarray(image[::step, ::step])
    keep = np.full(sample.shape[:2], 255, np.uint8)
    for rectangle in rectangles(config.blank, step):
        keep[rectangle] = 0
    brightness = cv2.max(cv2.max(sample[..., 0], sample[..., 1]), sample[..., 2])
    share = np.cumsum(cv2.calcHist([brightness], [0], keep, [256], [0, 256]))
    level = int(np.searchsorted(share, config.gain_percentile / 100 * share[-1]))
    gain = float(np.clip(255 * config.gain_level / max(level, 1), 1 / config.gain_limit, config.gain_limit))
    return np.asarray(cv2.convertScaleAbs(image, alpha=gain), np.uint8)


def filtered(image: Image, config: ImageConfig) -> Image:
    """A colour image (H, W, 3) uint8 as colours are learned from it: smoothed, its blur undone, as configured."""
    if config.smoothing_px > 0:
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), config.smoothing_px), np.uint8)
    return deblur(image, config.blur_px, config.blur_noise) if config.blur_px > 0 else image


def as_light(image: Image, gamma: float) -> Image:
    """A colour image (H, W, 3) uint8 whose values grow with light: blends of two colours lie between them.

    :param gamma: values of the image given grow with light to the power of its reciprocal.
    """
    if gamma == 1.0:
        return image
    return np.asarray(cv2.LUT(image, np.rint(255 * _light_of(gamma)).astype(np.uint8)), np.uint8)


def _light(values: Image, gamma: float) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """The same in steps so fine that values of the dark are told apart."""
    return values if gamma == 1.0 else cv2.LUT(values, np.rint(65535 * _light_of(gamma)).astype(np.uint16))


@cache
def _light_of(gamma: float) -> NDArray[np.float64]:
    """(256,) light of each value, 0 to 1."""
    return np.asarray((np.arange(256) / 255) ** gamma)


def deblur(image: Image, blur_px: float, noise: float) -> Image:
    """An image as a sharper lens would have shown it: a Wiener filter for Gaussian blur, along rows, then columns.

    A lens blurs light, but the filter takes noise to be even, and that is so of values, which are about its root (JPEG
    rounds them; light scatters as its root). Undone in light, the noise of what is bright came threefold into the dark
    beside it, which took any hue: outlines on dark ground were frayed, and poses too near.

    :param image: (H, W, 3) uint8. :param blur_px: the blur's standard deviation, pixels.
    :param noise: power of the noise over that of the scene, the same at all frequencies.
    """
    taps = _wiener(blur_px, noise)
    return np.asarray(cv2.sepFilter2D(image, -1, taps, taps, borderType=cv2.BORDER_REPLICATE), np.uint8)


@cache
def _wiener(blur_px: float, noise: float) -> NDArray[np.float32]:
    """(2 r + 1,) the filter's taps, whose sum is 1."""
    blurred = np.exp(-2 * (np.pi * blur_px * np.fft.fftfreq(_FREQUENCIES)) ** 2)
    taps = np.fft.ifft(blurred / (blurred**2 + noise * (1 - blurred**2))).real
    half = len(taps) // 2
    beyond = 2 * np.abs(taps[half:0:-1]).cumsum()[::-1]  # of taps from one on outwards
    reach = max(int(np.argmax(beyond < _CUT_OFF)), 1) if (beyond < _CUT_OFF).any() else half - 1
    taps = np.concatenate([taps[-reach:], taps[: reach + 1]])
    return np.asarray(taps / taps.sum(), np.float32)


def unblur(image: Image, radius_px: int, amount: float) -> Image:
    """Adds the image's difference from its surroundings: a ribbon too narrow to reach its colour comes nearer to it.

    :param image: (H, W, 3) uint8.
    :param radius_px: half the standard deviation of the Gaussian that tells the surroundings.
    :param amount: share of the difference that is added; more brings out more noise.
    """
    if amount == 0:
        return image
    size = 8 * radius_px + 1  # to two standard deviations: the rest costs more than it tells
    surroundings = cv2.GaussianBlur(image, (size, size), 2.0 * radius_px)
    return np.asarray(cv2.addWeighted(image, 1 + amount, surroundings, -amount, 0), np.uint8)


def sharpen(image: Image, radius_px: int, step: float, gamma: float = 1.0) -> Image:
    """Each channel of a pixel on a step moved to the nearer of the step's two ends.

    Lenses, demosaicing and JPEG blend a marker's colour with its neighbour's, and a blend can be a third class'
    colour (blue on white: sky blue). Between two colours all channels change sides at the same place, half way,
    so the outline stays. Half way in light, which is what lenses blend: half of a value is outside of what is bright.

    :param image: (H, W, 3) uint8.
    :param radius_px: the ends are the least and the greatest value in a square of 2 radius + 1 pixels.
    :param step: least difference of the ends, 0..1; smaller ones are texture and noise and are left alone.
    :param gamma: see `as_light`.
    """
    square = np.ones((2 * radius_px + 1, 2 * radius_px + 1), np.uint8)
    flat = np.ascontiguousarray(image).reshape(len(image), -1)  # channels side by side: one mask serves all
    high = cv2.dilate(image, square).reshape(flat.shape)
    low = cv2.erode(image, square).reshape(flat.shape)
    is_step = cv2.compare(cv2.subtract(high, low), round(255 * step), cv2.CMP_GT)
    lit, most, least = (_light(values, gamma) for values in (flat, high, low))
    nearer = cv2.copyTo(high, cv2.compare(cv2.subtract(most, lit), cv2.subtract(lit, least), cv2.CMP_LT), low)
    return np.asarray(cv2.copyTo(nearer, is_step, flat.copy()), np.uint8).reshape(image.shape)


def rectangles(blank: tuple[int, ...], step: int = 1) -> list[tuple[slice, slice]]:
    """Rows and columns of the rectangles x,y,width,height,... in an image of which every `step`-th pixel was kept."""
    rectangles = []
    for x, y, width, height in np.reshape(blank, (-1, 4)).astype(int).tolist():
        left, top, right, bottom = (-(-edge // step) for edge in (x, y, x + width, y + height))  # rounded up
        rectangles.append((slice(top, bottom), slice(left, right)))
    return rectangles


def _require_colour(image: NDArray, kind: str) -> None:
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise ImageError(
            f"image.kind '{kind}' needs a colour image (bgr8, rgb8, bgra8, rgba8), got {_kind(image)}; "
            "set image.kind to labels for images of class numbers; of a grey camera give three equal channels"
        )


def _kind(image: NDArray) -> str:
    channels = 1 if image.ndim == 2 else image.shape[-1]
    return f"{channels} channel{'s' if channels != 1 else ''} of {image.dtype}"
