"""The clock of a sequence of frames: their stamps."""

from __future__ import annotations

_NO_CLOCK_S = 1 / 30  # what a frame counts as where stamps stand still
_BACK_NS = 10**9  # stamps that go back by more are of another source, as of a bag that starts; by less, out of order


def seconds_since(before_ns: int | None, now_ns: int) -> float:
    """From one frame to the next; where stamps stand still, and from none (None), what a frame takes at 30 Hz."""
    return _NO_CLOCK_S if before_ns is None else (now_ns - before_ns) * 1e-9 or _NO_CLOCK_S


def starts_again(before_ns: int, now_ns: int) -> bool:
    """Whether stamps have gone back by so much that what comes is of another source; 0: there is no stamp."""
    return 0 < now_ns < before_ns - _BACK_NS
