"""The compiler, where there is one."""

from __future__ import annotations

from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

try:
    import numba
except ImportError:  # the numpy twins do the work
    numba = None

COMPILED = numba is not None
LANES = 8  # numbers in a vector instruction
_MATH = {"contract", "reassoc", "arcp", "nsz"}  # sums may be reordered; NaN keeps its meaning
_OPTIONS = {"nogil": True, "fastmath": _MATH, "error_model": "numpy"}


def forget_stale(sources: Path) -> None:
    """Remove results kept beside sources of which any has changed: numba looks at a function's own file alone, not at
    those whose functions it was compiled with."""
    stamp, kept = sources / "__pycache__" / "sources.sha256", sources.glob("__pycache__/*.nb[ic]")
    digest = sha256(b"".join(p.read_bytes() for p in sorted(sources.glob("*.py")))).hexdigest()
    with suppress(OSError):  # nobody edits an installation that nobody may write to
        if stamp.is_file() and stamp.read_text(encoding="utf-8") == digest:
            return
        for result in kept:
            result.unlink()
        stamp.parent.mkdir(exist_ok=True)
        stamp.write_text(digest, encoding="utf-8")


if numba is not None:
    forget_stale(Path(__file__).parent)


def jit(function: Any, **options: Any) -> Any:
    """Compile a function, and keep the result on disk where a folder for it can be written."""
    if numba is None:
        return function
    try:
        return numba.njit(cache=True, **_OPTIONS, **options)(function)
    except RuntimeError:  # no folder for the cache: compiled anew in each process
        return numba.njit(**_OPTIONS, **options)(function)


def lean(function: Any) -> Any:
    """Compile a function that makes no array: without the counting of references, which takes longer than the work
    where views of arrays are cut out and handed on at every point."""
    return jit(function, _nrt=False)


def inlined(function: Any) -> Any:
    """Compile a function into each of its callers: to hand over a surface's arrays would cost more than it does."""
    return function if numba is None else numba.njit(inline="always", **_OPTIONS)(function)
