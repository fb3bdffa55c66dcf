"""Threads that share the work of one frame. Compiled code holds no lock; results do not depend on their number."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice
from typing import Generic, TypeVar

from .jit import cores

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


class Crew:
    """The caller and some others. :param threads: the caller included; 0: one for each core."""

    def __init__(self, threads: int = 1) -> None:
        self._others = (threads or cores()) - 1
        self._pool = ThreadPoolExecutor(self._others, "artrec") if self._others else None

    def each(self, work: Callable[[_Item], _Result], items: Iterable[_Item]) -> list[_Result]:
        """What comes of every item, in their order."""
        items = list(items)
        ahead = Ahead(self, work, items)
        return [ahead.take(n) for n in range(len(items))]

    def begin(self, work: Callable[[_Item], _Result], item: _Item) -> Future[_Result] | None:
        """Have somebody else do it; None: there is nobody."""
        return self._pool.submit(work, item) if self._pool else None

    def __len__(self) -> int:
        return 1 + self._others


class Ahead(Generic[_Item, _Result]):
    """Work on items that are taken in their order: while the caller is at one, others are at the next ones.

    Items may be left out; what was begun of them was in vain.
    """

    def __init__(
        self,
        crew: Crew,
        work: Callable[[_Item], _Result],
        items: Sequence[_Item],
        wanted: Callable[[_Item], bool] = lambda item: True,
        stop: Callable[[], None] = lambda: None,
    ) -> None:
        """:param wanted: whether an item will be taken, as far as the caller knows; asked by its own thread.
        :param stop: have work end that was begun in vain.
        """
        self._crew, self._work, self._items, self._wanted, self._stop = crew, work, items, wanted, stop
        self._begun: dict[int, Future[_Result]] = {}

    def take(self, number: int) -> _Result:
        """What comes of an item."""
        future = self._begun.pop(number, None)
        if future is not None and not future.cancel():
            return future.result()
        ahead = (n for n in range(number + 1, len(self._items)) if n in self._begun or self._wanted(self._items[n]))
        for n in islice(ahead, len(self._crew) - 1):
            if n not in self._begun and (future := self._crew.begin(self._work, self._items[n])) is not None:
                self._begun[n] = future
        return self._work(self._items[number])

    def close(self) -> None:
        """Nothing more is taken."""
        self._stop()
        for future in self._begun.values():
            future.cancel()
