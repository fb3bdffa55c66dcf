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
    if numba is None:
        return function
    try:
        return numba.njit(cache=True, nogil=True, fastmath=_MATH, error_model="numpy")(function)
    except RuntimeError:  # no folder for the cache: compiled anew in each process
        return numba.njit(nogil=True, fastmath=_MATH, error_model="numpy")(function)
