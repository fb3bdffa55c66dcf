"""Markers that lie on each other are views of one thing."""

from dataclasses import replace

import numpy as np
import pytest
from solids import FRONT, RIGHT_SIDE, marker, rectangle

from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.stacked import stacks_of
from artrec_ros.core.model.surface import patches_of

UP, LIE = rectangle(0.05, 0.06), rectangle(0.12, 0.04, (-0.03, 0.0))
LIE_BACK = LIE * (-1, 1)


def stacks(*markers, others=()):
    parts = (Component("part", markers, required=True), *others)
    return stacks_of(patches_of(ObjectModel("toy", parts), 1)).tolist()


def flat(name, outline, at=(0.0, 0.0, 0.0)):
    return marker(name, outline, np.eye(3), at)


def test_those_that_lie_on_each_other_directly_or_by_others_are_one_stack():
    aside = flat("aside", UP, (0.3, 0, 0))
    assert stacks(flat("lie", LIE), aside, flat("up", UP), flat("back", LIE_BACK)) == [0, -1, 0, 0]
    left, right = (rectangle(0.04, 0.04, (x, 0.0)) for x in (-0.04, 0.04))  # on the long one alone
    assert stacks(flat("left", left), flat("right", right), flat("long", rectangle(0.14, 0.04))) == [0, 0, 0]
    pair = [flat("up", UP, (0.3, 0, 0)), flat("lie", LIE, (0.3, 0, 0))]
    assert stacks(flat("up2", UP), flat("lie2", LIE), *(replace(m, name=f"{m.name}3") for m in pair)) == [0, 0, 2, 2]


@pytest.mark.parametrize(
    "other",
    [
        marker("lie", LIE, FRONT, (0, 0, 0)),
        marker("lie", LIE, np.diag([1.0, -1, -1]), (0, 0, 0)),
        flat("lie", LIE, (-0.04, 0, 0)),
        flat("lie", LIE, (0, 0, 0.03)),
    ],
    ids=["on another side", "on the far side", "hardly overlapping", "one before the other"],
)
def test_what_may_be_seen_at_once_is_none(other):
    assert stacks(flat("up", UP), other) == [-1, -1]


def test_markers_of_two_components_are_none():
    assert stacks(flat("up", UP), others=[Component("other", (flat("lie", LIE),))]) == [-1, -1]
    assert stacks(marker("side", UP, RIGHT_SIDE, (0, 0, 0))) == [-1]
