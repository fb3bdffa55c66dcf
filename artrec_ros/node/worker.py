"""A thread that works on live items, and a short queue in front of it."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from statistics import fmean, median
from typing import Generic, TypeVar

from ..core.base.stamps import starts_again

Item = TypeVar("Item")

_PATIENCE_S = 2.0
_REMEMBERED = 30  # items: a second of a camera
_KEEPS_UP = 0.9  # of the time between items: what waits is made up for within some of them, and doubt gives way


class Pace:
    """Whether work on items takes less time, on average, than usually passes between them; or none of them came before
    the one before it was answered: whoever waits for answers comes as fast as these, and none of his items is late.

    :ivar work_s, between_s: of the last items. :ivar too_soon: which of them came before that answer.
    """

    def __init__(self) -> None:
        self.work_s: deque[float] = deque(maxlen=_REMEMBERED)
        self.between_s: deque[float] = deque(maxlen=_REMEMBERED)
        self.too_soon: deque[bool] = deque(maxlen=_REMEMBERED)

    @property
    def keeps_up(self) -> bool | None:
        """None: it is not known yet."""
        if len(self.work_s) < _REMEMBERED or len(self.between_s) < _REMEMBERED:
            return None
        return fmean(self.work_s) < _KEEPS_UP * median(self.between_s) or not any(self.too_soon)


class _Waiting(Generic[Item]):
    """An item that waits, and what is made of it meanwhile."""

    def __init__(self, item: Item) -> None:
        self.item, self._is_taken, self._lock, self._ready = item, False, threading.Lock(), threading.Event()

    def begin(self) -> bool:
        """Whether it is the caller's to be prepared, or worked on: the first one's who asks."""
        with self._lock:
            first, self._is_taken = not self._is_taken, True
        return first

    def prepare(self, prepare: Callable[[Item], Item]) -> None:
        try:
            self.item = prepare(self.item)
        finally:
            self._ready.set()

    def take(self) -> Item:
        """The item, prepared if that was begun."""
        if not self.begin():
            self._ready.wait()
        return self.item


class LiveQueue(Generic[Item]):
    """Calls `work(item)` in a thread of its own, for one item after the other.

    While work keeps up with items, on average, a few may wait for one that takes long. Else all that waits when the
    next one comes is dropped, so that what it works on is as new as can be. `dropped` counts them.
    """

    def __init__(
        self,
        work: Callable[[Item], None],
        name: str,
        most_waiting: int = 1,
        prepare: Callable[[Item], Item] | None = None,
    ) -> None:
        """:param most_waiting: 1: the newest only. :param prepare: makes of an item one on which there is less work:
        called in another thread, of items that wait."""
        self._work, self._most_waiting = work, most_waiting
        self._waiting: deque[_Waiting[Item]] = deque()
        self._pace, self._offered_s, self._stamp_ns = Pace(), -1.0, 0
        self._open, self._is_answered = True, True
        self._dropped = 0
        self._begun_s: float | None = None
        self._change = threading.Condition()
        # a daemon: a search that is under way must not hold up the end of the process
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()
        if prepare is not None:
            threading.Thread(target=self._look_ahead, args=(prepare,), name=f"{name} ahead", daemon=True).start()

    @property
    def dropped(self) -> int:
        return self._dropped

    @property
    def is_late(self) -> bool:
        """Whether an item waits while another one is worked on, or work does not keep up with items."""
        return bool(self._waiting) or self._pace.keeps_up is False

    @property
    def busy_s(self) -> float:
        """Since when it works on one item; 0: on none."""
        begun_s = self._begun_s
        return 0.0 if begun_s is None else time.monotonic() - begun_s

    def answered(self) -> None:
        """What the item is about that is worked on is about to be told: no item that comes from now on waits for it."""
        self._is_answered = True

    def offer(self, item: Item, stamp_ns: int = 0) -> None:
        """Take an item; where there is no room it replaces the oldest that waits. Returns at once.

        :param stamp_ns: of the item; 0: it has none.
        """
        with self._change:
            if not self._open:
                return
            self._note(stamp_ns)
            room = self._most_waiting if self._pace.keeps_up else 1
            while len(self._waiting) >= room:
                self._waiting.popleft()
                self._dropped += 1
            self._waiting.append(_Waiting(item))
            self._change.notify_all()

    def _note(self, stamp_ns: int) -> None:
        """When an item comes. Of another source nothing is known yet, and its first item waits for no answer."""
        now_s, is_new = time.monotonic(), starts_again(self._stamp_ns, stamp_ns)
        if is_new:
            self._pace, self._offered_s = Pace(), -1.0
        if self._offered_s >= 0:
            self._pace.between_s.append(now_s - self._offered_s)
        self._pace.too_soon.append(not is_new and (bool(self._waiting) or not self._is_answered))
        self._offered_s, self._stamp_ns = now_s, stamp_ns

    def end(self) -> None:
        """Forget what waits, and take nothing more; what is under way may end by itself."""
        with self._change:
            self._open = False
            self._waiting.clear()
            self._change.notify_all()

    def close(self) -> None:
        """The same, and wait for the thread to end."""
        self.end()
        self._thread.join(_PATIENCE_S)

    def _run(self) -> None:
        while (waiting := self._take()) is not None:
            self._begun_s = begun_s = time.monotonic()
            item = waiting.take()
            if not self._open:  # it may have ended while that was waited for
                return
            self._work(item)
            self._begun_s, self._is_answered = None, True
            with self._change:
                self._pace.work_s.append(time.monotonic() - begun_s)

    def _look_ahead(self, prepare: Callable[[Item], Item]) -> None:
        """Prepare what waits while another item is worked on, the one whose turn is next."""
        while (waiting := self._next_to_prepare()) is not None:
            try:
                waiting.prepare(prepare)
            except Exception:  # it goes wrong again where it is worked on, and is told there
                continue

    def _next_to_prepare(self) -> _Waiting[Item] | None:
        """None at the end."""
        with self._change:
            while self._open:
                if self._begun_s is not None and (mine := next((w for w in self._waiting if w.begin()), None)):
                    return mine
                self._change.wait()
        return None

    def _take(self) -> _Waiting[Item] | None:
        """The next item; None at the end."""
        with self._change:
            self._change.wait_for(lambda: self._waiting or not self._open)
            self._is_answered = False
            return self._waiting.popleft() if self._waiting else None
