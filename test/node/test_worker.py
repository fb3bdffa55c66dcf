"""The newest item first, and none queued."""

from __future__ import annotations

import threading
import time

from artrec_ros.node.worker import NewestFirst


def test_what_comes_while_it_works_is_dropped_but_for_the_newest() -> None:
    begun, go_on, done = threading.Event(), threading.Event(), threading.Event()
    seen: list[int] = []

    def work(item: int) -> None:
        seen.append(item)
        begun.set()
        assert go_on.wait(10)
        if item == 9:
            done.set()

    worker = NewestFirst(work, "test")
    worker.offer(1)
    assert begun.wait(10)
    for item in range(2, 10):
        worker.offer(item)
    go_on.set()
    assert done.wait(10)
    assert seen == [1, 9] and worker.dropped == 7
    worker.close()


def test_every_item_is_worked_where_there_is_time() -> None:
    seen: list[int] = []
    worker = NewestFirst(seen.append, "test")
    for item in range(1, 21):
        worker.offer(item)
        end = time.monotonic() + 10
        while len(seen) < item and time.monotonic() < end:
            time.sleep(0.001)
    assert seen == list(range(1, 21)) and worker.dropped == 0
    worker.close()


def test_closing_forgets_what_waits_and_ends_the_thread() -> None:
    begun, go_on = threading.Event(), threading.Event()
    seen: list[int] = []

    def work(item: int) -> None:
        seen.append(item)
        begun.set()
        assert go_on.wait(10)

    before = threading.active_count()
    worker = NewestFirst(work, "test")
    worker.offer(1)
    assert begun.wait(10)
    worker.offer(2)
    threading.Timer(0.05, go_on.set).start()
    worker.close()
    worker.offer(3)
    time.sleep(0.05)
    assert seen == [1] and threading.active_count() == before
