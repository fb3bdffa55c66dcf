"""Lines of JSON: their content, and what is wrong with one, in words."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...core.base.errors import ArtrecError, SourceError
from .yaml_files import size_of_file


def lines_of(path: Path) -> Iterator[str]:
    """The lines of a text file. :raises SourceError: it is none, or cannot be read."""
    size_of_file(path, SourceError)
    try:
        with path.open(encoding="utf-8-sig") as stream:  # some editors put a byte order mark before it
            yield from stream
    except UnicodeDecodeError:
        raise SourceError(f"{path}: is no text file (UTF-8)") from None
    except OSError as error:
        raise SourceError(f"{path}: cannot be read: {error.strerror}") from None


def parsed_line(line: str) -> Any:
    """A line's content. :raises ValueError: it is no JSON, as a user can be told."""
    try:
        return json.loads(line.rstrip("\r\n"))  # in a line that is cut off its end is no mistake
    except json.JSONDecodeError as error:
        raise ValueError(f"no valid JSON at column {error.colno}: {error.msg}") from None
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    except ValueError:  # Python reads no number of thousands of digits
        raise ValueError("a number in it is too long") from None


@contextmanager
def at_line(path: Path, number: int) -> Iterator[None]:
    """What is wrong in here is told as of that line. :raises SourceError: a ValueError came up."""
    try:
        yield
    except ArtrecError:
        raise
    except ValueError as error:
        raise SourceError(f"{path}: line {number}: {error}") from None
