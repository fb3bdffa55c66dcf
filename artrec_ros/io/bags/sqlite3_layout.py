"""Whether a database of rosbag2 is whole."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

_WRONG_ROWS = """SELECT count(*) FROM messages
WHERE typeof(data) != 'blob' OR typeof(timestamp) != 'integer' OR timestamp < 0"""


def sqlite3_problem(path: Path) -> str | None:
    """What a database lacks, as a message ends; None: nothing."""
    if problem := cut_off(path):
        return problem
    with closing(sqlite3.connect(f"{path.absolute().as_uri()}?immutable=1", uri=True)) as database:
        (wrong,) = database.execute(_WRONG_ROWS).fetchone()
    return f"{wrong} of its rows are no messages" if wrong else None


def cut_off(path: Path) -> str | None:
    """Why a database is not whole; None: it has the size that it tells of.

    https://www.sqlite.org/fileformat2.html#the_database_header
    """
    with path.open("rb") as stream:
        head = stream.read(100)
    page = int.from_bytes(head[16:18], "big")
    pages = int.from_bytes(head[28:32], "big") if head[24:28] == head[92:96] else 0  # else by an old writer: unknown
    size, wanted = path.stat().st_size, pages * (2**16 if page == 1 else page)
    return f"it has {size} bytes of {wanted}: it was cut off or grown" if pages and size != wanted else None
