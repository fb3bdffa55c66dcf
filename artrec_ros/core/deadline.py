"""A frame's time budget, asked between batches so that a search ends with what it has."""

from __future__ import annotations

import time


class Deadline:
    """Monotonic deadline. `expired` stays true once the time is over; `hit` tells whether anybody was stopped."""

    def __init__(self, budget_s: float) -> None:
        self._end_s = time.perf_counter() + budget_s
        self.hit = False

    @property
    def expired(self) -> bool:
        if time.perf_counter() >= self._end_s:
            self.hit = True
            return True
        return False
