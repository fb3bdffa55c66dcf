"""Where work is done: in this process, or in processes of this machine. cluster.py has other machines."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing.connection import wait as wait_for
from typing import Any

import cv2

from ...core.errors import ArtrecError

MOST_DEATHS = 3  # of workers over one job, before the job is given up
_QUEUED = 2  # jobs a worker holds, the one that it is at included: it need not wait for the next one
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True, eq=False)
class Job:
    """A call of a function that gives items. :param name: for users. :param tag: whatever the caller wants back."""

    name: str
    tag: Any
    function: Callable[..., Iterator[Any]]
    arguments: tuple[Any, ...]


@dataclass(frozen=True)
class Done:
    """Items of a job. :param last: nothing more comes of it; a job that was stopped may have given less than all."""

    job: Job
    items: tuple[Any, ...]
    last: bool


class Engine(ABC):
    """Does jobs. A context manager: what is still at work at its end is abandoned."""

    @property
    @abstractmethod
    def free(self) -> bool:
        """Whether another job can be taken."""

    @property
    @abstractmethod
    def busy(self) -> bool:
        """Whether there is something to wait for."""

    @abstractmethod
    def submit(self, job: Job) -> None: ...

    @abstractmethod
    def wait(self) -> Iterator[Done]:
        """What gets done next. :raises ArtrecError: a job failed, or workers die over it again and again."""

    @abstractmethod
    def stop(self) -> None:
        """Finish the items at hand and no more; may be called by a signal's handler."""

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @abstractmethod
    def close(self) -> None: ...


class InlineEngine(Engine):
    """This process; items come one by one."""

    def __init__(self) -> None:
        self._job: Job | None = None
        self._stopped = False

    @property
    def free(self) -> bool:
        return self._job is None

    @property
    def busy(self) -> bool:
        return self._job is not None

    def submit(self, job: Job) -> None:
        self._job = job

    def wait(self) -> Iterator[Done]:
        job, self._job = self._job, None
        if job is None or self._stopped:
            return
        for item in job.function(*job.arguments):
            yield Done(job, (item,), False)
            if self._stopped:
                return
        yield Done(job, (), True)

    def stop(self) -> None:
        self._stopped = True

    def close(self) -> None:
        self._job = None


_stopping: Any = None  # in a worker process: the event that its parent sets


def _begin(stopping: Any) -> None:
    global _stopping
    _stopping = stopping
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of a terminal: the parent decides
    cv2.setNumThreads(1)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A parent that is killed cannot end its workers."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    wait_for([parent.sentinel])
    os._exit(1)


def _collected(function: Callable[..., Iterator[Any]], arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    items = []
    if not _stopping.is_set():
        for item in function(*arguments):
            items.append(item)
            if _stopping.is_set():
                break
    return tuple(items)


class ProcessEngine(Engine):
    """Worker processes of this machine. One that dies costs the job that it was at, which is done again."""

    def __init__(self, workers: int) -> None:
        self._context = multiprocessing.get_context("spawn")  # OpenCV's and numba's threads do not survive a fork
        self._stopping = self._context.Event()
        self._environment = {name: os.environ.get(name) for name in _ONE_THREAD}
        os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))  # processes use the cores, not threads of each
        self._pools = [self._pool() for _ in range(workers)]
        self._at: list[dict[Future[Any], Job]] = [{} for _ in range(workers)]
        self._deaths: dict[Job, int] = {}

    def _pool(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(1, self._context, initializer=_begin, initargs=(self._stopping,))

    @property
    def free(self) -> bool:
        return any(len(at) < _QUEUED for at in self._at)

    @property
    def busy(self) -> bool:
        return any(self._at)

    def submit(self, job: Job) -> None:
        slot = min(range(len(self._at)), key=lambda i: len(self._at[i]))
        self._submit(slot, job)

    def _submit(self, slot: int, job: Job) -> None:
        try:
            self._at[slot][self._pools[slot].submit(_collected, job.function, job.arguments)] = job
        except BrokenProcessPool:  # it died between two jobs
            self._revive(slot)
            self._submit(slot, job)

    def wait(self) -> Iterator[Done]:
        done, _ = wait([future for at in self._at for future in at], return_when=FIRST_COMPLETED)
        for slot, at in enumerate(self._at):
            for future in [f for f in at if f in done]:
                job = at.get(future)
                if job is None:  # done again elsewhere: the worker died
                    continue
                if isinstance(future.exception(), BrokenProcessPool):
                    self._revive(slot)
                else:
                    del at[future]
                    yield Done(job, future.result(), True)

    def _revive(self, slot: int) -> None:
        """Put a new worker in the place of one that died, and give it the same jobs."""
        jobs = list(self._at[slot].values())
        self._at[slot].clear()
        self._pools[slot].shutdown(wait=False)
        self._pools[slot] = self._pool()
        for job in jobs[:1]:  # the one that it was at
            self._deaths[job] = self._deaths.get(job, 0) + 1
            if self._deaths[job] >= MOST_DEATHS:
                raise ArtrecError(f"{job.name}: {MOST_DEATHS} workers died over it; is there too little memory?")
        for job in jobs:
            self._submit(slot, job)

    def stop(self) -> None:
        self._stopping.set()

    def close(self) -> None:
        self._stopping.set()
        for pool in self._pools:
            pool.shutdown(wait=False, cancel_futures=True)
        for name, value in self._environment.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
