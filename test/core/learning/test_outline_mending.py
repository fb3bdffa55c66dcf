"""Outlines as they are seen beside those that were drawn."""

import numpy as np
import pytest

from artrec_ros.core.geometry.polygons import distance_to_outline, signed_area
from artrec_ros.core.learning.outline_mending import along, laid_on, mended_by

PLATE = np.array([(-0.08, -0.02), (0.08, -0.02), (0.08, 0.02), (-0.08, 0.02)])
NOTCH = [(0.06, 0.02), (0.06, 0.0), (0.04, 0.0), (0.04, 0.02)]
NOTCHED = np.array([*PLATE[:3], *NOTCH, PLATE[3]])
NOISE = 0.002


def farthest(a, b):
    """Hausdorff distance of two outlines, metres."""
    return max(distance_to_outline(along(a), b).max(), distance_to_outline(along(b), a).max())


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("drawn", "seen"), [(PLATE, NOTCHED), (NOTCHED, PLATE)], ids=["notch", "tab"])
def test_what_differs_is_mended_and_the_rest_stays_as_it_was_drawn(drawn, seen, sense):
    rounded = seen + np.random.default_rng(3).normal(0, 0.0003, seen.shape)
    mended = mended_by(drawn, rounded[::sense], NOISE)
    assert farthest(mended, seen) < NOISE and farthest(drawn, seen) > 0.015
    kept = [p for p in PLATE if np.abs(mended - p).sum(axis=1).min() == 0]
    assert len(kept) == 4  # corners, to the digit
    assert signed_area(mended) * signed_area(drawn) > 0


def test_nothing_is_mended_within_the_noise():
    assert mended_by(PLATE, PLATE + (0.001, -0.001), NOISE) is PLATE


def test_of_quite_another_shape_nothing_is_kept():
    angle = 2 * np.pi * np.arange(24) / 24
    disc = 0.06 * np.column_stack([np.cos(angle), np.sin(angle)])
    assert mended_by(PLATE, disc, NOISE) is disc


@pytest.mark.parametrize("slanted", [False, True])
def test_what_is_seen_is_laid_where_most_of_it_is_as_drawn(slanted):
    """A notch does not pull it: place, turn and size are the file's, under a slant width over height too."""
    turn = np.array([[np.cos(0.05), -np.sin(0.05)], [np.sin(0.05), np.cos(0.05)]])
    seen = 1.04 * NOTCHED * ((1, 0.95) if slanted else (1, 1)) @ turn.T + (0.003, -0.002)
    assert farthest(laid_on(seen, PLATE, 0.0008, slanted), NOTCHED) < 0.0012
    assert farthest(seen, NOTCHED) > 0.004
