"""How long each stage of the method takes."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager


class Stopwatch:
    """Milliseconds per named stage. :param before: those that went by earlier."""

    def __init__(self, before: Mapping[str, float] | None = None) -> None:
        self._start = time.perf_counter()
        self.ms = dict.fromkeys(("segmentation", "blobs", "alignment", "grouping", "pose", "total"), 0.0)
        self.ms.update(before or {})

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add what is done meanwhile to a stage."""
        start = time.perf_counter()
        yield
        self.ms[name] += 1e3 * (time.perf_counter() - start)

    def stop(self) -> dict[str, float]:
        """Milliseconds of each stage, and in all since the beginning, with those before."""
        self.ms["total"] += 1e3 * (time.perf_counter() - self._start)
        return self.ms
