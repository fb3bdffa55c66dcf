"""How long each stage of the method takes."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager


class Stopwatch:
    """Milliseconds per named stage."""

    def __init__(self) -> None:
        self._start = time.perf_counter()
        self.ms = dict.fromkeys(("segmentation", "blobs", "alignment", "grouping", "pose", "total"), 0.0)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add what is done meanwhile to a stage."""
        start = time.perf_counter()
        yield
        self.ms[name] += 1e3 * (time.perf_counter() - start)

    def stop(self) -> dict[str, float]:
        """Milliseconds of each stage, and in all since the beginning."""
        self.ms["total"] = 1e3 * (time.perf_counter() - self._start)
        return self.ms
