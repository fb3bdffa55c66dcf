"""How much of what is in doubt is looked into while newer images wait."""

from __future__ import annotations

import time
from collections.abc import Callable
from math import inf
from typing import TypeVar

_Result = TypeVar("_Result")


class Patience:
    """Of whoever follows a camera. While a newer image waits, long looks take a share of the time that passes at most:
    what they might find comes a moment later, and what is known is told in time.

    :param is_late: whether a newer image waits, or soon will; None: none ever does, as where recorded images are read.
    """

    def __init__(self, is_late: Callable[[], bool] | None = None) -> None:
        self._is_late, self._rests_until_s = is_late, -inf

    @property
    def is_late(self) -> bool:
        """Whether a newer image waits, or soon will."""
        return self._is_late is not None and self._is_late()

    @property
    def is_over(self) -> bool:
        """Whether the next long look is put off."""
        return time.monotonic() < self._rests_until_s and self.is_late

    def spent_on(self, look: Callable[[], _Result], share: float) -> _Result:
        """What comes of a long look. :param share: of the time it is to have taken when the next one's turn comes."""
        began_s = time.monotonic()
        found = look()
        ended_s = time.monotonic()
        rests_until_s = ended_s + (ended_s - began_s) * (1 / share - 1)
        self._rests_until_s = max(self._rests_until_s, rests_until_s)
        return found
