"""Bags damaged at random: all frames come back, or the loss is told (mutations.py, run with more, finds more)."""

from __future__ import annotations

import pytest
from mutations import FORMATS, run


@pytest.mark.parametrize("seed", [1, 2])
def test_no_frame_is_lost_in_silence(tmp_path, seed):
    lines: list[str] = []
    results = run(12 * len(FORMATS), seed, tmp_path, lines.append)
    assert not lines
    assert all(counts["all"] + counts["told"] == 12 for counts in results.values())
