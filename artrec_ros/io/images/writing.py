"""Pictures as files."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from pathlib import Path

import cv2

from ...core.base.errors import ConfigError
from ..base.whole_files import save_file
from .decoding import Image

DRAWING = "drawn by artrec"
"""What drawings hold near their beginning: pictures of others do not."""
DRAWING_SUFFIXES = (".png", ".jpg", ".jpeg")

_PNG, _PNG_HEADER = b"\x89PNG", 33  # bytes of the signature and the first chunk, IHDR
_JPEG_COMMENT = b"\xff\xfe"


def save_picture(path: Path, picture: Image) -> None:
    """In the form that the name's end tells, whole or not at all.

    :raises ConfigError: there is no such form, or the file cannot be written.
    """
    save_file(path, _encoded(path, picture))


def save_drawing(path: Path, picture: Image, options: Sequence[int] = ()) -> None:
    """As `save_picture`, with `DRAWING` within, so that it may be drawn anew; to one of `DRAWING_SUFFIXES`.

    :param options: OpenCV's, of that form.
    """
    save_file(path, _noted(_encoded(path, picture, options)))


def _noted(data: bytes) -> bytes:
    """A PNG with a chunk of text behind its header, or a JPEG with a comment behind its first segment, JFIF."""
    if data.startswith(_PNG):
        chunk = b"tEXtSoftware\0" + DRAWING.encode()
        told = struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk))
        return data[:_PNG_HEADER] + told + data[_PNG_HEADER:]
    first_end = 4 + struct.unpack(">H", data[4:6])[0]  # the length counts its own two bytes, not the marker's
    told = _JPEG_COMMENT + struct.pack(">H", 2 + len(DRAWING)) + DRAWING.encode()
    return data[:first_end] + told + data[first_end:]


def _encoded(path: Path, picture: Image, options: Sequence[int] = ()) -> bytes:
    try:
        done, data = cv2.imencode(path.suffix, picture, list(options))
    except cv2.error:
        done = False
    if not done:
        raise ConfigError(f"{path}: '{path.suffix}' cannot hold this picture; let the name end in .png")
    return bytes(data.tobytes())
