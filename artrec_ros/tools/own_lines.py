"""stdout and stderr cost no work, whatever becomes of them. stderr is for our own lines alone: image and video
libraries write there from C."""

from __future__ import annotations

import errno
import io
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_STDOUT, _STDERR = 1, 2


class _Lenient(io.FileIO):
    """What cannot be written is lost, as on a full disk or where the reader has left: work goes on without.

    :ivar error: the first one of that.
    """

    error: OSError | None = None

    def write(self, data: Any, /) -> int:
        try:
            if written := super().write(data):
                return written
            raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))  # a full pipe that does not wait
        except OSError as error:
            self.error = self.error or error
            return len(data)


def open_streams() -> _Lenient:
    """stdout and stderr that were closed lead nowhere: files that are opened must not take their numbers. What they
    cannot take is lost, and what the terminal has no letters for is spelled out. Both are written line by line: in a
    pipe that both lead to, a full buffer of one would else break off amid a line, and the other's go on there. Returns
    the file of stdout."""
    for name, number in (("stdout", _STDOUT), ("stderr", _STDERR)):
        if getattr(sys, name) is None:  # Python's word for it
            nowhere = os.open(os.devnull, os.O_WRONLY)
            if nowhere != number and not _is_open(number):
                os.dup2(nowhere, number)
            setattr(sys, name, os.fdopen(nowhere, "w", closefd=False))
    file = _Lenient(sys.stdout.fileno(), "w", closefd=False)
    sys.stdout = _text(file, sys.stdout.encoding)
    sys.stderr = _text(_Lenient(sys.stderr.fileno(), "w", closefd=False), sys.stderr.encoding)
    return file


def flush_stdout(file: _Lenient) -> str:
    """At the end, why what was printed is lost; empty: it is not, or the reader has left, as `| head` does.

    :param file: what `open_streams` returned.
    """
    sys.stdout.flush()
    if file.error is None or isinstance(file.error, BrokenPipeError):
        return ""
    return f"stdout: cannot be written: {file.error.strerror}"


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True


def _text(file: _Lenient, encoding: str) -> io.TextIOWrapper:
    return io.TextIOWrapper(io.BufferedWriter(file), encoding, errors="backslashreplace", line_buffering=True)


@contextmanager
def own_lines_only() -> Iterator[None]:
    """While it holds, `sys.stderr` is the user's as before, but the process' stderr goes nowhere; so do warnings.

    libpng, libjpeg, OpenCV and FFmpeg tell of damaged images there; our errors tell of them in their own words.
    """
    kept = os.dup(_STDERR)
    before = sys.stderr
    before.flush()
    sys.stderr = _text(_Lenient(kept, "w"), before.encoding)
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
