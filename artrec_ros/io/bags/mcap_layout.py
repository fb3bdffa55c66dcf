"""Whether an mcap file's indices fit what lies in it: chunks that were moved, doubled or lost are read wrongly, or not
at all, through an index that knows nothing of it. Only the heads of records are read, never their contents.

Format: https://mcap.dev/spec.
"""

from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from .recovery import MCAP_MAGIC

_MESSAGE, _CHUNK, _CHUNK_INDEX, _STATISTICS, _DATA_END, _FOOTER = b"\x05", b"\x06", b"\x08", b"\x0b", b"\x0f", b"\x02"
_HEAD = 9  # bytes of a record's opcode and length
_CHUNK_HEAD = struct.Struct("<QQQI")  # first and last time, size unpacked, checksum
_CHUNK_INDEX_HEAD = struct.Struct("<QQQQ")  # first and last time, offset, length
_FOOTER_CONTENT = struct.Struct("<QQI")  # summary's offset, summary offsets' offset, checksum

Times = tuple[int, int]


@dataclass
class _Layout:
    """Chunks as they lie there, and as the index has them: (offset, length of the record) -> first and last time."""

    chunks: dict[tuple[int, int], Times] = field(default_factory=dict)
    indexed: dict[tuple[int, int], Times] = field(default_factory=dict)
    chunk_count: int | None = None  # of the statistics
    loose_messages: int = 0
    checksum_fits: bool = True


def mcap_problem(path: Path) -> str | None:
    """Why the index cannot be trusted; None: it fits what lies in the file, or there is none.

    :raises OSError, struct.error: the file ends early, as one does whose recorder crashed.
    """
    with path.open("rb") as stream:
        layout = _walk(stream, os.fstat(stream.fileno()).st_size)
    if isinstance(layout, str):
        return layout
    if not layout.checksum_fits:
        return "its summary's checksum is wrong"
    if not layout.indexed and layout.chunk_count is None:
        return None  # a file without summary is read front to back
    if layout.chunks != layout.indexed:
        return f"its index does not fit its {len(layout.chunks)} chunks: some were moved, added or lost"
    if layout.chunk_count is not None and layout.chunk_count != len(layout.chunks):
        return f"its statistics tell of {layout.chunk_count} chunks, {len(layout.chunks)} are there"
    if layout.chunks and layout.loose_messages:
        return f"{layout.loose_messages} of its messages stand in no chunk: its index does not know of them"
    return None


def _walk(stream: BinaryIO, size: int) -> _Layout | str:
    """From record to record up to the footer."""
    layout, place, in_data = _Layout(), len(MCAP_MAGIC), True
    while True:
        stream.seek(place)
        opcode, length = struct.unpack("<cQ", stream.read(_HEAD))
        if length > size - place - _HEAD:
            return "a record's length reaches beyond the file's end"
        if opcode == _FOOTER:
            return layout if _ends_here(stream, layout, place, length, size) else "it does not end behind its footer"
        if opcode == _CHUNK:
            if length < _CHUNK_HEAD.size or not in_data:
                return "a chunk is damaged, or stands where none may"
            layout.chunks[place, _HEAD + length] = _CHUNK_HEAD.unpack(stream.read(_CHUNK_HEAD.size))[:2]
        elif opcode == _CHUNK_INDEX:
            first, last, offset, whole = _CHUNK_INDEX_HEAD.unpack(stream.read(_CHUNK_INDEX_HEAD.size))
            layout.indexed[offset, whole] = first, last
        elif opcode == _STATISTICS:
            (layout.chunk_count,) = struct.unpack("<22xI", stream.read(26))
        layout.loose_messages += opcode == _MESSAGE
        in_data = in_data and opcode != _DATA_END
        place += _HEAD + length


def _ends_here(stream: BinaryIO, layout: _Layout, place: int, length: int, size: int) -> bool:
    """At the footer: whether the file ends behind it; reads the checksum, which covers all from the summary to it."""
    if length != _FOOTER_CONTENT.size or place + _HEAD + length + len(MCAP_MAGIC) != size:
        return False
    start, _, checksum = _FOOTER_CONTENT.unpack(stream.read(length))
    if start and checksum and start <= place:
        stream.seek(start)
        covered = stream.read(place + _HEAD + length - 4 - start)
        layout.checksum_fits = zlib.crc32(covered) == checksum
    return stream.seek(-len(MCAP_MAGIC), os.SEEK_END) > 0 and stream.read() == MCAP_MAGIC
