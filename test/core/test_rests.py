"""What objects leave of the blobs that they share with others."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, truck

from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.rests import Rests


@pytest.fixture(scope="module")
def finder():
    return WholeObjectFinder(Target("truck", truck(), RED), DEFAULTS)


@pytest.fixture
def shared():
    """The labels and the one blob of a bar with two tabs."""
    labels = np.zeros((120, 200), np.uint8)
    labels[40:60, 20:180] = RED
    labels[60:80, 30:50] = labels[60:80, 120:150] = RED
    (blob,) = find_blobs(labels, {RED}, RecognizerConfig())
    return LabelField(labels), blob


def box(x0, y0, x1, y1):
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], np.float32)


def test_each_is_told_once_and_again_where_more_of_it_is_taken(finder, shared):
    field, blob = shared
    rests = Rests()
    assert rests.of(field, finder, blob) == []  # nobody took any
    taken = field.without([box(19, 39, 181, 59)])
    left = rests.of(taken, finder, blob)
    assert [r.area_px for r in left] == [600.0, 400.0]
    assert all(rests.whole(rest) is blob for rest in (*left, blob))
    assert rests.of(taken, finder, blob) == []
    more = taken.without([box(119, 59, 134, 81)])  # half of one; the other one is as it was
    assert [r.area_px for r in rests.of(more, finder, blob)] == [300.0]


def test_the_rim_that_an_object_leaves_is_none(finder, shared):
    field, blob = shared
    taken = field.without([box(19, 42, 181, 59), box(29, 59, 51, 81), box(119, 59, 151, 81)])
    assert np.count_nonzero(taken.labels == RED) == 320  # two rows of pixels are left
    assert Rests().of(taken, finder, blob) == []
