"""What encoded images tell before they are decoded: their size, their form, which way up they are."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator

from ...core.base.errors import ImageError

_PNG_MAGIC, _JPEG_MAGIC = b"\x89PNG\r\n\x1a\n", b"\xff\xd8"
GIF_MAGIC = b"GIF8"
_JPEG_START_OF_FRAME = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_EXIF_SEGMENT, _EXIF, _ORIENTATION = 0xE1, b"Exif\0\0", 0x0112


def size_of(encoded: bytes) -> tuple[int, int]:
    """Width and height in pixels, as they lie in the data. :raises ImageError: unknown, damaged or truncated."""
    read = _size_reader(encoded)
    try:
        return read(encoded)
    except (struct.error, IndexError) as error:
        raise _ends_early(encoded) from error


def transport_format(encoded: bytes) -> str | None:
    """What image_transport calls an encoded image, the `format` of a CompressedImage; None: it knows no such format.

    :raises ImageError: the image ends within its header.
    """
    try:
        if encoded.startswith(_PNG_MAGIC):
            depth, colours = encoded[24], encoded[25]
            encoding = ("mono16" if depth == 16 else "mono8") if colours == 0 else "bgra8" if colours == 6 else "bgr8"
            return f"{encoding}; png compressed {encoding}"
        if encoded.startswith(_JPEG_MAGIC):
            encoding = "mono8" if encoded[_jpeg_frame(encoded) + 9] == 1 else "bgr8"
            return f"{encoding}; jpeg compressed {encoding}"
    except (struct.error, IndexError) as error:
        raise _ends_early(encoded) from error
    return None


def grey_bits_of(encoded: bytes) -> int:
    """Of a PNG of one channel with less than 8 bits a pixel, so many; else 8."""
    is_grey = encoded.startswith(_PNG_MAGIC) and encoded[25:26] == b"\0"
    return min(encoded[24], 8) if is_grey else 8


def orientation_of(encoded: bytes) -> int:
    """EXIF's orientation of a JPEG, PNG or WebP, 1 to 8; 1, as it lies, where none is told."""
    try:
        return _orientation(next(_exif(encoded), b""))
    except (struct.error, IndexError, ImageError):  # a damaged note costs no image
        return 1


def _exif(encoded: bytes) -> Iterator[bytes]:
    """Metadata in the form of a TIFF file."""
    if encoded.startswith(_JPEG_MAGIC):
        for position, marker, length in _jpeg_segments(encoded):
            data = encoded[position + 4 : position + 2 + length]
            if marker == _EXIF_SEGMENT and data.startswith(_EXIF):
                yield data[len(_EXIF) :]
    elif encoded.startswith(_PNG_MAGIC):
        yield from (encoded[begin:end] for kind, begin, end in _png_chunks(encoded) if kind == b"eXIf")
    elif _is_webp(encoded):
        notes = (encoded[begin:end] for kind, begin, end in _webp_chunks(encoded) if kind == b"EXIF")
        yield from (note.removeprefix(_EXIF) for note in notes)


def _orientation(tiff: bytes) -> int:
    order = {b"II": "<", b"MM": ">"}.get(tiff[:2])
    if order is None:
        return 1
    (directory,) = struct.unpack_from(order + "I", tiff, 4)
    (count,) = struct.unpack_from(order + "H", tiff, directory)
    for entry in range(directory + 2, directory + 2 + 12 * count, 12):
        tag, value = struct.unpack_from(order + "H6xH", tiff, entry)
        if tag == _ORIENTATION:
            return int(value) if 1 <= value <= 8 else 1
    return 1


def _ends_early(encoded: bytes) -> ImageError:
    return ImageError(f"the image ends within its header ({len(encoded)} bytes)")


def _size_reader(encoded: bytes) -> Callable[[bytes], tuple[int, int]]:
    if encoded.startswith(_PNG_MAGIC):
        return _png_size
    if encoded.startswith(_JPEG_MAGIC):
        return _jpeg_size
    if _is_webp(encoded):
        return _webp_size
    if encoded.startswith(b"BM"):
        return _bmp_size
    if encoded.startswith(GIF_MAGIC):
        return _gif_size
    if not encoded:
        raise ImageError("it is empty")
    raise ImageError(
        f"{len(encoded)} bytes that are neither PNG, JPEG, WebP, BMP nor GIF (they start with '{encoded[:8].hex(' ')}')"
    )


