"""stderr for our own lines alone: image and video libraries write there from C, whatever the caller makes of it."""

from __future__ import annotations

import io
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_STDOUT, _STDERR = 1, 2


class _Lenient(io.FileIO):
    """What cannot be written is lost, as on a full disk or where the reader has left: work goes on without."""

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data) or len(data)  # None: a full pipe that does not wait
        except OSError:
            return len(data)


def open_streams() -> None:
    """stdout and stderr that were closed lead nowhere: files that are opened must not take their numbers. What stderr
    cannot take is lost."""
    for name, number in (("stdout", _STDOUT), ("stderr", _STDERR)):
        if getattr(sys, name) is None:  # Python's word for it
            nowhere = os.open(os.devnull, os.O_WRONLY)
            if nowhere != number and not _is_open(number):
                os.dup2(nowhere, number)
            setattr(sys, name, os.fdopen(nowhere, "w", closefd=False))
    sys.stderr = _lenient(sys.stderr.fileno(), sys.stderr.encoding, closefd=False)


def flush_stdout() -> str:
    """At the end, why what was printed cannot be written; empty: it is, or the reader has left, as `| head` does."""
    try:
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # where Python's own try at it goes
        return "" if isinstance(error, BrokenPipeError) else f"stdout: cannot be written: {error.strerror}"
    return ""


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True


def _lenient(number: int, encoding: str, *, closefd: bool = True) -> io.TextIOWrapper:
    buffer = io.BufferedWriter(_Lenient(number, "w", closefd=closefd))
    return io.TextIOWrapper(buffer, encoding, errors="backslashreplace", line_buffering=True)


@contextmanager
def own_lines_only() -> Iterator[None]:
    """While it holds, `sys.stderr` is the user's as before, but the process' stderr goes nowhere; so do warnings.

    libpng, libjpeg, OpenCV and FFmpeg tell of damaged images there; our errors tell of them in their own words.
    """
    kept = os.dup(_STDERR)
    before = sys.stderr
    before.flush()
    sys.stderr = _lenient(kept, before.encoding)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, _STDERR)
    os.close(nowhere)
    try:
        with warnings.catch_warnings():
            if not sys.warnoptions:  # else somebody asked for them
                warnings.simplefilter("ignore")
            yield
    finally:
        sys.stderr.flush()
        os.dup2(kept, _STDERR)
        sys.stderr.close()
        sys.stderr = before
