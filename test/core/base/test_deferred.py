"""Sequences that are worked out late."""

import copy
import pickle

from artrec_ros.core.base.deferred import Deferred


def test_it_is_worked_out_once_and_not_before_it_is_looked_at():
    calls = []

    def work():
        calls.append(1)
        yield from "abc"

    rows = Deferred(work)
    assert not calls
    assert list(rows) == ["a", "b", "c"]
    assert (rows[0], rows[1:], len(rows), "b" in rows, "d" in rows) == ("a", ("b", "c"), 3, True, False)
    assert calls == [1]


def test_it_stands_for_its_tuple():
    rows = Deferred(lambda: [1, 2])
    assert rows == (1, 2) and rows == Deferred(lambda: (1, 2))
    assert rows in [(1, 2)] and (1, 2) in [rows]
    assert rows != (1, 3) and rows != Deferred(lambda: (2, 1))
    assert repr(rows) == "(1, 2)" and hash(rows) == hash((1, 2))
    for copied in (pickle.loads(pickle.dumps(rows)), copy.deepcopy(rows)):
        assert copied == (1, 2) and type(copied) is tuple
    assert not Deferred(lambda: ())
