"""How much is looked into while newer images wait."""

import time

import pytest

from artrec_ros.core.base.patience import Patience


@pytest.fixture
def clock(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    return now


def look(clock, seconds):
    def at_it():
        clock[0] += seconds
        return "shown"

    return at_it


def test_after_a_look_the_next_one_rests_until_it_took_its_share(clock):
    patience = Patience(lambda: True)
    assert not patience.is_over
    assert patience.spent_on(look(clock, 0.06), 0.25) == "shown"
    assert patience.is_over
    clock[0] += 0.17
    assert patience.is_over
    clock[0] += 0.02
    assert not patience.is_over


def test_who_is_not_late_has_all_the_time(clock):
    late = [False]
    patience = Patience(lambda: late[0])
    patience.spent_on(look(clock, 5.0), 0.25)
    assert not patience.is_over and not patience.is_late
    late[0] = True
    assert patience.is_over and patience.is_late
    patience = Patience()
    patience.spent_on(look(clock, 5.0), 0.25)
    assert not patience.is_over and not patience.is_late
