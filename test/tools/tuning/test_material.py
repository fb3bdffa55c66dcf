from __future__ import annotations

import pytest

from artrec_ros.core.base.errors import SourceError
from artrec_ros.tools.tuning.material import split


@pytest.mark.parametrize(("share", "block"), [(0.3, 1), (0.5, 4), (0.2, 7), (0.05, 1)])
def test_every_frame_is_on_one_side(share, block):
    numbers = list(range(3, 103, 2))
    found = split(numbers, share, block, seed=1)
    assert sorted([*found.tuned_on, *found.held_out]) == numbers
    assert not set(found.tuned_on) & set(found.held_out)
    assert len(found.held_out) == pytest.approx(share * 50, abs=block)
    assert found == split(numbers, share, block, seed=1) != split(numbers, share, block, seed=2)


def test_blocks_stay_together():
    held = set(split(range(60), 0.5, 6, seed=0).held_out)
    assert all(len(held & set(range(i, i + 6))) in (0, 6) for i in range(0, 60, 6))


@pytest.mark.parametrize(("count", "share", "block"), [(1, 0.5, 1), (10, 0.01, 1), (10, 0.99, 1), (10, 0.5, 10)])
def test_no_side_may_be_empty(count, share, block):
    with pytest.raises(SourceError, match="both parts need one or more"):
        split(range(count), share, block, seed=0)
