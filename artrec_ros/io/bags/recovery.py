"""Reads damaged bags front to back, without their index: a recording that was cut off has none.

Formats: https://mcap.dev/spec, https://wiki.ros.org/Bags/Format/2.0, and rosbag2_storage_sqlite3's tables.
Each scan yields what can be read and then raises `SourceError` with the reason why it went no further.
"""

from __future__ import annotations

import bz2
import os
import sqlite3
import struct
import sys
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import lz4.frame  # type: ignore[import-untyped]

from ...core.base.errors import SourceError
from ..base.yaml_files import LFS_MAGIC, LFS_POINTER
from .sqlite3_layout import cut_off

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

MCAP_MAGIC = b"\x89MCAP0\r\n"
ROS1_MAGIC = b"#ROSBAG V2.0\n"
SQLITE_MAGIC = b"SQLite format 3\0"
_LARGE = 2**20  # bytes

_DECOMPRESSORS: dict[str, Callable[[], Any]] = {
    "zstd": zstd.ZstdDecompressor,
    "lz4": lz4.frame.LZ4FrameDecompressor,
    "bz2": bz2.BZ2Decompressor,
}


class RawMessage(NamedTuple):
    """A serialised message; `msgtype` is spelt as ROS 2 does (package/msg/Name), `log_ns` is when it was recorded."""

    topic: str
    msgtype: str
    log_ns: int
    data: bytes


def full_type(msgtype: str) -> str:
    """package/msg/Name: ROS 1, and ROS 2 until 2018, left out the middle."""
    package, slash, name = msgtype.partition("/")
    return f"{package}/msg/{name}" if slash and "/" not in name else msgtype


def scan(path: Path) -> Iterator[RawMessage]:
    """All messages that can be read, in file order.

    :raises SourceError: after the last of them, if the file ends early or is damaged; at once if it is no bag.
    """
    try:
        with path.open("rb") as stream:
            magic = stream.read(16)
            stream.seek(0)
            if magic.startswith(MCAP_MAGIC):
                stream.seek(len(MCAP_MAGIC))
                yield from _scan_mcap(stream, {}, {})
            elif magic.startswith(ROS1_MAGIC):
                stream.seek(len(ROS1_MAGIC))
                yield from _scan_ros1(stream, {})
            elif magic.startswith(SQLITE_MAGIC):
                yield from _scan_sqlite3(path)
            elif LFS_MAGIC.startswith(magic) and magic:
                raise SourceError(LFS_POINTER)
            else:
                raise SourceError("it starts like no bag (mcap, sqlite3, ROS 1)" if magic else "the file is empty")
    except OSError as error:
        raise SourceError(f"cannot be read: {error.strerror or error}") from error
    except (struct.error, UnicodeDecodeError, KeyError, ValueError) as error:
        raise SourceError(f"damaged: {error}") from error


def _read(stream: BinaryIO, size: int) -> bytes:
    data = _up_to(stream, size)
    if len(data) != size:
        raise SourceError("it ends in the middle of a record (truncated)")
    return data


def _up_to(stream: BinaryIO, size: int) -> bytes:
    """So many bytes, or what is left: a damaged length may claim more than any memory holds."""
    if size > _LARGE:
        here = stream.tell()
        size = min(size, stream.seek(0, os.SEEK_END) - here)
        stream.seek(here)
    return stream.read(size)


def _unpack(stream: BinaryIO, layout: str) -> tuple[Any, ...]:
    return struct.unpack(layout, _read(stream, struct.calcsize(layout)))


def _decompress(data: bytes, compression: str) -> bytes:
    """As much of a chunk as its bytes tell: a chunk that was cut off gives its first part."""
    if compression in ("", "none"):
        return data
    if compression not in _DECOMPRESSORS:
        raise SourceError(f"chunk compression '{compression}' is none of {', '.join(_DECOMPRESSORS)}")
    try:
        return bytes(_DECOMPRESSORS[compression]().decompress(data))
    except (zstd.ZstdError, RuntimeError, OSError, EOFError) as error:
        raise SourceError(f"a {compression} chunk is damaged: {error}") from error


def _mcap_string(stream: BinaryIO) -> str:
    return _read(stream, _unpack(stream, "<I")[0]).decode()


