"""The newest item first: a thread that works, and a place for one item in front of it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

Item = TypeVar("Item")

_PATIENCE_S = 2.0


class NewestFirst(Generic[Item]):
    """Calls `work(item)` in a thread of its own, for the newest item whenever it is free.

    An item that is not begun when the next one comes is dropped: nothing queues. `dropped` counts them.
    """

    def __init__(self, work: Callable[[Item], None], name: str) -> None:
        self._work = work
        self._waiting: Item | None = None
        self._open = True
        self._dropped = 0
        self._begun_s: float | None = None
        self._change = threading.Condition()
        # a daemon: a search that is under way must not hold up the end of the process
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        return self._dropped

    @property
    def busy_s(self) -> float:
        """Since when it works on one item; 0: on none."""
        begun_s = self._begun_s
        return 0.0 if begun_s is None else time.monotonic() - begun_s

    def offer(self, item: Item) -> None:
        """Take an item; it replaces one that still waits. Returns at once."""
        with self._change:
            if not self._open:
                return
            self._dropped += self._waiting is not None
            self._waiting = item
            self._change.notify()

    def close(self) -> None:
        """Forget what waits and end the thread; what is under way may end by itself."""
        with self._change:
            self._open, self._waiting = False, None
            self._change.notify()
        self._thread.join(_PATIENCE_S)

    def _run(self) -> None:
        while (item := self._take()) is not None:
            self._begun_s = time.monotonic()
            self._work(item)
            self._begun_s = None

    def _take(self) -> Item | None:
        """The next item; None at the end."""
        with self._change:
            self._change.wait_for(lambda: self._waiting is not None or not self._open)
            item, self._waiting = self._waiting, None
            return item
