"""A sequence that is worked out when it is first looked at."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Generic, TypeVar, overload

T = TypeVar("T")


class Deferred(Sequence[T], Generic[T]):
    """What `work` gives, in one tuple; equal to that tuple, and pickled as one.

    For what few ask for, such as the reasons of a frame's rejections. Until then all that `work` needs is kept.
    """

    def __init__(self, work: Callable[[], Iterable[T]]) -> None:
        self._work: Callable[[], Iterable[T]] | None = work
        self._rows: tuple[T, ...] = ()

    def _all(self) -> tuple[T, ...]:
        work = self._work
        if work is not None:
            self._rows = tuple(work())
            self._work = None
        return self._rows

    @overload
    def __getitem__(self, index: int) -> T: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[T, ...]: ...

    def __getitem__(self, index: int | slice) -> T | tuple[T, ...]:
        return self._all()[index]

    def __len__(self) -> int:
        return len(self._all())

    def __iter__(self) -> Iterator[T]:
        return iter(self._all())

    def __eq__(self, other: object) -> bool:
        return self._all() == (other._all() if isinstance(other, Deferred) else other)

    def __hash__(self) -> int:
        return hash(self._all())

    def __repr__(self) -> str:
        return repr(self._all())

    def __reduce__(self) -> tuple[Any, ...]:
        return tuple, (self._all(),)
