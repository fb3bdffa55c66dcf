"""Bytes of image messages and image files to arrays. Every failure is an `ImageError` of one line."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.base.errors import ConfigError, ImageError
from ..base.yaml_files import read_bytes, shown
from .headers import GIF_MAGIC, grey_bits_of, orientation_of, size_of

Image = NDArray[Any]

MAX_PIXELS = 64 * 2**20
"""An image that claims more is taken for damaged: it is refused before memory is spent on it."""

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".bmp")
_SHOWN = 60  # letters of a text of unknown length
_SMALLEST_GIF = bytes.fromhex("47494638396101000100800000000000ffffff2c000000000100010000020144003b")
_TURNED = 5  # the first EXIF orientation whose rows are columns

# encoding -> channels, bytes per channel, OpenCV conversion to BGR
ENCODINGS: dict[str, tuple[int, int, int | None]] = {
    "mono8": (1, 1, None),
    "8UC1": (1, 1, None),
    "mono16": (1, 2, None),
    "16UC1": (1, 2, None),
    "bgr8": (3, 1, None),
    "8UC3": (3, 1, None),
    "rgb8": (3, 1, cv2.COLOR_RGB2BGR),
    "bgra8": (4, 1, cv2.COLOR_BGRA2BGR),
    "rgba8": (4, 1, cv2.COLOR_RGBA2BGR),
}


def silence_opencv() -> None:
    """From now on OpenCV logs no line of its own for each image that it cannot read, of which our errors tell.

    For the whole process; a level that the user has set in the environment stays.
    """
    logging = getattr(getattr(cv2, "utils", None), "logging", None)  # not in every build
    if logging is not None and "OPENCV_LOG_LEVEL" not in os.environ:
        logging.setLogLevel(logging.LOG_LEVEL_FATAL)


def decode_image(encoding: str, height: int, width: int, step: int, is_bigendian: bool, data: Any) -> Image:
    """The pixels of a sensor_msgs/Image.

    :param step: bytes per row, padding included.
    :param data: anything with the buffer protocol; the result may share it, and is then read-only where it is.
    :return: (H, W) uint8 or uint16 for one channel, (H, W, 3) uint8 BGR otherwise.
    :raises ImageError: unknown encoding, no or too many pixels, a step too small, too few bytes.
    """
    if encoding not in ENCODINGS:
        raise ImageError(
            f"encoding {shown(encoding)} is none of {', '.join(ENCODINGS)}; convert the images, or choose another topic"
        )
    channels, depth, conversion = ENCODINGS[encoding]
    _check_size(width, height, "image")
    row = width * channels * depth
    if step < row:
        raise ImageError(f"step {step} is too small: {width} pixels of {encoding} take {row} bytes")
    raw = np.frombuffer(data, np.uint8)
    least = step * (height - 1) + row  # the last row's padding may be missing
    if raw.size < least:
        raise ImageError(f"{raw.size} bytes of data, but {width}x{height} {encoding} with step {step} takes {least}")
    dtype = np.dtype(np.uint8) if depth == 1 else np.dtype(">u2" if is_bigendian else "<u2")
    strides = (step, channels * depth, depth)
    image: Image = np.ndarray((height, width, channels), dtype, buffer=raw, strides=strides)
    if channels == 1:
        # OpenCV takes no rows that begin within a number
        return image[:, :, 0] if depth == 1 else np.require(image[:, :, 0].astype(np.uint16, copy=False), None, ["A"])
    return image if conversion is None else cv2.cvtColor(np.ascontiguousarray(image), conversion)


def decode_compressed(image_format: str, data: Any) -> Image:
    """The pixels of a sensor_msgs/CompressedImage that holds PNG, JPEG, WebP, BMP or, where OpenCV reads it, GIF, as
    they lie: EXIF data turn nothing, for the calibration beside it is of the pixels as they lie.

    :param image_format: the message's `format`, such as 'png', 'mono8; png compressed', 'bgr8; jpeg compressed bgr8'.
    :return: as `decode_image`; an alpha channel is dropped.
    :raises ImageError: depth images, other formats, damaged or truncated data, implausible sizes.
    """
    if "compressedDepth" in image_format:
        raise ImageError(
            f"format {image_format[:_SHOWN]!r}: depth images hold no classes and no colours; choose another topic"
        )
    try:
        return decode_encoded(data)
    except ImageError as error:
        raise ImageError(f"{error}; the message's format is {image_format[:_SHOWN]!r}") from error


def decode_encoded(data: Any) -> Image:
    """The pixels of an encoded image (PNG, JPEG, WebP, BMP, GIF): as `decode_compressed`."""
    encoded = np.frombuffer(data, np.uint8).tobytes()
    return _as_supported(_unchanged(encoded), encoded)


def _unchanged(encoded: bytes) -> Image:
    """As `decode_encoded`, with whatever channels and depth the image has."""
    width, height = size_of(encoded)
    _check_size(width, height, "compressed image")
    try:
        image = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise ImageError(f"damaged image of {len(encoded)} bytes: {error.err}") from error
    if image is None:
        if encoded.startswith(GIF_MAGIC) and not _reads_gif():
            raise ImageError(f"a GIF, which this OpenCV, {cv2.__version__}, does not read: PNG or JPEG, please")
        raise ImageError(f"damaged image: {len(encoded)} bytes for {width}x{height} pixels could not be decoded")
    return image


@cache
def _reads_gif() -> bool:
    return cv2.imdecode(np.frombuffer(_SMALLEST_GIF, np.uint8), cv2.IMREAD_UNCHANGED) is not None


def decode_file(data: bytes) -> Image:
    """An image file with whatever channels and depth it has, upright as its EXIF data say: as annotation tools show it.

    :raises ImageError: as `decode_encoded`.
    """
    image = _unchanged(data)
    orientation = orientation_of(data)
    mirrored = (orientation - 1) % 4
    if orientation >= _TURNED:
        image = image.swapaxes(0, 1)
    rows, columns = mirrored in (2, 3), mirrored in (1, 2)
    return np.ascontiguousarray(image[:: -1 if rows else 1, :: -1 if columns else 1])


def read_image(path: Path) -> Image:
    """The pixels of an image file: upright, else as `decode_compressed`. The error's text does not repeat the path."""
    data = _bytes_of(path)
    return _as_supported(decode_file(data), data)


