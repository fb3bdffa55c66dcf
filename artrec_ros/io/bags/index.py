"""Whether a storage file's index can be trusted. Only heads are read, of a database those of its rows, never contents:
it costs next to nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .mcap_layout import mcap_problem
from .metadata import storage_suffix
from .sqlite3_layout import sqlite3_problem


def index_problem(path: Path, reader: Any) -> str | None:
    """Why the file has to be read front to back; None: its index fits it.

    :param reader: rosbags' reader of the file, open.
    :raises OSError, struct.error, sqlite3.Error: the file ends early, or is damaged.
    """
    if path.suffix == ".mcap":
        return mcap_problem(path)
    return _ros1_problem(reader) if storage_suffix(path) == ".bag" else sqlite3_problem(path)


def _ros1_problem(reader: Any) -> str | None:
    """Each chunk is told of in two places: beside it, and at the end of the file."""
    for connection in reader.connections:
        told = sum(chunk.connection_counts.get(connection.id, 0) for chunk in reader.chunk_infos)
        if told != connection.msgcount:
            return f"its index tells of {connection.msgcount} messages on '{connection.topic}', its chunks of {told}"
    return None
