"""The compiler, where there is one."""

from __future__ import annotations

from typing import Any

try:
    import numba
except ImportError:  # the numpy twins do the work
    numba = None

COMPILED = numba is not None
_MATH = {"contract", "reassoc", "arcp", "nsz"}  # sums may be reordered; NaN keeps its meaning
_OPTIONS = {"nogil": True, "fastmath": _MATH, "error_model": "numpy"}


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
