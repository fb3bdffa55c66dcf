"""Which blob of a frame is one that was searched before."""

import cv2
import numpy as np
import pytest
from settings import DEFAULTS

from artrec_ros.core.base.config import RecallConfig
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.memory.looks import NO_LOOKS, Looks

CONFIG = RecallConfig()


def looks(*boxes, at_s=0.0, label=3):
    """Looks at rectangles of left, top, width, height."""
    image = np.zeros((200, 300), np.uint8)
    for x, y, w, h in boxes:
        cv2.rectangle(image, (x, y), (x + w - 1, y + h - 1), label, -1)
    blobs = find_blobs(image, {label}, DEFAULTS)
    order = np.argsort([b.pixels[:, 0].min() for b in blobs])
    return Looks.of([blobs[n] for n in order], at_s)


def test_what_is_looked_at_is_measured():
    (one,) = looks((20, 30, 10, 6), at_s=2.5).box
    assert one.tolist() == [25, 33, 10, 6]


@pytest.mark.parametrize(
    ("box", "same", "grown"),
    [
        ((20, 30, 10, 6), True, False),
        ((25, 33, 10, 6), True, False),  # moved
        ((40, 30, 10, 6), False, False),  # elsewhere
        ((20, 30, 11, 6), True, False),  # a pixel of noise
        ((20, 30, 18, 6), True, True),  # it shows more
        ((20, 30, 5, 6), True, False),  # it shows less
    ],
)
def test_a_blob_is_the_same_where_it_is_near_and_grows_where_it_shows_more(box, same, grown):
    before, now = looks((20, 30, 10, 6)), looks(box)
    assert before.same(now, CONFIG).tolist() == [0 if same else -1]
    assert before.grown(now, CONFIG).tolist() == [grown]


def test_each_blob_is_one_of_before_at_most():
    before = looks((20, 30, 10, 10))
    assert sorted(before.same(looks((16, 30, 9, 9), (27, 30, 9, 9)), CONFIG).tolist()) == [-1, 0]


def test_blobs_of_another_class_are_others():
    assert looks((20, 30, 10, 6)).same(looks((20, 30, 10, 6), label=4), CONFIG).tolist() == [-1]


def test_without_blobs_there_is_nothing_to_compare():
    one = looks((20, 30, 10, 6))
    assert NO_LOOKS.same(one, CONFIG).tolist() == [-1]
    assert one.same(NO_LOOKS, CONFIG).tolist() == []


def test_growth_is_told_from_when_it_was_least():
    """Little by little something comes out from behind another thing: it is searched again long before it is whole."""
    size, look, searched = 10, looks((20, 30, 10, 20)), 0
    for width in (8, 6, 8, 10, 12):
        now = looks((20, 30, width, 20))
        assert look.same(now, CONFIG).tolist() == [0]
        if look.grown(now, CONFIG).any():
            look, searched, size = now, searched + 1, width
        else:
            look = look.moved_to(now)
    assert searched == 1 and size == 10  # of 6 it has grown by more than a third and the noise
