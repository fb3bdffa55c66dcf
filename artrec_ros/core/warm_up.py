"""Compiled code made ready before the first image, so that it is not late.

What is not kept from an earlier start is compiled by processes beside this one, into the same folder.
"""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

from .base import kernel_cache
from .base.config import RecognizerConfig
from .base.jit import kernels, share_compiled
from .model.target import Target
from .warm_up_pieces import PIECES, PLANE, ROOMS, SPACE, WHOLE
from .ways import FACING, PAPER, way_of
from .ways import PLANE as IN_PLANE
from .ways import SPACE as IN_SPACE

Told = Callable[[float], None]  # called with the share done, 0 to 1, again and again; not at all if all is there

_MOST_PROCESSES = 4
_LOOK_S = 0.2
_IN_VAIN = 3  # a process' exit code: what it compiles cannot be kept
# Python objects between two looks for garbage: at the usual 700 these take a tenth of the time; without any a process
# that compiles takes 3 GB in the end
_GARBAGE = 50_000
_ready: set[str] = set()
_one_at_a_time = threading.Lock()


def parts_needed(targets: Sequence[Target], config: RecognizerConfig, *, calibrated: bool) -> tuple[str, ...]:
    """Which parts of the method, for `get_ready`, are at work in images with or without calibration."""
    ways = {way_of(t, config, calibrated=calibrated) for t in targets}
    return (SPACE,) * bool(ways & {IN_SPACE, FACING}) + (PLANE,) * bool(ways & {IN_PLANE, PAPER})


def get_ready(parts: Collection[str], told: Told = lambda share: None) -> None:
    """Have the compiled code of some parts of the method, PLANE, SPACE or both, in this process."""
    if _ready.issuperset(parts):
        return
    with _one_at_a_time:
        new = [part for part in WHOLE if part in parts and part not in _ready]
        missing = [part for part in new if not kernel_cache.is_noted(part)]
        needed = kernels({room for part in missing for room in ROOMS[part]})

        def tell() -> None:
            told(share_compiled(needed))

        if missing:
            with kernel_cache.held(tell):
                missing = [part for part in missing if not kernel_cache.is_noted(part)]  # another process may have
                _compile(missing, tell)
        with _telling(tell) if missing and needed else nullcontext():  # where nothing is kept, all is compiled here
            for part in new:
                for run in WHOLE[part]:
                    run()
                if part in missing:
                    kernel_cache.note(part)
        _ready.update(new)


def is_kept() -> bool:
    """Whether other processes of this machine find all that this one has, and need not compile it anew."""
    return bool(kernel_cache.switched_off()) or all(kernel_cache.is_noted(part) for part in _ready)


def compiling() -> str:
    """What is being done while `Told` is called, as users read it."""
    return f"compiling, {'at every start' if kernel_cache.problem() else 'once on a machine'}"


@contextmanager
def _telling(tell: Callable[[], None]) -> Iterator[None]:
    """Tell at once, and again and again while this thread is at work."""
    tell()
    done = threading.Event()

    def go_on() -> None:
        while not done.wait(_LOOK_S):
            tell()

    thread = threading.Thread(target=go_on, name="telling how far the compiler is", daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _compile(parts: Collection[str], told: Callable[[], None]) -> None:
    """Compile what several processes can at once. What goes wrong there shows when this one compiles it itself."""
    names = [name for name, piece in PIECES.items() if piece.part in parts]
    if kernel_cache.writable() is None or not names or not sys.executable or not kernels(ROOMS[PIECES[names[0]].part]):
        return
    count = min(_MOST_PROCESSES, len(os.sched_getaffinity(0)), len(names))
    environment = dict(os.environ)
    if "NUMBA_CACHE_DIR" in environment:  # the processes have a working folder of their own
        environment["NUMBA_CACHE_DIR"] = str(Path(environment["NUMBA_CACHE_DIR"]).absolute())
    at_work: list[subprocess.Popen[bytes]] = []
    try:
        with suppress(OSError):  # no more processes
            for mine in _shared_out(names, count):
                at_work.append(
                    subprocess.Popen(
                        [sys.executable, "-m", __name__, *mine],
                        cwd=Path(__file__).parents[2],
                        env=environment,
                        stdin=subprocess.PIPE,
                        stdout=subprocess.PIPE,
                        stderr=subprocess.DEVNULL,
                    )  # fmt: skip
                )
        while None in (codes := {process.poll() for process in at_work}) and _IN_VAIN not in codes:
            told()
            time.sleep(_LOOK_S)
    finally:
        for process in at_work:
            process.kill()
            why = process.communicate()[0]
            if process.returncode == _IN_VAIN:  # others may have had something to say as well
                kernel_cache.note_failed_write(os.fsdecode(why))
    told()


def _shared_out(names: Sequence[str], count: int) -> list[list[str]]:
    """Pieces for each process: the longest first, each to the one with the least to do."""
    out: list[list[str]] = [[] for _ in range(count)]
    for name in sorted(names, key=lambda n: -PIECES[n].seconds):
        min(out, key=lambda mine: sum(PIECES[n].seconds for n in mine)).append(name)
    return out


def main(names: Sequence[str]) -> None:
    """A process beside the one that gets ready: compile these pieces."""
    for end in (_end_with_parent, _end_in_vain):
        threading.Thread(target=end, daemon=True).start()
    gc.set_threshold(_GARBAGE)
    for name in names:
        PIECES[name].run()
    _tell_in_vain()  # the last one may be what could not be kept


def _end_with_parent() -> None:
    """Nothing is ever written to this process: its input ends when the one that started it does."""
    sys.stdin.read()
    os._exit(1)


def _end_in_vain() -> None:
    """What cannot be kept is of use to nobody: the process that started this one compiles it for itself, and is told
    why at once."""
    while True:
        _tell_in_vain()
        time.sleep(_LOOK_S)


def _tell_in_vain() -> None:
    if why := kernel_cache.failed_write():
        os.write(sys.stdout.fileno(), os.fsencode(why))
        os._exit(_IN_VAIN)


if __name__ == "__main__":
    main(sys.argv[1:])
