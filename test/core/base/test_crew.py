"""Threads that share work: results in order, whoever did it."""

import threading
import time

import pytest

from artrec_ros.core.base.crew import Ahead, Crew


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_results_come_in_the_order_of_the_items(threads):
    def slowly(n):
        time.sleep(0.002 * (n % 3))
        return n * n

    assert Crew(threads).each(slowly, range(20)) == [n * n for n in range(20)]


def test_others_are_at_the_next_items_meanwhile():
    both = threading.Barrier(2, timeout=30)  # breaks unless two are at work at once
    Crew(2).each(lambda n: both.wait(), range(2))
    assert not both.broken


def test_items_that_are_left_out_are_not_begun():
    done = []
    ahead = Ahead(Crew(3), done.append, list(range(10)), lambda item: item % 2 == 0)
    for n in (0, 2, 4):
        ahead.take(n)
    assert set(done) <= {0, 2, 4, 6, 8}
    assert {0, 2, 4} <= set(done)


def test_an_error_reaches_who_takes_the_item():
    def fail(n):
        if n == 1:
            raise ValueError("one")
        return n

    ahead = Ahead(Crew(2), fail, [0, 1, 2])
    assert ahead.take(0) == 0
    with pytest.raises(ValueError, match="one"):
        ahead.take(1)
    assert ahead.take(2) == 2


def test_nobody_else_is_asked_where_there_is_one():
    me = threading.get_ident()
    assert Crew(1).each(lambda n: threading.get_ident(), range(3)) == [me] * 3
    assert len(Crew(0)) >= 1
