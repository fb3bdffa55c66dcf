"""The compiler."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numba

from .kernel_cache import KernelCache

LANES = 8  # numbers in a vector instruction
_MATH = {"contract", "reassoc", "arcp", "nsz"}  # sums may be reordered; NaN keeps its meaning
_OPTIONS = {"nogil": True, "fastmath": _MATH, "error_model": "numpy", "no_cfunc_wrapper": True}  # nobody calls from C
_compiled: list[Any] = []


def jit(function: Any, **options: Any) -> Any:
    """Compile a function when it is first called, and keep the result on disk: `kernel_cache`."""
    kernel = numba.njit(**_OPTIONS, **options)(function)
    if kernel is not function:  # else the compiler is off
        kernel._cache = KernelCache(function)
        _compiled.append(kernel)
    return kernel


def lean(function: Any, **options: Any) -> Any:
    """Compile a function that makes no array, nor calls one that does: without the counting of references, which takes
    longer than the work where views of arrays are cut out and handed on at every point."""
    try:
        return jit(function, _nrt=False, **options)
    except (KeyError, TypeError):  # a numba that has no such option
        return jit(function, **options)


def melted(function: Any) -> Any:
    """`lean`, and the optimiser puts the code into each of its callers: a call copies every number of the arrays that
    it hands on, some 500 for a surface, a camera and room to work in, which took a third of the time of counting votes.
    """
    return lean(function, forceinline=True)


def inlined(function: Any) -> Any:
    """What returns parts of arrays, put into each of its callers before these are compiled: `melted` it would return
    them uncounted. That takes the compiler a hundred times as long."""
    return numba.njit(inline="always", **_OPTIONS)(function)


def cores() -> int:
    """How many compiled code may use: all that this process may run on, or what NUMBA_NUM_THREADS says."""
    return int(numba.config.NUMBA_NUM_THREADS)


def kernels(rooms: Iterable[str]) -> list[Any]:
    """The compiled functions of some rooms of `core`, of those modules that are imported."""
    wanted = set(rooms)
    return [k for k in _compiled if wanted & set(k.py_func.__module__.split(".")[:-1])]


def share_compiled(some: Iterable[Any]) -> float:
    """How many of these functions are compiled, by this process or one that kept the result; 0 to 1."""
    done = [bool(k.signatures) or k._cache.has_results for k in some]
    return sum(done) / max(len(done), 1)
