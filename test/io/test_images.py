"""Image messages and files: known pixels come back; whatever else comes in ends in one ImageError of one line."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from artrec_ros.core.base.errors import ImageError
from artrec_ros.io.images import decoding
from artrec_ros.io.images.decoding import (
    decode_compressed,
    decode_encoded,
    decode_file,
    decode_image,
    read_image,
    size_of_image,
)
from artrec_ros.io.images.headers import orientation_of

RNG = np.random.default_rng(3)
GREY = RNG.integers(0, 256, (5, 7), np.uint8)
BGR = RNG.integers(0, 256, (5, 7, 3), np.uint8)
DEEP = RNG.integers(0, 65536, (5, 7), np.uint16)
ENCODINGS = ["mono8", "8UC1", "mono16", "16UC1", "bgr8", "8UC3", "rgb8", "bgra8", "rgba8", "bayer_rggb8", ""]


@pytest.mark.parametrize("encoding", ["mono8", "8UC1"])
def test_one_channel_comes_back_as_it_is(encoding):
    assert np.array_equal(decode_image(encoding, 5, 7, 7, False, GREY.tobytes()), GREY)


@pytest.mark.parametrize("encoding", ["mono16", "16UC1"])
@pytest.mark.parametrize("big", [False, True])
def test_sixteen_bits_in_either_byte_order(encoding, big):
    data = DEEP.astype(">u2" if big else "<u2").tobytes()
    image = decode_image(encoding, 5, 7, 14, big, data)
    assert image.dtype == np.uint16 and image.dtype.isnative
    assert np.array_equal(image, DEEP)


@pytest.mark.parametrize(
    ("encoding", "pixels"),
    [
        ("bgr8", BGR),
        ("8UC3", BGR),
        ("rgb8", BGR[:, :, ::-1]),
        ("bgra8", np.dstack([BGR, GREY])),
        ("rgba8", np.dstack([BGR[:, :, ::-1], GREY])),
    ],
)
def test_colours_come_back_as_bgr(encoding, pixels):
    step = pixels.shape[1] * pixels.shape[2]
    assert np.array_equal(decode_image(encoding, 5, 7, step, False, pixels.tobytes()), BGR)


@pytest.mark.parametrize(("encoding", "pixels"), [("mono8", GREY), ("rgb8", BGR[:, :, ::-1]), ("mono16", DEEP)])
@pytest.mark.parametrize("last_row_padded", [True, False])
def test_padding_at_the_rows_ends_is_skipped(encoding, pixels, last_row_padded):
    rows = pixels.view(np.uint8).reshape(5, -1) if pixels.dtype == np.uint16 else pixels.reshape(5, -1)
    padded = np.hstack([rows, np.full((5, 3), 255, np.uint8)])
    data = padded.tobytes() if last_row_padded else padded.tobytes()[:-3]
    image = decode_image(encoding, 5, 7, padded.shape[1], False, data)
    assert np.array_equal(image, BGR if pixels.ndim == 3 else pixels)


@pytest.mark.parametrize("pad", [1, 2, 3])
def test_rows_of_sixteen_bits_may_begin_at_any_byte(pad):
    numbers = np.arange(35, dtype="<u2").reshape(5, 7)
    rows = np.concatenate([numbers.view(np.uint8), np.zeros((5, pad), np.uint8)], axis=1)
    image = decode_image("mono16", 5, 7, 14 + pad, False, rows.tobytes())
    assert image.flags.aligned and np.array_equal(cv2.threshold(image, 99, 0, cv2.THRESH_TOZERO_INV)[1], numbers)


def test_more_bytes_than_needed_are_ignored():
    assert np.array_equal(decode_image("mono8", 5, 7, 7, False, GREY.tobytes() + b"more"), GREY)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("bayer_rggb8", 5, 7, 7, False, GREY.tobytes()), "'bayer_rggb8' is none of mono8"),
        (("32FC1", 5, 7, 28, False, bytes(140)), "'32FC1' is none of .*; convert the images, or choose another topic"),
        (("a\nb", 5, 7, 7, False, GREY.tobytes()), r"'a\\nb' is none of mono8"),
        (("m" * 300_000, 5, 7, 7, False, GREY.tobytes()), r"^encoding 'm{56}\.\.\. is none of mono8"),
        (("mono8", 0, 7, 7, False, b""), "7x0"),
        (("mono8", 5, 0, 0, False, b""), "0x5"),
        (("mono8", 5, 7, 6, False, GREY.tobytes()), "step 6"),
        (("bgr8", 5, 7, 20, False, BGR.tobytes()), "take 21 bytes"),
        (("mono8", 480, 640, 640, False, bytes(30)), "30 bytes of data"),
        (("mono8", 2**31, 2**31, 2**31, False, bytes(30)), "implausible"),
    ],
)
def test_unfit_messages_say_what_is_wrong(arguments, said):
    with pytest.raises(ImageError, match=said):
        decode_image(*arguments)


@settings(max_examples=300, deadline=None)
@given(
    st.sampled_from(ENCODINGS),
    st.integers(-2, 40) | st.integers(0, 2**32 - 1),
    st.integers(-2, 40) | st.integers(0, 2**32 - 1),
    st.integers(-2, 200) | st.integers(0, 2**32 - 1),
    st.booleans(),
    st.binary(max_size=400),
)
def test_any_message_gives_an_image_of_its_size_or_an_image_error(encoding, height, width, step, big, data):
    try:
        image = decode_image(encoding, height, width, step, big, data)
    except ImageError as error:
        assert "\n" not in str(error)
    else:
        assert image.shape[:2] == (height, width)


@pytest.mark.parametrize("image_format", ["png", "mono8; png compressed", "mono8; png compressed mono8"])
@pytest.mark.parametrize("pixels", [GREY, BGR, DEEP], ids=["grey", "colour", "sixteen bits"])
def test_png_comes_back_exactly(image_format, pixels):
    assert np.array_equal(decode_compressed(image_format, cv2.imencode(".png", pixels)[1]), pixels)


def test_jpeg_comes_back_nearly():
    smooth = cv2.resize(BGR, (70, 50))
    image = decode_compressed("bgr8; jpeg compressed bgr8", cv2.imencode(".jpg", smooth)[1].tobytes())
    assert image.shape == smooth.shape
    assert np.abs(image.astype(int) - smooth).mean() < 6


@pytest.mark.parametrize("quality", [101, 80])
@pytest.mark.parametrize("shape", [(50, 70, 3), (50, 70, 4), (1, 300, 3)])
def test_webp_comes_back(quality, shape):
    smooth = cv2.resize(np.dstack([BGR, GREY])[:, :, : shape[2]], shape[1::-1])
    image = decode_compressed("webp", cv2.imencode(".webp", smooth, [cv2.IMWRITE_WEBP_QUALITY, quality])[1])
    assert image.shape == (*shape[:2], 3)
    if quality > 100 and shape[2] == 3:
        assert np.array_equal(image, smooth)


def test_an_alpha_channel_is_dropped():
    assert np.array_equal(decode_encoded(cv2.imencode(".png", np.dstack([BGR, GREY]))[1]), BGR)


@pytest.mark.parametrize("bits", [1, 2, 4, 8])
def test_grey_of_few_bits_keeps_its_class_numbers(tmp_path, bits):
    row = np.arange(8) % 2**bits
    packed = np.packbits(((row[:, None] >> np.arange(bits - 1, -1, -1)) & 1).astype(np.uint8)).tobytes()
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 2, bits, 0, 0, 0, 0))
    rows = chunk(b"IDAT", zlib.compress(b"\0" + packed + b"\0" + packed))
    encoded = b"\x89PNG\r\n\x1a\n" + header + rows + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(encoded)
    for image in (read_image(tmp_path / "a.png"), decode_compressed("png", encoded)):
        assert image.dtype == np.uint8 and np.array_equal(image, [row, row])


def test_depth_images_are_refused():
    with pytest.raises(ImageError, match="depth"):
        decode_compressed("16UC1; compressedDepth png", cv2.imencode(".png", DEEP)[1])


def test_what_a_message_calls_its_unknown_content_is_told():
    with pytest.raises(ImageError, match=r"neither PNG, .*; the message's format is 'h264'$"):
        decode_compressed("h264", b"\0\0\0\1gd")
    with pytest.raises(ImageError) as caught:
        decode_compressed("\n" * 1000, b"")
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300


def test_sixteen_bit_colours_are_refused():
    with pytest.raises(ImageError, match="8 bits"):
        decode_encoded(cv2.imencode(".png", np.dstack([DEEP] * 3))[1])


@pytest.mark.parametrize("reads", [True, False])
def test_a_gif_is_read_or_refused_as_one_that_opencv_does_not_read(reads, monkeypatch):
    gif = decoding._SMALLEST_GIF
    if reads:
        if not decoding._reads_gif():
            pytest.skip("this OpenCV reads no GIF")
        assert decode_encoded(gif).shape == (1, 1, 3)
        with pytest.raises(ImageError, match="damaged image: 30 bytes for 1x1 pixels"):
            decode_encoded(gif[:30])
        return
    monkeypatch.setattr(cv2, "imdecode", lambda *_: None)
    decoding._reads_gif.cache_clear()
    with pytest.raises(ImageError, match=f"a GIF, which this OpenCV, {cv2.__version__}, does not read: PNG or JPEG"):
        decode_compressed("gif", gif)
    decoding._reads_gif.cache_clear()


CUT_OFF = """
from artrec_ros.io.images import decoding
from artrec_ros.core.base.errors import ImageError
decoding.silence_opencv()
try:
    decoding.decode_encoded(decoding._SMALLEST_GIF[:30])
