"""Signals that end long work softly."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..io.base.bars import say


@contextmanager
def interruptible(stop: Callable[[], None]) -> Iterator[list[int]]:
    """SIGINT and SIGTERM call `stop`, and are in the list that this gives; a second one ends at once."""
    signals: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)

    def on_signal(number: int, _: object) -> None:
        signals.append(number)
        for other in numbers:
            signal.signal(other, signal.default_int_handler)
        say("finishing the frames at hand; once more ends at once")
        stop()

    previous = {number: signal.signal(number, on_signal) for number in numbers}
    try:
        yield signals
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
