"""Progress of long work: a bar on a terminal, elsewhere a line now and then."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from typing import Any

from tqdm import tqdm

FIRST_S, LINE_S = 2.0, 10.0
_LINE = "{desc}{n_fmt} of {total_fmt} {unit}s, {elapsed}"
_COLUMNS, _ROWS = 80, 24  # of a terminal that does not say


def bar(work: Iterable[Any] | None = None, desc: str = "", **options: Any) -> Any:
    """A `tqdm` on stderr, of work that is gone through or, with `total`, told of.

    Where nobody looks, in a log or a pipe, it says a line after `FIRST_S` seconds and then every `LINE_S`; nothing of
    what takes less.
    """
    if sys.stderr.isatty():
        width = os.get_terminal_size(sys.stderr.fileno()).columns  # 0 in some containers, where tqdm would show nothing
        size: dict[str, Any] = {} if width else {"ncols": _COLUMNS, "nrows": _ROWS}
        return tqdm(work, desc or None, **size, **options)
    spare = {**options, "leave": False, "delay": FIRST_S, "mininterval": LINE_S, "maxinterval": LINE_S}
    made = tqdm(work, desc and f"{desc}: ", file=_Lines(), bar_format=_LINE, ncols=_COLUMNS, **spare)
    made.last_print_t -= LINE_S - FIRST_S
    return made


def say(line: str) -> None:
    """A line for the user, beside a progress bar."""
    tqdm.write(line, file=sys.stderr)


class _Lines:
    """What a bar writes to: a line for each time that it would be drawn anew."""

    def write(self, text: str) -> None:
        if line := text.strip("\r\n "):
            print(line, file=sys.stderr)

    def flush(self) -> None:
        sys.stderr.flush()