except ImageError as error:
    print(error)
"""


def test_opencv_says_nothing_of_its_own_unless_it_is_asked_for(monkeypatch):
    for level, is_silent in (("", True), ("ERROR", False)):
        monkeypatch.setenv("OPENCV_LOG_LEVEL", level) if level else monkeypatch.delenv("OPENCV_LOG_LEVEL", False)
        done = subprocess.run([sys.executable, "-c", CUT_OFF], capture_output=True, text=True, timeout=60)
        assert done.returncode == 0 and "damaged image" in done.stdout or not decoding._reads_gif()
        assert not done.stderr if is_silent else done.stderr or not decoding._reads_gif()


def png_claiming(width: int, height: int) -> bytes:
    """A well-formed PNG whose header claims this size and whose data are a few bytes."""
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(100))) + chunk(b"IEND", b"")
    )


def test_an_implausible_size_is_refused_before_it_is_decoded():
    with pytest.raises(ImageError, match="60000x60000 pixels is implausible"):
        decode_encoded(png_claiming(60000, 60000))
    jpeg = bytearray(cv2.imencode(".jpg", BGR)[1].tobytes())
    size_at = jpeg.find(b"\xff\xc0") + 5
    jpeg[size_at : size_at + 4] = struct.pack(">HH", 65000, 65000)
    with pytest.raises(ImageError, match="65000x65000 pixels is implausible"):
        decode_encoded(bytes(jpeg))


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".webp", ".bmp"])
def test_every_truncation_is_refused(suffix):
    encoded = cv2.imencode(suffix, BGR)[1].tobytes()
    for length in range(len(encoded)):
        with pytest.raises(ImageError) as caught:
            decode_encoded(encoded[:length])
        assert "\n" not in str(caught.value)


def chunk(kind: bytes, data: bytes) -> bytes:
    """Of a PNG."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def turned(suffix: str, orientation: int, order: str = ">") -> bytes:
    """An image whose EXIF data say so."""
    encoded = cv2.imencode(suffix, cv2.resize(BGR, (70, 50)))[1].tobytes()
    exif = {">": b"MM\0*", "<": b"II*\0"}[order] + struct.pack(
        order + "IHHHIHHHHIHHI", 8, 2, 0x10F, 3, 1, 9, 0, 0x112, 3, 1, orientation, 0, 0
    )
    if suffix == ".webp":
        size = struct.pack("<BxxxI", 8, 69)[:7] + struct.pack("<I", 49)[:3]
        chunks = (
            b"WEBPVP8X" + struct.pack("<I", 10) + size + encoded[12:] + b"EXIF" + struct.pack("<I", len(exif)) + exif
        )
        return b"RIFF" + struct.pack("<I", len(chunks)) + chunks
    if suffix == ".png":
        return encoded[:33] + chunk(b"eXIf", exif) + encoded[33:]
    return encoded[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 8) + b"Exif\0\0" + exif + encoded[2:]


