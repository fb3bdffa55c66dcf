"""Work on other machines: the workers of a Dask scheduler (the extra `cluster`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from ...core.base.errors import ArtrecError
from ...io.base.bars import say
from .engines import MOST_DEATHS, QUEUED, Done, Engine, Job

_CONNECT_S = 20


class ClusterEngine(Engine):
    """Workers that see the same files under the same names, and have the same release installed.

    Dask gives the jobs of workers that die to others.
    """

    def __init__(self, address: str) -> None:
        """:raises ArtrecError: Dask is not installed, or there is no scheduler or worker."""
        try:
            import distributed
            from distributed.comm import get_address_host_port
        except ImportError as error:
            raise ArtrecError(f"--scheduler: {error}; pip install artrec_ros[cluster]") from error
        self._dask = distributed
        try:
            get_address_host_port(address)  # a client of no address waits long for its own end, and tells of that
        except ValueError as error:
            raise ArtrecError(f"--scheduler: {address}: is no address such as tcp://HOST:8786: {error}") from error
        say(f"looking for the Dask scheduler at {address}, for {_CONNECT_S} s at most")
        try:
            self._client = distributed.Client(address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise ArtrecError(f"--scheduler: {address}: no Dask scheduler answers there: {error}") from error
        self._jobs: dict[Any, Job] = {}
        if not self._threads:
            self._client.close()
            raise ArtrecError(f"--scheduler: {address}: it has no workers; start some: dask worker {address}")

    @property
    def _threads(self) -> int:
        return sum(self._client.nthreads().values())

    @property
    def free(self) -> bool:
        return len(self._jobs) < QUEUED * max(1, self._threads)

    @property
    def busy(self) -> bool:
        return bool(self._jobs)

    def submit(self, job: Job) -> None:
        self._jobs[self._client.submit(_collected, job.function, job.arguments, pure=False)] = job

    def wait(self) -> Iterator[Done]:
        try:
            with self._client.as_current():
                finished = self._dask.wait(list(self._jobs), return_when="FIRST_COMPLETED").done
        except OSError as error:
            raise ArtrecError(f"--scheduler: it went away ({error}); the same command goes on") from error
        for future in finished:
            job = self._jobs.pop(future)
            if future.cancelled():
                continue
            yield Done(job, self._result(job, future), True)

    def _result(self, job: Job, future: Any) -> tuple[Any, ...]:
        try:
            items: tuple[Any, ...] = future.result()
            return items
        except self._dask.KilledWorker as error:
            message = f"{job.name}: {MOST_DEATHS} workers or more died over it; is there too little memory?"
            raise ArtrecError(message) from error
        except ModuleNotFoundError as error:
            raise ArtrecError(f"--scheduler: {error} on a worker; install artrec_ros there, too") from error

    def stop(self) -> None:
        self._client.cancel(list(self._jobs), force=True)

    def close(self) -> None:
        self._client.cancel(list(self._jobs), force=True)
        self._client.close()


def _collected(function: Callable[..., Iterator[Any]], arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(function(*arguments))
