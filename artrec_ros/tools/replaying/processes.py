"""Work in processes of this machine."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import pickle
import queue
import signal
import threading
import traceback
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any

import cv2

from ...core.base.errors import ArtrecError
from .engines import MOST_DEATHS, QUEUED, Done, Engine, Job

_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Ctrl-C reaches all processes of a terminal, SIGTERM those of a service, but it is the parent that decides: they
    are blocked in workers that are started here. The parent learns of them at the end."""
    resource_tracker.ensure_running()  # started with the first worker, it would unblock the signals for it
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Worker:
    """A process, and the jobs that it holds: the one that it is at is the first.

    It shares no lock and no pipe with another process than its parent. So there is nothing that it can take along
    when it is killed at whatever moment (as a pool's workers can, at which its parent waits for ever): its end of
    the pipe is closed by the system.
    """

    def __init__(self, context: Any, stopping: Any) -> None:
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, stopping), daemon=True)
        with _uninterrupted():
            self._process.start()
        theirs.close()  # the worker has the only one: without it there is an end of what can be read
        self.jobs: deque[Job] = deque()

    @property
    def is_alive(self) -> bool:
        return self._process.is_alive()

    def submit(self, job: Job) -> None:
        order = pickle.dumps((job.function, job.arguments))
        self.jobs.append(job)
        with suppress(BrokenPipeError, ConnectionResetError):  # it died: `receive` will tell
            self.connection.send_bytes(order)

    def receive(self) -> Done | None:
        """The first job's items; waits for them. None: the worker died.

        :raises Exception: whatever the job raised.
        """
        try:
            answer = self.connection.recv_bytes()
        except (EOFError, OSError):
            return None
        job = self.jobs.popleft()
        items, error, told = pickle.loads(answer)
        if error is not None:
            raise error from RuntimeError(told)
        return Done(job, items, True)

    def end(self) -> None:
        self.connection.close()
        self._process.kill()
        self._process.join()


def _serve(connection: Connection, stopping: Any) -> None:
    """What a worker process does all its life."""
    cv2.setNumThreads(1)
    jobs: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_take_in, args=(connection, jobs), daemon=True).start()
    while True:
        job = jobs.get()
        try:
            function, arguments = pickle.loads(job)
            answer = pickle.dumps((_collected(function, arguments, stopping), None, ""))
        except Exception as error:  # the parent's to judge
            answer = _packed(error, traceback.format_exc())
        connection.send_bytes(answer)


def _packed(error: Exception, told: str) -> bytes:
    """What the parent raises; in other words where it could not read the error itself."""
    try:
        answer = pickle.dumps(((), error, told))
        pickle.loads(answer)
    except Exception:  # whatever an error of any library does when it is put together again
        return pickle.dumps(((), RuntimeError(told), told))
    return answer


def _take_in(connection: Connection, jobs: queue.SimpleQueue[bytes]) -> None:
    """Take jobs in, so that neither end can wait for the other to read; end with the parent, which may be killed."""
    with suppress(EOFError, OSError):
        while True:
            jobs.put(connection.recv_bytes())
    os._exit(1)


def _collected(function: Callable[..., Iterator[Any]], arguments: tuple[Any, ...], stopping: Any) -> tuple[Any, ...]:
    items = []
    if not stopping.value:
        for item in function(*arguments):
            items.append(item)
            if stopping.value:
                break
    return tuple(items)


class ProcessEngine(Engine):
    """Worker processes of this machine. One that dies costs the job that it was at, which is done again."""

    def __init__(self, workers: int) -> None:
        self._context = multiprocessing.get_context("spawn")  # OpenCV's and numba's threads do not survive a fork
        self._stopping = self._context.RawValue(ctypes.c_bool, False)  # an Event has a lock, which may be left locked
        self._environment = {name: os.environ.get(name) for name in _ONE_THREAD}
        os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))  # processes use the cores, not threads of each
        self._deaths: dict[Job, int] = {}
        self._workers: list[_Worker] = []
        try:
            with _uninterrupted():
                self._workers += (_Worker(self._context, self._stopping) for _ in range(workers))
        except BaseException:  # no more processes, or files; or Ctrl-C
            self.close()
            raise

    @property
    def free(self) -> bool:
        return any(len(worker.jobs) < QUEUED for worker in self._workers)

    @property
    def busy(self) -> bool:
        return any(worker.jobs for worker in self._workers)

    def submit(self, job: Job) -> None:
        slot = min(range(len(self._workers)), key=lambda i: len(self._workers[i].jobs))
        if not self._workers[slot].jobs and not self._workers[slot].is_alive:  # it died between two jobs
            self._replace(slot)
        self._workers[slot].submit(job)

    def wait(self) -> Iterator[Done]:
        busy = [worker.connection for worker in self._workers if worker.jobs]
        ready = wait(busy) if busy else []
        for slot, worker in enumerate(self._workers):
            if worker.connection in ready:
                done = worker.receive()
                if done is None:
                    self._revive(slot)
                else:
                    yield done

    def _revive(self, slot: int) -> None:
        """Give a new worker the jobs of one that died."""
        dead = self._replace(slot)
        job = dead.jobs[0]  # that it was at
        self._deaths[job] = self._deaths.get(job, 0) + 1
        if self._deaths[job] >= MOST_DEATHS:
            raise ArtrecError(f"{job.name}: {MOST_DEATHS} workers died over it; is there too little memory?")
        for job in dead.jobs:
            self._workers[slot].submit(job)

    def _replace(self, slot: int) -> _Worker:
        """Put a new worker in the place of a dead one, which is returned."""
        dead = self._workers[slot]
        dead.end()
        self._workers[slot] = _Worker(self._context, self._stopping)
        return dead

    def stop(self) -> None:
        self._stopping.value = True

    def close(self) -> None:
        for worker in self._workers:
            worker.end()
        for name, value in self._environment.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