UPRIGHT = {
    1: lambda image: image,
    2: lambda image: cv2.flip(image, 1),
    3: lambda image: cv2.rotate(image, cv2.ROTATE_180),
    4: lambda image: cv2.flip(image, 0),
    5: cv2.transpose,
    6: lambda image: cv2.rotate(image, cv2.ROTATE_90_CLOCKWISE),
    7: lambda image: cv2.flip(cv2.transpose(image), -1),
    8: lambda image: cv2.rotate(image, cv2.ROTATE_90_COUNTERCLOCKWISE),
}


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".webp"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_files_are_upright_as_opencv_reads_them_and_messages_as_they_lie(tmp_path, suffix, orientation):
    for order in "<>":
        encoded = np.frombuffer(turned(suffix, orientation, order), np.uint8)
        (path := tmp_path / f"a{suffix}").write_bytes(encoded)
        lies = cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED)
        assert np.array_equal(decode_compressed(suffix[1:], encoded), lies)
        assert np.array_equal(read_image(path), UPRIGHT[orientation](lies))
        assert size_of_image(path) == read_image(path).shape[1::-1]
        if suffix == ".jpg":  # of others not every OpenCV reads them
            assert np.array_equal(read_image(path), cv2.imread(str(path)))


def test_damaged_exif_data_cost_no_image():
    whole = turned(".png", 6)
    at = whole.find(b"MM\0*")
    for place in range(at, at + 38):
        for value in (0, 255):
            damaged = whole[:place] + bytes([value]) + whole[place + 1 :]
            assert orientation_of(damaged) in range(1, 9)
    assert orientation_of(turned(".jpg", 99)) == orientation_of(b"") == orientation_of(b"\xff\xd8") == 1
    four = np.dstack([BGR, GREY])
    assert np.array_equal(decode_file(cv2.imencode(".png", four)[1].tobytes()), four)  # what is in no need of turning