def _png_size(encoded: bytes) -> tuple[int, int]:
    width, height = struct.unpack_from(">II", encoded, 16)
    for _ in _png_chunks(encoded):  # to its end: a decoder fills a truncated image with black in silence
        pass
    return width, height


def _png_chunks(encoded: bytes) -> Iterator[tuple[bytes, int, int]]:
    """Kind, begin and end of each one's data. :raises ImageError: it is cut off."""
    position, kind = len(_PNG_MAGIC), b""
    while kind != b"IEND":
        if position + 12 > len(encoded):
            raise ImageError(f"truncated PNG: {len(encoded)} bytes without its end")
        length, kind = struct.unpack_from(">I4s", encoded, position)
        yield kind, position + 8, position + 8 + length
        position += 12 + length


def _jpeg_segments(encoded: bytes) -> Iterator[tuple[int, int, int]]:
    """Where each one before the pixels begins, its marker, and its length."""
    position, marker = 2, 0
    while marker not in (0xD9, 0xDA):
        while encoded[position] == 0xFF and encoded[position + 1] == 0xFF:  # fill bytes before a marker
            position += 1
        if encoded[position] != 0xFF:
            raise ImageError(f"damaged JPEG: no marker at byte {position}")
        marker, length = struct.unpack_from(">BH", encoded, position + 1)
        yield position, marker, length
        position += 2 + length


def _jpeg_frame(encoded: bytes) -> int:
    """Where the frame header begins."""
    for position, marker, _ in _jpeg_segments(encoded):
        if marker in _JPEG_START_OF_FRAME:
            return position
    raise ImageError("damaged JPEG: it has no frame header")


def _jpeg_size(encoded: bytes) -> tuple[int, int]:
    position = _jpeg_frame(encoded)
    height, width = struct.unpack_from(">HH", encoded, position + 5)
    if encoded.find(b"\xff\xd9", position) < 0:  # a decoder fills a truncated image with grey in silence
        raise ImageError(f"truncated JPEG: {len(encoded)} bytes without its end")
    return width, height


def _is_webp(encoded: bytes) -> bool:
    return encoded.startswith(b"RIFF") and encoded[8:12] == b"WEBP"


def _webp_chunks(encoded: bytes) -> Iterator[tuple[bytes, int, int]]:
    """Kind, begin and end of each one's data, of those that are whole."""
    position = 12
    while position + 8 <= len(encoded):
        kind, length = struct.unpack_from("<4sI", encoded, position)
        yield kind, position + 8, position + 8 + length
        position += 8 + length + length % 2


def _webp_size(encoded: bytes) -> tuple[int, int]:
    if struct.unpack_from("<I", encoded, 4)[0] + 8 > len(encoded):
        raise ImageError(f"truncated WebP: {len(encoded)} bytes without its end")
    kind, begin, _ = next(_webp_chunks(encoded), (b"", 0, 0))
    if kind == b"VP8 ":  # lossy
        width, height = struct.unpack_from("<HH", encoded, begin + 6)
        return width & 0x3FFF, height & 0x3FFF
    if kind == b"VP8L":
        (bits,) = struct.unpack_from("<I", encoded, begin + 1)
        return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    if kind == b"VP8X":  # with alpha, movement or notes
        width, height = (int.from_bytes(encoded[begin + at : begin + at + 3], "little") + 1 for at in (4, 7))
        return width, height
    raise ImageError("damaged WebP: it has no frame header")


def _gif_size(encoded: bytes) -> tuple[int, int]:
    width, height = struct.unpack_from("<HH", encoded, 6)
    return width, height


def _bmp_size(encoded: bytes) -> tuple[int, int]:
    width, height = struct.unpack_from("<ii", encoded, 18)
    return width, abs(height)
