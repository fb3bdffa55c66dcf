"""The clock of a sequence of frames: their stamps."""

from __future__ import annotations

_NO_CLOCK_S = 1 / 30  # what a frame counts as where stamps stand still


def seconds_since(before_ns: int | None, now_ns: int) -> float:
    """From one frame to the next; where stamps stand still, and from none (None), what a frame takes at 30 Hz."""
    return _NO_CLOCK_S if before_ns is None else (now_ns - before_ns) * 1e-9 or _NO_CLOCK_S
