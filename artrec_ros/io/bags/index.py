"""Whether a storage file's index can be trusted. Only heads are read, never contents: it costs next to nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .mcap_layout import mcap_problem
from .metadata import storage_suffix


def index_problem(path: Path, reader: Any) -> str | None:
    """Why the file has to be read front to back; None: its index fits it.

    :param reader: rosbags' reader of the file, open.
    :raises OSError, struct.error: the file ends early.
    """
    if path.suffix == ".mcap":
        return mcap_problem(path)
    return _ros1_problem(reader) if storage_suffix(path) == ".bag" else _sqlite3_problem(path)


def _ros1_problem(reader: Any) -> str | None:
    """Each chunk is told of in two places: beside it, and at the end of the file."""
    for connection in reader.connections:
        told = sum(chunk.connection_counts.get(connection.id, 0) for chunk in reader.chunk_infos)
        if told != connection.msgcount:
            return f"its index tells of {connection.msgcount} messages on '{connection.topic}', its chunks of {told}"
    return None


def _sqlite3_problem(path: Path) -> str | None:
    """https://www.sqlite.org/fileformat2.html#the_database_header"""
    with path.open("rb") as stream:
        head = stream.read(100)
    page = int.from_bytes(head[16:18], "big")
    pages = int.from_bytes(head[28:32], "big") if head[24:28] == head[92:96] else 0  # else by an old writer: unknown
    size, wanted = path.stat().st_size, pages * (2**16 if page == 1 else page)
    return f"it has {size} bytes of {wanted}: it was cut off or grown" if pages and size != wanted else None
