"""stderr for our own lines alone: image and video libraries write there from C, whatever the caller makes of it."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

_STDERR = 2


@contextmanager
def own_lines_only() -> Iterator[None]:
    """While it holds, `sys.stderr` is the user's as before, but the process' stderr goes nowhere; so do warnings.

    libpng, libjpeg, OpenCV and FFmpeg tell of damaged images there; our errors tell of them in their own words.
    """
    try:
        kept = os.dup(_STDERR)
    except OSError:  # it is closed: nobody hears anything
        yield
        return
    before = sys.stderr
    before.flush()
    sys.stderr = os.fdopen(kept, "w", buffering=1, encoding=before.encoding, errors="backslashreplace")
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