def _scan_mcap(stream: BinaryIO, schemas: dict[int, str], channels: dict[int, tuple[str, str]]) -> Iterator[RawMessage]:
    """Records after the magic, or within a chunk. :param schemas: names by id. :param channels: topic, type by id."""
    while opcode := stream.read(1):
        (size,) = _unpack(stream, "<Q")
        if opcode in b"\x02\x0f":  # footer, end of data: what follows are indices
            return
        if opcode == b"\x06":
            yield from _scan_mcap_chunk(stream, size, schemas, channels)
            continue
        record = BytesIO(_read(stream, size))
        if opcode == b"\x03":
            (schema_id,) = _unpack(record, "<H")
            schemas[schema_id] = full_type(_mcap_string(record))
        elif opcode == b"\x04":
            channel_id, schema_id = _unpack(record, "<HH")
            channels[channel_id] = (_mcap_string(record), schemas.get(schema_id, ""))
        elif opcode == b"\x05":
            channel_id, _, log_ns, _ = _unpack(record, "<HIQQ")
            yield RawMessage(*channels[channel_id], log_ns, record.read())


def _scan_mcap_chunk(
    stream: BinaryIO, size: int, schemas: dict[int, str], channels: dict[int, tuple[str, str]]
) -> Iterator[RawMessage]:
    record = _up_to(stream, size)
    head = BytesIO(record)
    _unpack(head, "<QQQI")
    compression = _mcap_string(head)
    (packed_size,) = _unpack(head, "<Q")
    yield from _scan_mcap(BytesIO(_decompress(_up_to(head, packed_size), compression)), schemas, channels)
    if len(record) != size:
        raise SourceError("it ends in the middle of a chunk (truncated)")


def _ros1_header(data: bytes) -> dict[str, bytes]:
    fields, position = {}, 0
    while position < len(data):
        (size,) = struct.unpack_from("<I", data, position)
        name, _, value = data[position + 4 : position + 4 + size].partition(b"=")
        fields[name.decode()] = value
        position += 4 + size
    return fields


def _scan_ros1(stream: BinaryIO, connections: dict[bytes, tuple[str, str]]) -> Iterator[RawMessage]:
    """Records after the magic, or within a chunk. :param connections: topic, type by connection number."""
    while head := stream.read(4):
        header = _ros1_header(_read(stream, struct.unpack("<I", head)[0]))
        (size,) = _unpack(stream, "<I")
        opcode = header["op"]
        if opcode == b"\x05":
            data = _up_to(stream, size)
            inner = BytesIO(_decompress(data, header["compression"].decode()))
            yield from _scan_ros1(inner, connections)
            if len(data) != size:
                raise SourceError("it ends in the middle of a chunk (truncated)")
            continue
        data = _read(stream, size)
        if opcode == b"\x07":
            connections[header["conn"]] = (header["topic"].decode(), full_type(_ros1_header(data)["type"].decode()))
        elif opcode == b"\x02":
            seconds, nanoseconds = struct.unpack("<II", header["time"])
            yield RawMessage(*connections[header["conn"]], seconds * 10**9 + nanoseconds, data)


def _scan_sqlite3(path: Path) -> Iterator[RawMessage]:
    # writable_schema lets SQLite open a file that is shorter than its header says
    connection = sqlite3.connect(f"{path.absolute().as_uri()}?immutable=1", uri=True)
    try:
        connection.execute("PRAGMA writable_schema=ON")
        named = connection.execute("SELECT id, name, type FROM topics")
        topics = {i: (name, full_type(t)) for i, name, t in named if isinstance(name, str) and isinstance(t, str)}
        skipped = 0
        for topic, log_ns, data in connection.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id"):
            if topic in topics and isinstance(log_ns, int) and log_ns >= 0 and isinstance(data, bytes):
                yield RawMessage(*topics[topic], log_ns, data)
            elif cut_off(path):
                raise SourceError("damaged database: one of its rows is no message")  # nor are those behind it to trust
            else:
                skipped += 1
        if skipped:
            raise SourceError(f"damaged database: {skipped} of its rows {'is' if skipped == 1 else 'are'} no message")
    except sqlite3.Error as error:
        raise SourceError(f"damaged database: {error}") from error
    finally:
        connection.close()
