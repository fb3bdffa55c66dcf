"""When blobs are searched again."""

import cv2
import numpy as np
import pytest
from settings import DEFAULTS

from artrec_ros.core.base.config import RecallConfig
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.memory.looks import NO_LOOKS
from artrec_ros.core.memory.turns import Turns


def blobs(n, radius=10.0):
    image = np.zeros((100, 400), np.uint8)
    for k in range(n):
        cv2.circle(image, (20 + 35 * k, 50), round(radius), 3, -1)
    return find_blobs(image, {3}, DEFAULTS)


def play(n, hz, seconds, refresh_s, explained=True):
    """When each of n blobs that stay as they are is searched: a list of times for each; and the most in a frame."""
    seen, looks, times = blobs(n), NO_LOOKS, [[] for _ in range(n)]
    most = 0
    for k in range(int(seconds * hz)):
        turns = Turns(seen, looks, k / hz, 1 / hz, refresh_s, RecallConfig())
        searched = [i for i, blob in enumerate(seen) if not turns.waits(blob)]
        for i in searched:
            turns.search(seen[i])
            if explained:
                turns.explain(seen[i])
            times[i].append(k / hz)
        most = max(most, len(searched) if k else 0)
        looks = turns.left()
    return times, most


@pytest.mark.parametrize("hz", [1, 4, 10, 30, 100])
@pytest.mark.parametrize("n", [1, 3, 10])
def test_each_blob_is_searched_again_in_time(n, hz):
    refresh_s = 1.0
    for times in play(n, hz, 5, refresh_s)[0]:
        assert times[0] == 0
        assert np.diff(times).max() <= max(refresh_s, 1 / hz) + 1e-9


def test_turns_are_spread():
    times, most = play(6, 30, 10, 1.0)
    assert max(map(len, times)) <= 20  # and not 300
    assert most <= 2


def test_what_is_searched_in_vain_is_searched_again_soon_and_then_ever_later():
    (times,), _ = play(1, 100, 10, 1.0, explained=False)
    waits = np.diff(times)
    assert 0.04 <= waits[0] <= RecallConfig().retry_s
    assert (np.diff(waits[:4]) > 0).all()
    assert waits.max() <= 1.0 and len(times) < 25


@pytest.mark.parametrize("hz", [100, 5])
def test_what_is_too_little_to_tell_anything_is_searched_at_once_and_then_seldom_until_it_is_larger(hz):
    looks, times = NO_LOOKS, []
    for k in range(100):  # flickers, and from the 80th image on comes out from behind something
        (one,) = now = blobs(1, radius=2 + k % 2 if k < 80 else 2 + 0.4 * (k - 80))
        turns = Turns(now, looks, k / hz, 1 / hz, 80 / hz, RecallConfig())
        if not turns.waits(one):
            turns.search(one)
            times.append(k)
        looks = turns.left()
    assert times[0] == 0 and len([k for k in times if k < 80]) <= 2  # once before its time, for nothing is new
    assert any(80 < k < 90 for k in times)


@pytest.mark.parametrize("explained", [False, True])
def test_what_grows_and_grows_is_searched_no_more_often_than_what_was_searched_in_vain_once(explained):
    looks, times = NO_LOOKS, []
    for k in range(40):
        (one,) = grown = blobs(1, radius=4 + 0.25 * k)
        turns = Turns(grown, looks, k / 100, 1 / 100, 1.0, RecallConfig())
        if not turns.waits(one):
            times.append(k / 100)
            turns.search(one)
            if explained:
                turns.explain(one)
        looks = turns.left()
    waits, retry_s = np.diff(times), RecallConfig().retry_s
    assert (waits >= retry_s / 2).all() and len(times) >= 4
    assert waits.max() <= (2 * retry_s if explained else retry_s)


def look_at(turns, some):
    for blob in some:
        turns.search(blob)
        turns.explain(blob)


@pytest.mark.parametrize(("step", "always"), [(4, True), (0, False)])
def test_what_is_almost_an_object_waits_where_it_stands_still_alone(step, always):
    looks, searched = NO_LOOKS, []
    for k in range(12):
        image = np.zeros((100, 400), np.uint8)
        cv2.circle(image, (40 + step * k, 50), 10, 3, -1)
        seen = find_blobs(image, {3}, DEFAULTS)
        turns = Turns(seen, looks, k / 30, 1 / 30, 1.0, RecallConfig())
        if not turns.waits(seen[0]):
            turns.search(seen[0])
            searched.append(k)
        turns.doubt(np.array([[40.0 + step * k, 50.0]]), np.array([10.0]))
        looks = turns.left()
    assert (len(searched) == 12) == always and len(searched) >= 3


def test_new_blobs_go_first():
    two, three = blobs(2), blobs(3)
    before = Turns(two, NO_LOOKS, 0.0, 1 / 30, 1.0, RecallConfig())
    look_at(before, two)
    with_new = Turns(three, before.left(), 0.7, 1 / 30, 1.0, RecallConfig())
    assert [with_new.waits(b) for b in sorted(three, key=lambda b: b.pixels[:, 0].min())] == [True, True, False]
    alone = Turns(two, before.left(), 0.7, 1 / 30, 1.0, RecallConfig())
    assert not all(alone.waits(b) for b in two)


def test_what_is_gone_is_searched_at_once():
    two = blobs(2)
    before = Turns(two, NO_LOOKS, 0.0, 1 / 30, 1.0, RecallConfig())
    look_at(before, two)
    now = Turns(two, before.left(), 0.1, 1 / 30, 1.0, RecallConfig())
    there = np.array([[20.0, 50.0]]), np.array([15.0])
    now.hurry(*there, -1.0)  # gone since before they were searched
    assert all(now.waits(b) for b in two)
    now.hurry(*there, 0.0)
    assert sorted(now.waits(b) for b in two) == [False, True]
    (gone,) = (b for b in two if not now.waits(b))
    now.search(gone)  # in vain: soon once more
    assert sorted(now.left().wait_s) == [RecallConfig().retry_s, 1.0]
    now.forget()
    assert not any(now.waits(b) for b in two)
    for blob in two:  # searched anew, and in vain: soon once more
        now.search(blob)
    assert now.left().wait_s.tolist() == [RecallConfig().retry_s] * 2


def test_the_largest_blob_in_a_disc_is_told():
    some = blobs(3)
    turns = Turns(some, NO_LOOKS, 0.0, 1 / 30, 1.0, RecallConfig())
    assert turns.largest({3}, np.array([[55.0, 50.0]]), np.array([5.0])).pixels[:, 0].min() == 45
    assert turns.largest({3}, np.array([[300.0, 50.0]]), np.array([5.0])) is None
    assert turns.largest({4}, np.array([[55.0, 50.0]]), np.array([5.0])) is None
    assert Turns([], NO_LOOKS, 0.0, 1 / 30, 1.0, RecallConfig()).largest({3}, np.zeros((1, 2)), np.ones(1)) is None
