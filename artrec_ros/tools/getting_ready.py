"""Compiled code is made before work begins, and the user sees it."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

from tqdm import tqdm

from ..core.base import kernel_cache
from ..core.base.jit import kernels, share_compiled
from ..core.warm_up import Told, compiling, get_ready, parts_needed
from ..io.base.bars import say
from ..io.parameters.parameter_file import Setup

_LINE_S = 10.0
_BAR = "getting ready: {percentage:3.0f}% |{bar}| {elapsed}"


def get_setup_ready(setup: Setup, calibrated: Collection[bool]) -> None:
    """Have the code that a set-up needs. :param calibrated: whether its sources are."""
    parts = {p for c in calibrated for p in parts_needed(setup.targets, setup.recognizer, calibrated=c)}
    with progress() as told:
        get_ready(parts, told)


def tell_of_compiling(kernel: Any) -> None:
    """Say so where a compiled function of `core` that is about to be called has to be made first."""
    if any(k is kernel for k in kernels(kernel.__module__.split("."))) and share_compiled([kernel]) < 1:
        say(f"getting ready: {compiling()}")


@contextmanager
def progress() -> Iterator[Told]:
    """What tells how far the compiler is: a bar on a terminal, else a line now and then; nothing where all is there.

    And why the next start will compile again, as soon as that is known.
    """
    bar: list[Any] = []
    said_s = [-math.inf]
    warned: list[str] = []

    def warn(problem: str) -> None:
        if problem and not warned:
            warned.append(problem)
            say(f"warning: {problem}")

    def told(share: float) -> None:
        warn(kernel_cache.problem())
        if sys.stderr.isatty():
            if not bar:
                bar.append(tqdm(total=1.0, bar_format=_BAR, leave=False))
            bar[0].update(share - bar[0].n)
        elif time.monotonic() - said_s[0] >= _LINE_S:
            said_s[0] = time.monotonic()
            say(f"getting ready, {share:.0%}: {compiling()}")

    warn(kernel_cache.switched_off())
    try:
        yield told
    finally:
        for one in bar:
            one.close()
    if bar or said_s[0] > 0:
        warn(kernel_cache.problem())
