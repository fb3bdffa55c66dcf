"""Messages that no camera should send, as hypothesis' strategies."""

from __future__ import annotations

import array
import struct
import zlib
from typing import Any

import cv2
import numpy as np
import toy
from builtin_interfaces.msg import Time
from hypothesis import strategies as st
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, RegionOfInterest
from std_msgs.msg import Header

from artrec_ros.io.images.decoding import ENCODINGS

UINT32 = 2**32 - 1
BYTES = np.random.default_rng(0).integers(0, 256, 2**16, np.uint8).tobytes()
BYTES_PER_PIXEL = {name: channels * depth for name, (channels, depth, _) in ENCODINGS.items()}

any_float = st.floats(allow_nan=True, allow_infinity=True, width=64)
lengths = st.one_of(st.integers(0, 70), st.sampled_from([toy.SIZE[0], toy.SIZE[1], 2**16, 2**31, UINT32]))
counts = st.one_of(st.integers(0, 3), st.integers(0, UINT32))
texts = st.text(st.characters(blacklist_categories=("Cs",), blacklist_characters="\0"), max_size=12)


@st.composite
def headers(draw: st.DrawFn) -> Header:
    """Of any time, zero and negative ones too, and any frame."""
    sec = draw(st.one_of(st.just(0), st.integers(-(2**31), 2**31 - 1)))
    nanosec = draw(st.one_of(st.just(0), st.integers(0, UINT32)))
    return Header(stamp=Time(sec=sec, nanosec=nanosec), frame_id=draw(st.one_of(st.just("eye"), texts)))


@st.composite
def images(draw: st.DrawFn) -> Image:
    """Sizes, steps, encodings and data that may fit one another, nearly or not at all."""
    encoding = draw(st.one_of(st.sampled_from(sorted(BYTES_PER_PIXEL)), texts))
    height, width = draw(lengths), draw(lengths)
    row = width * BYTES_PER_PIXEL.get(encoding, 1)
    step = draw(st.one_of(st.just(row), st.integers(max(0, row - 2), row + 9), lengths)) % (UINT32 + 1)
    wanted = draw(st.one_of(st.just(step * height), st.integers(-3, 3).map(lambda d: step * height + d), lengths))
    start = draw(st.integers(0, 1000))
    data = (BYTES[start:] if draw(st.booleans()) else bytes(len(BYTES)))[: max(0, min(wanted, len(BYTES)))]
    msg = Image(header=draw(headers()), height=height, width=width, step=step, encoding=encoding)
    msg.is_bigendian = draw(st.sampled_from([0, 1, 255]))
    msg.data = array.array("B", data)
    return msg


def png_header(width: int, height: int, depth: int = 8, colour: int = 0) -> bytes:
    """The begin of a PNG that claims a size."""
    fields = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + struct.pack(">I", 13)
        + b"IHDR"
        + fields
        + struct.pack(">I", zlib.crc32(b"IHDR" + fields))
    )


def encoded(suffix: str, shape: tuple[int, ...]) -> bytes:
    pixels = np.frombuffer(BYTES, np.uint8)[: int(np.prod(shape))].reshape(shape)
    return bytes(cv2.imencode(suffix, pixels)[1].tobytes())


WHOLE = [encoded(s, shape) for s in (".png", ".jpg", ".bmp", ".webp") for shape in ((9, 7), (24, 32, 3), (5, 5, 4))]
CLAIMS = [
    png_header(2**31 - 1, 2**31 - 1) + b"\0\0\0\0IEND\0\0\0\0",
    png_header(60000, 60000) + b"\0\0\0\0IEND\0\0\0\0",
    b"\xff\xd8\xff\xc0" + struct.pack(">HBHHB", 17, 8, 65535, 65535, 3) + bytes(9) + b"\xff\xd9",
    b"BM" + bytes(16) + struct.pack("<ii", 2**31 - 1, -(2**31)) + bytes(30),
]


@st.composite
def compressed_images(draw: st.DrawFn) -> CompressedImage:
    """Whole, cut off, damaged, of other formats, or nothing of the kind."""
    data = bytearray(draw(st.one_of(st.sampled_from(WHOLE), st.sampled_from(CLAIMS), st.binary(max_size=64))))
    for place, value in draw(st.lists(st.tuples(st.integers(0, 4000), st.integers(0, 255)), max_size=4)):
        if data:
            data[place % len(data)] = value
    if draw(st.booleans()):
        data = data[: draw(st.integers(0, len(data)))]
    kind = draw(st.one_of(st.sampled_from(["png", "jpeg", "bgr8; jpeg compressed bgr8", "compressedDepth"]), texts))
    return CompressedImage(header=draw(headers()), format=kind, data=array.array("B", bytes(data)))


@st.composite
def camera_infos(draw: st.DrawFn) -> CameraInfo:
    """Calibrations from right to NaN."""
    good = draw(st.booleans())
    msg = CameraInfo(header=draw(headers()), width=toy.SIZE[0] if good else draw(lengths), height=toy.SIZE[1])
    msg.k = toy.CAMERA.matrix.reshape(9).copy() if good else np.array(draw(st.lists(any_float, min_size=9, max_size=9)))
    msg.p = np.array(draw(st.lists(any_float, min_size=12, max_size=12)))
    msg.distortion_model = draw(st.sampled_from(["", "plumb_bob", "rational_polynomial", "equidistant", "?"]))
    msg.d = array.array("d", draw(st.one_of(st.just([]), st.just([0.0] * 5), st.lists(any_float, max_size=14))))
    msg.binning_x, msg.binning_y = draw(counts), draw(counts)
    if draw(st.booleans()):
        msg.roi = RegionOfInterest(
            x_offset=draw(counts), y_offset=draw(counts), width=draw(lengths), height=draw(lengths)
        )
    return msg


def any_message() -> st.SearchStrategy[Any]:
    return st.one_of(images(), images(), compressed_images(), camera_infos())
