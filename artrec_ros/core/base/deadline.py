"""A frame's time budget, asked between batches so that a search ends with what it has."""

from __future__ import annotations

import time
from collections.abc import Iterator


class Deadline:
    """Monotonic deadline. `hit` tells whether it, or a part of it, stopped anybody whose work was wanted."""

    def __init__(self, budget_s: float = float("inf"), parent: Deadline | None = None) -> None:
        self._end_s = time.perf_counter() + budget_s
        self._parent = parent
        self._given_up = False
        self.hit = False

    @property
    def expired(self) -> bool:
        """Whether the time is over; once true it stays so."""
        if self._given_up:
            return True
        if time.perf_counter() < self._end_s:
            return False
        self._note()
        return True

    def give_up(self) -> None:
        """The time is over for what nobody wants any longer: nothing is missing that it stops. Parts that were made
        of it before go on."""
        self._given_up = True

    def part(self, share: float) -> Deadline:
        """A deadline after a share of the time that is left, so that later stages get theirs."""
        return Deadline(max(0.0, self._end_s - time.perf_counter()) * share, self)

    def parts(self, n: int, most: int) -> Iterator[slice]:
        """Slices of `n` things, at most so many at once, until the time is over."""
        for first in range(0, n, most):
            if self.expired:
                return
            yield slice(first, min(first + most, n))

    def _note(self) -> None:
        self.hit = True
        if self._parent is not None:
            self._parent._note()
