"""Where compiled code is kept: folders of their own for all that it depends on."""

from __future__ import annotations

import fcntl
import os
import platform
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm
import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, _CacheLocator

_CORE = Path(__file__).parents[1]
_FORGOTTEN_S = 14 * 86400.0  # other versions' results are removed when nothing was compiled into them for so long
_LOOK_S = 0.2  # how often one looks whether another process is done
_ROOM_MB = 50  # for all results, and some to spare
_problem = ""


@cache
def version() -> str:
    """Of the kernels' sources, the compilers and the processor: numba alone would look at a function's own file, not
    at those whose functions it was compiled with."""
    about = sha256()
    for source in (*sorted(_CORE.rglob("*_kernels.py")), Path(__file__).with_name("jit.py")):
        about.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
    processor = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    about.update(repr((platform.python_version(), numba.__version__, llvmlite.__version__, processor)).encode())
    return about.hexdigest()[:16]


@cache
def folders() -> tuple[Path, ...]:
    """Where results are looked for: NUMBA_CACHE_DIR alone where it is set, else the package and the user's cache."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    user = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "artrec_ros"
    parents = (Path(given),) if given else (_CORE / "__pycache__", user)
    return tuple(parent.absolute() / f"kernels-{version()}" for parent in parents)


@cache
def writable() -> Path | None:
    """The first of the folders in which results can be written; it is made."""
    for folder in folders():
        with suppress(OSError):
            if not folder.is_dir():
                folder.mkdir(parents=True)
                _forget_others(folder)
            if os.access(folder, os.W_OK | os.X_OK):
                return folder
    return None


def _forget_others(folder: Path) -> None:
    for other in folder.parent.glob("kernels-*"):
        with suppress(OSError):
            if time.time() - other.stat().st_mtime > _FORGOTTEN_S:
                shutil.rmtree(other, ignore_errors=True)


def switched_off() -> str:
    """Why nothing is compiled at all, and the way out; empty: it is."""
    if not numba.config.DISABLE_JIT:
        return ""
    return "NUMBA_DISABLE_JIT is set: nothing is compiled, and images take some hundred times as long; unset it"


def problem() -> str:
    """Why results are not kept, and the way out; empty: they are."""
    if off := switched_off():
        return off
    if writable() is None:
        tried = ", ".join(str(folder.parent) for folder in folders())
        what, way_out = f"{tried}: compiled code cannot be written there", "make the folder writable"
    elif _problem:
        what, way_out = _problem, f"make room for {_ROOM_MB} MB there"
    else:
        return ""
    return (
        f"{what}; each start compiles anew, which takes minutes: {way_out}, or name another folder with "
        "NUMBA_CACHE_DIR, and run `artrec prepare`"
    )


def failed_write() -> str:
    """Why a result could not be written, though there is a folder for it; empty: none failed so far."""
    return _problem


def note_failed_write(why: str) -> None:
    """From here on `problem` tells of it."""
    global _problem
    _problem = why


def is_noted(name: str) -> bool:
    """Whether all results of this name are there."""
    return any((folder / f"{name}.ready").exists() for folder in folders())


def note(name: str) -> None:
    """All results of this name are there."""
    folder = writable()
    if folder is not None and not problem():
        with suppress(OSError):
            (folder / f"{name}.ready").touch()


@contextmanager
def held(waiting: Callable[[], None]) -> Iterator[None]:
    """For one process at a time: others wait for what it compiles. :param waiting: called again and again meanwhile."""
    folder = writable()
    try:
        file = (folder / "lock").open("a") if folder is not None else None
    except OSError:  # a full disk may have no room for another file
        file = None
    if file is None:
        yield
        return
    with file as lock:
        while True:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                waiting()
                time.sleep(_LOOK_S)
            except OSError:  # a file system without locks: at worst two compile the same
                break
        yield


class _Locator(_CacheLocator):
    """A function's results lie in `folders`, wherever its source is."""

    def __init__(self, function: Any) -> None:
        code = function.__code__
        self._place = f"{Path(code.co_filename).parent.name}-{code.co_firstlineno}"

    @classmethod
    def from_function(cls, function: Any, _: str) -> _Locator:
        return cls(function)

    def get_cache_path(self) -> str:
        return str(writable() or folders()[0])

    def get_source_stamp(self) -> str:
        return version()

    def get_disambiguator(self) -> str:
        return self._place


class _Implementation(CompileResultCacheImpl):
    _locator_classes = (_Locator,)


class KernelCache(FunctionCache):
    """numba's cache of one function, which reads from all `folders`, and goes on where nothing can be written."""

    _impl_class = _Implementation

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        base = self._impl.filename_base
        self._index_files = [folder / f"{base}.nbi" for folder in folders()]
        self._files = [IndexDataCacheFile(str(folder), base, version()) for folder in folders()]

    @property
    def has_results(self) -> bool:
        return any(file.exists() for file in self._index_files)

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        target_context.refresh()
        key = self._index_key(signature, target_context.codegen())
        for file in self._files:
            with suppress(OSError):
                data = file.load(key)
                if data is not None:
                    return self._impl.rebuild(target_context, data)
        return None

    def save_overload(self, signature: Any, data: Any) -> None:
        if writable() is None:
            return
        try:
            super().save_overload(signature, data)
        except OSError as error:
            note_failed_write(f"{self._cache_path}: compiled code cannot be written: {error.strerror or error}")
