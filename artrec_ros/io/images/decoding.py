"""Bytes of image messages and image files to arrays. Every failure is an `ImageError` of one line."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.base.errors import ConfigError, ImageError
from ..base.yaml_files import read_bytes

Image = NDArray[Any]

MAX_PIXELS = 64 * 2**20
"""An image that claims more is taken for damaged: it is refused before memory is spent on it."""

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp")

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
_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
_JPEG_START_OF_FRAME = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


def decode_image(encoding: str, height: int, width: int, step: int, is_bigendian: bool, data: Any) -> Image:
    """The pixels of a sensor_msgs/Image.

    :param step: bytes per row, padding included.
    :param data: anything with the buffer protocol; the result may share it, and is then read-only where it is.
    :return: (H, W) uint8 or uint16 for one channel, (H, W, 3) uint8 BGR otherwise.
    :raises ImageError: unknown encoding, no or too many pixels, a step too small, too few bytes.
    """
    if encoding not in ENCODINGS:
        raise ImageError(f"encoding '{encoding}' is none of {', '.join(ENCODINGS)}")
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
        return image[:, :, 0] if depth == 1 else image[:, :, 0].astype(np.uint16, copy=False)
    return image if conversion is None else cv2.cvtColor(np.ascontiguousarray(image), conversion)


def decode_compressed(image_format: str, data: Any) -> Image:
    """The pixels of a sensor_msgs/CompressedImage that holds PNG or JPEG.

    :param image_format: the message's `format`, such as 'png', 'mono8; png compressed', 'bgr8; jpeg compressed bgr8'.
    :return: as `decode_image`; an alpha channel is dropped.
    :raises ImageError: depth images, other formats, damaged or truncated data, implausible sizes.
    """
    if "compressedDepth" in image_format:
        raise ImageError(f"format '{image_format}': depth images hold no classes and no colours; choose another topic")
    return decode_encoded(data)


def decode_encoded(data: Any) -> Image:
    """The pixels of an encoded image (PNG, JPEG, BMP, GIF): as `decode_compressed`."""
    return _as_supported(decode_unchanged(data))


def decode_unchanged(data: Any) -> Image:
    """As `decode_encoded`, with whatever channels and depth the image has."""
    raw = np.frombuffer(data, np.uint8)
    encoded = raw.tobytes()
    size_of = _size_reader(encoded)
    try:
        width, height = size_of(encoded)
    except (struct.error, IndexError) as error:
        raise ImageError(f"the image ends within its header ({len(encoded)} bytes)") from error
    _check_size(width, height, "compressed image")
    try:
        image = cv2.imdecode(raw, cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise ImageError(f"damaged image of {len(encoded)} bytes: {error.err}") from error
    if image is None:
        raise ImageError(f"damaged image: {len(encoded)} bytes for {width}x{height} pixels could not be decoded")
    return image


def transport_format(data: bytes) -> str | None:
    """What image_transport calls an encoded image, the `format` of a CompressedImage; None: it knows no such format.

    :raises ImageError: the image ends within its header.
    """
    try:
        if data.startswith(_PNG_MAGIC):
            depth, colours = data[24], data[25]
            encoding = ("mono16" if depth == 16 else "mono8") if colours == 0 else "bgra8" if colours == 6 else "bgr8"
            return f"{encoding}; png compressed {encoding}"
        if data.startswith(b"\xff\xd8"):
            encoding = "mono8" if data[_jpeg_frame(data) + 9] == 1 else "bgr8"
            return f"{encoding}; jpeg compressed {encoding}"
    except (struct.error, IndexError) as error:
        raise ImageError(f"the image ends within its header ({len(data)} bytes)") from error
    return None


def read_image(path: Path) -> Image:
    """The pixels of an image file: as `decode_compressed`. The error's text does not repeat the path."""
    try:
        data = read_bytes(path)
    except ConfigError as error:
        raise ImageError(str(error).removeprefix(f"{path}: ")) from error
    return decode_encoded(data)


def _as_supported(image: Image) -> Image:
    """An image as OpenCV decoded it, brought to the forms that `decode_image` gives."""
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
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


def _size_reader(encoded: bytes) -> Callable[[bytes], tuple[int, int]]:
    if encoded.startswith(_PNG_MAGIC):
        return _png_size
    if encoded.startswith(b"\xff\xd8"):
        return _jpeg_size
    if encoded.startswith(b"BM"):
        return _bmp_size
    if encoded.startswith(b"GIF8"):
        return _gif_size
    raise ImageError(
        f"{len(encoded)} bytes that are neither PNG, JPEG, BMP nor GIF (they start with '{encoded[:8].hex(' ')}')"
    )


def _png_size(encoded: bytes) -> tuple[int, int]:
    width, height = struct.unpack_from(">II", encoded, 16)
    position, kind = len(_PNG_MAGIC), b""
    while kind != b"IEND":  # a decoder fills a truncated image with black in silence
        if position + 12 > len(encoded):
            raise ImageError(f"truncated PNG: {len(encoded)} bytes without its end")
        length, kind = struct.unpack_from(">I4s", encoded, position)
        position += 12 + length
    return width, height


def _jpeg_frame(encoded: bytes) -> int:
    """Where the frame header begins."""
    position = 2
    while True:
        while encoded[position] == 0xFF and encoded[position + 1] == 0xFF:  # fill bytes before a marker
            position += 1
        if encoded[position] != 0xFF:
            raise ImageError(f"damaged JPEG: no marker at byte {position}")
        marker, length = struct.unpack_from(">BH", encoded, position + 1)
        if marker in _JPEG_START_OF_FRAME:
            return position
        if marker in (0xD9, 0xDA):
            raise ImageError("damaged JPEG: it has no frame header")
        position += 2 + length


def _jpeg_size(encoded: bytes) -> tuple[int, int]:
    position = _jpeg_frame(encoded)
    height, width = struct.unpack_from(">HH", encoded, position + 5)
    if encoded.find(b"\xff\xd9", position) < 0:  # a decoder fills a truncated image with grey in silence
        raise ImageError(f"truncated JPEG: {len(encoded)} bytes without its end")
    return width, height


def _gif_size(encoded: bytes) -> tuple[int, int]:
    width, height = struct.unpack_from("<HH", encoded, 6)
    return width, height


def _bmp_size(encoded: bytes) -> tuple[int, int]:
    width, height = struct.unpack_from("<ii", encoded, 18)
    return width, abs(height)
