"""The compiler, where there is one."""

from __future__ import annotations

from typing import Any

try:
    import numba
except ImportError:  # the numpy twins do the work
    numba = None

COMPILED = numba is not None
_MATH = {"contract", "reassoc", "arcp", "nsz"}  # sums may be reordered; NaN keeps its meaning


def jit(function: Any) -> Any:
    """Compile a function, and keep the result on disk where a folder for it can be written."""
    return _compiled(function)


def inlined(function: Any) -> Any:
    """The same for a small function that is called in inner loops: a call that hands over a dozen arrays costs more
    than what it does."""
    return _compiled(function, forceinline=True)


def _compiled(function: Any, **options: bool) -> Any:
    if numba is None:
        return function
    try:
        return numba.njit(cache=True, nogil=True, fastmath=_MATH, error_model="numpy", **options)(function)
    except RuntimeError:  # no folder for the cache: compiled anew in each process
        return numba.njit(nogil=True, fastmath=_MATH, error_model="numpy", **options)(function)
