"""The newest items, and hardly any queued."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from peer import WAIT_S, wait_until

from artrec_ros.node.worker import LiveQueue, Pace


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


def held() -> tuple[Callable[[int], int], list[int], threading.Event, threading.Event]:
    """A function that returns its item once the last event is set; what it was called with; and set once it was."""
    begun, go_on = threading.Event(), threading.Event()
    seen: list[int] = []

    def call(item: int) -> int:
        seen.append(item)
        begun.set()
        assert go_on.wait(WAIT_S)
        return item

    return call, seen, begun, go_on


def at_work(prepare: Callable[[int], int] | None = None) -> tuple[LiveQueue[int], list[int], threading.Event]:
    """A queue whose first item, 1, is worked on until the event is set; and what it has worked on."""
    work, seen, begun, go_on = held()
    worker = LiveQueue(work, "test", prepare=prepare)
    worker.offer(1)
    assert begun.wait(WAIT_S)
    return worker, seen, go_on


def test_closing_forgets_what_waits_and_ends_the_thread() -> None:
    before = threading.active_count()
    worker, seen, go_on = at_work()
    worker.offer(2)
    closing = threading.Thread(target=worker.close)
    closing.start()
    assert wait_until(lambda: not worker._open)
    go_on.set()
    closing.join()
    worker.offer(3)
    assert wait_until(lambda: threading.active_count() == before)
    assert seen == [1]


def test_once_ended_nothing_more_is_taken_though_the_thread_still_works() -> None:
    worker, seen, go_on = at_work()
    worker.offer(2)
    worker.end()
    worker.offer(3)
    go_on.set()
    worker.close()
    assert seen == [1]


@pytest.mark.parametrize(("work_s", "is_late"), [(0.01, False), (0.05, True)])
def test_where_work_does_not_keep_up_it_is_late_before_the_next_item_comes(work_s, is_late) -> None:
    worker, _, go_on = at_work()
    worker._pace = pace([work_s] * 30, [0.033] * 30)
    assert worker.is_late is is_late
    go_on.set()
    worker.close()


def test_it_tells_whether_a_newer_item_waits() -> None:
    worker, _, go_on = at_work()
    assert not worker.is_late
    worker.offer(2)
    assert worker.is_late
    go_on.set()
    assert wait_until(lambda: not worker.is_late)
    worker.close()


def test_it_tells_how_long_it_works_on_one_item() -> None:
    work, _, begun, go_on = held()
    worker = LiveQueue(work, "test")
    assert worker.busy_s == 0
    worker.offer(1)
    assert begun.wait(WAIT_S)
    first = worker.busy_s
    assert wait_until(lambda: worker.busy_s > first > 0)
    go_on.set()
    assert wait_until(lambda: worker.busy_s == 0)
    worker.close()


def pace(work_s, between_s, too_soon=(True,)):
    found = Pace()
    found.too_soon.extend(too_soon)
    found.work_s.extend(work_s)
    found.between_s.extend(between_s)
    return found


@pytest.mark.parametrize(
    ("work_s", "between_s", "keeps_up"),
    [
        ([0.015] * 30, [0.033] * 30, True),
        ([0.015] * 27 + [0.1] * 3, [0.033] * 30, True),  # one that takes long is made up for
        ([0.04] * 30, [0.033] * 30, False),
        ([0.04] * 30, [0.033] * 29 + [60.0], False),  # a pause of the camera
        ([0.03] * 30, [0.033] * 30, False),  # what waits would wait for long
        ([0.015] * 3, [0.033] * 3, None),  # nobody knows yet
    ],
)
def test_it_keeps_up_where_work_takes_less_than_passes_between_items(work_s, between_s, keeps_up):
    assert pace(work_s, between_s).keeps_up is keeps_up


def test_whoever_waits_for_answers_comes_as_fast_as_these_and_is_never_too_late():
    """As `artrec play --wait-for`, whose results are those of a replay: nothing is put off."""
    assert pace([0.04] * 30, [0.041] * 30, [False] * 30).keeps_up is True
    assert pace([0.04] * 30, [0.041] * 30, [False] * 29 + [True]).keeps_up is False
    late, answered = list[bool](), threading.Event()

    def work(item: int) -> None:
        late.append(worker.is_late)
        time.sleep(0.002)
        worker.answered()
        answered.set()
        time.sleep(0.002)  # what is left to do makes no item late

    worker = LiveQueue(work, "test")
    for item in range(80):
        worker.offer(item)
        assert answered.wait(WAIT_S)
        answered.clear()
    assert late == [False] * 80
    worker.close()


@pytest.mark.parametrize(("back_s", "is_late"), [(5.0, False), (0.2, True)])
def test_where_stamps_go_back_the_pace_of_the_source_before_is_forgotten(back_s, is_late):
    """As where a bag is played with `--wait-for` after a camera that was too fast; what comes out of order is none."""
    late, answered = list[bool](), threading.Event()

    def work(item: int) -> None:
        late.append(worker.is_late)
        worker.answered()
        answered.set()

    worker = LiveQueue(work, "test")
    worker._pace = pace([0.05] * 30, [0.033] * 30, [True] * 30)
    worker._stamp_ns = int(1e12)
    for item in range(3):
        worker.offer(item, int(1e12 - back_s * 1e9) + 1000 * item)
        assert answered.wait(WAIT_S)
        answered.clear()
    assert late == [is_late] * 3
    worker.close()


@pytest.mark.parametrize(("work_s", "seen_of_it"), [(0.01, [0, 3, 4, 5]), (0.05, [0, 5])])
def test_a_few_items_wait_for_one_that_takes_long_where_work_keeps_up(work_s, seen_of_it) -> None:
    begun, go_on, seen = threading.Event(), threading.Event(), []

    def work(item: int) -> None:
        begun.set()
        assert go_on.wait(WAIT_S)
        seen.append(item)

    worker = LiveQueue(work, "test", most_waiting=3)
    worker._pace = pace([work_s] * 30, [0.033] * 30)
    worker.offer(0)
    assert begun.wait(WAIT_S)
    for item in range(1, 6):
        worker.offer(item)
    go_on.set()
    assert wait_until(lambda: seen and seen[-1] == 5)
    assert seen == seen_of_it and worker.dropped == 6 - len(seen_of_it)
    worker.close()


def test_what_waits_is_prepared_meanwhile_and_what_does_not_wait_is_not() -> None:
    prepared: list[int] = []

    def prepare(item: int) -> int:
        prepared.append(item)
        return 10 * item

    worker, seen, go_on = at_work(prepare=prepare)
    assert not prepared
    worker.offer(2)
    assert wait_until(lambda: prepared == [2]), "it waits until the first one is answered"
    assert seen == [1]
    go_on.set()
    assert wait_until(lambda: seen == [1, 20])
    worker.close()


def test_what_cannot_be_prepared_is_worked_on_as_it_is() -> None:
    worker, seen, go_on = at_work(prepare=lambda item: item // 0)
    worker.offer(2)
    go_on.set()
    assert wait_until(lambda: seen == [1, 2])
    worker.close()


def test_what_is_dropped_is_not_prepared_any_more() -> None:
    prepare, prepared, begun, go_on = held()
    worker, seen, end = at_work(prepare=prepare)
    worker.offer(2)
    assert begun.wait(WAIT_S)
    for item in (3, 4, 5):
        worker.offer(item)
    go_on.set()
    assert wait_until(lambda: len(prepared) == 2)
    end.set()
    assert wait_until(lambda: seen == [1, 5])
    assert prepared == [2, 5]
    worker.close()


def test_once_ended_what_was_waited_for_is_not_worked_on() -> None:
    prepare, _, begun, go_on = held()
    worker, seen, end = at_work(prepare=prepare)
    worker.offer(2)
    assert begun.wait(WAIT_S)
    end.set()
    assert wait_until(lambda: not worker._waiting)  # it waits for what is being prepared
    worker.end()
    go_on.set()
    worker._thread.join(WAIT_S)
    assert not worker._thread.is_alive() and seen == [1]


def test_what_is_prepared_holds_up_nobody_who_ends() -> None:
    program = """
import time
from artrec_ros.node.worker import LiveQueue
worker = LiveQueue(lambda item: time.sleep(60), "test", prepare=lambda item: time.sleep(60))
worker.offer(1)
time.sleep(0.1)
worker.offer(2)
time.sleep(0.1)
"""
    subprocess.run([sys.executable, "-c", program], check=True, timeout=30)