def size_of_image(path: Path) -> tuple[int, int]:
    """Width and height of an image file, upright, not decoded. Errors as `read_image`."""
    data = _bytes_of(path)
    width, height = size_of(data)
    return (height, width) if orientation_of(data) >= _TURNED else (width, height)


def _bytes_of(path: Path) -> bytes:
    try:
        return read_bytes(path)
    except ConfigError as error:
        raise ImageError(str(error).removeprefix(f"{path}: ")) from error


def _as_supported(image: Image, encoded: bytes) -> Image:
    """An image as OpenCV decoded it, brought to the forms that `decode_image` gives."""
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if image.ndim == 2 and (bits := grey_bits_of(encoded)) < 8:  # OpenCV spreads them over 0..255: no class numbers
        image = image // (255 // (2**bits - 1))
    if image.ndim == 2 and image.dtype in (np.uint8, np.uint16):
        return image
    if image.ndim == 3 and image.dtype == np.uint8:
        return image if image.shape[2] == 3 else cv2.cvtColor(image, cv2.COLOR_BGRA2BGR)
    raise ImageError(f"{image.dtype} images of {image.shape[-1]} channels are not supported: 8 bits a colour, please")


def _check_size(width: int, height: int, what: str) -> None:
    if width <= 0 or height <= 0:
        raise ImageError(f"{what} of {width}x{height} pixels: nothing to look at")
    if width * height > MAX_PIXELS:
        raise ImageError(f"{what} of {width}x{height} pixels is implausible (more than {MAX_PIXELS} pixels)")