@settings(max_examples=300, deadline=None)
@given(st.sampled_from([".png", ".jpg", ".webp", ".bmp"]), st.data())
def test_damaged_files_give_an_image_or_an_image_error(suffix, data):
    encoded = bytearray(cv2.imencode(suffix, BGR)[1].tobytes())
    for _ in range(data.draw(st.integers(1, 8))):
        encoded[data.draw(st.integers(0, len(encoded) - 1))] = data.draw(st.integers(0, 255))
    try:
        image = decode_encoded(bytes(encoded))
    except ImageError as error:
        assert "\n" not in str(error)
    else:
        assert image.ndim in (2, 3)


@settings(max_examples=200, deadline=None)
@given(
    st.sampled_from([b"", b"\x89PNG\r\n\x1a\n", b"\xff\xd8", b"\xff\xd8\xff", b"BM", b"RIFF\0\0\0\0WEBPVP8X"]),
    st.binary(max_size=60),
)
def test_noise_is_an_image_error(start, noise):
    with pytest.raises(ImageError):
        decode_encoded(start + noise)


def test_a_missing_file_is_an_image_error(tmp_path):
    with pytest.raises(ImageError, match="no such file"):
        read_image(tmp_path / "nothing.png")


def test_files_that_are_none_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe.png")
    (tmp_path / "endless.png").symlink_to("/dev/zero")
    (tmp_path / "pointer.png").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n")
    for name, said in (("pipe", "a pipe or device"), ("endless", "a pipe or device"), ("pointer", "git lfs pull")):
        with pytest.raises(ImageError, match=said):
            read_image(tmp_path / f"{name}.png")
