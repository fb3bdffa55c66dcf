"""The newest items, and hardly any queued."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from peer import WAIT_S, wait_until

from artrec_ros.node.worker import LiveQueue


def test_what_comes_while_it_works_is_dropped_but_for_the_newest() -> None:
    begun, go_on, done = threading.Event(), threading.Event(), threading.Event()
    seen: list[int] = []

    def work(item: int) -> None:
        seen.append(item)
        begun.set()
        assert go_on.wait(WAIT_S)
        if item == 9:
            done.set()

    worker = LiveQueue(work, "test")
    worker.offer(1)
    assert begun.wait(WAIT_S)
    for item in range(2, 10):
        worker.offer(item)
    go_on.set()
    assert done.wait(WAIT_S)
    assert seen == [1, 9] and worker.dropped == 7
    worker.close()


def test_every_item_is_worked_where_there_is_time() -> None:
    seen: list[int] = []
    worker = LiveQueue(seen.append, "test")
    for item in range(1, 21):
        worker.offer(item)
        assert wait_until(lambda item=item: len(seen) == item, lambda: time.sleep(0.001))
    assert seen == list(range(1, 21)) and worker.dropped == 0
    worker.close()


def test_closing_forgets_what_waits_and_ends_the_thread() -> None:
    begun, go_on = threading.Event(), threading.Event()
    seen: list[int] = []

    def work(item: int) -> None:
        seen.append(item)
        begun.set()
        assert go_on.wait(WAIT_S)

    before = threading.active_count()
    worker = LiveQueue(work, "test")
    worker.offer(1)
    assert begun.wait(WAIT_S)
    worker.offer(2)
    closing = threading.Thread(target=worker.close)
    closing.start()
    assert wait_until(lambda: not worker._open)
    go_on.set()
    closing.join()
    worker.offer(3)
    assert wait_until(lambda: threading.active_count() == before)
    assert seen == [1]


def test_it_tells_how_long_it_works_on_one_item() -> None:
    begun, go_on = threading.Event(), threading.Event()

    def work(item: int) -> None:
        begun.set()
        assert go_on.wait(WAIT_S)

    worker = LiveQueue(work, "test")
    assert worker.busy_s == 0
    worker.offer(1)
    assert begun.wait(WAIT_S)
    first = worker.busy_s
    assert wait_until(lambda: worker.busy_s > first > 0)
    go_on.set()
    assert wait_until(lambda: worker.busy_s == 0)
    worker.close()


def fed(work_s, items=80, **options):
    """What is worked on of items that come every 10 ms, and how many are dropped; every 20th takes 25 ms more."""
    seen = []

    def work(item):
        time.sleep(work_s + 0.025 * (item % 20 == 19))
        seen.append(item)

    worker = LiveQueue(work, "test", **options)
    for item in range(items):
        worker.offer(item)
        time.sleep(0.01)
    assert wait_until(lambda: seen and seen[-1] == items - 1, lambda: time.sleep(0.001))
    worker.close()
    assert seen == sorted(seen) and len(seen) + worker.dropped == items
    return seen, worker.dropped


def test_images_wait_for_one_that_takes_long_where_work_keeps_up() -> None:
    seen, dropped = fed(0.001, most_waiting=4)
    assert set(range(35, 80)) <= set(seen)  # at first nothing is known of its pace
    assert dropped < fed(0.001)[1]


def test_nothing_waits_where_work_does_not_keep_up() -> None:
    """Else each item would be as late as those before it together."""
    seen, dropped = fed(0.03, most_waiting=50)
    assert dropped > 30 and np.diff(seen[-10:]).min() >= 2
