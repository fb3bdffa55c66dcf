"""Where work is done, and by this process. processes.py has others of this machine, cluster.py other machines."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

MOST_DEATHS = 3  # of workers over one job, before the job is given up
QUEUED = 2  # jobs a worker holds, the one that it is at included: it need not wait for the next one


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
