"""The compiler."""

from __future__ import annotations

import os
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import numba

LANES = 8  # numbers in a vector instruction
_MATH = {"contract", "reassoc", "arcp", "nsz"}  # sums may be reordered; NaN keeps its meaning
_OPTIONS = {"nogil": True, "fastmath": _MATH, "error_model": "numpy"}


def forget_stale(sources: Path) -> None:
    """Remove results kept beside sources of which any has changed: numba looks at a function's own file alone, not at
    those whose functions it was compiled with. Results in a folder elsewhere, as NUMBA_CACHE_DIR names one, stay."""
    folder, now = sources / "__pycache__", sha256()
    stamp, new = folder / "sources.sha256", folder / f"sources.{os.getpid()}"
    with suppress(OSError):  # results that nobody may write are not kept here either
        for source in sorted(sources.rglob("*_kernels.py")):
            now.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
        if stamp.is_file() and stamp.read_text(encoding="utf-8") == now.hexdigest():
            return
        for result in sources.rglob("__pycache__/*.nb[ic]"):
            result.unlink(missing_ok=True)  # another process may be at it
        folder.mkdir(exist_ok=True)
        new.write_text(now.hexdigest(), encoding="utf-8")
        new.replace(stamp)


forget_stale(Path(__file__).parents[1])


def jit(function: Any, **options: Any) -> Any:
    """Compile a function, and keep the result on disk where a folder for it can be written."""
    try:
        return numba.njit(cache=True, **_OPTIONS, **options)(function)
    except RuntimeError:  # no folder for the cache: compiled anew in each process
        return numba.njit(**_OPTIONS, **options)(function)


def lean(function: Any) -> Any:
    """Compile a function that makes no array, nor calls one that does: without the counting of references, which takes
    longer than the work where views of arrays are cut out and handed on at every point."""
    try:
        return jit(function, _nrt=False)
    except (KeyError, TypeError):  # a numba that has no such option
        return jit(function)


def inlined(function: Any) -> Any:
    """Compile a function into each of its callers: to hand over a surface's arrays would cost more than it does."""
    return numba.njit(inline="always", **_OPTIONS)(function)
