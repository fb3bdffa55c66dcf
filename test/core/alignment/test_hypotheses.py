from dataclasses import replace

import numpy as np
import pytest
from scene import Placed, disc, draw, flag, rectangle
from settings import settings

from artrec_ros.core.alignment.contour_map import ContourMap
from artrec_ros.core.alignment.hypotheses import anchor_couples
from artrec_ros.core.alignment.overlap import overlap_matrix
from artrec_ros.core.alignment.placements import Placements
from artrec_ros.core.alignment.shapes import Shape
from artrec_ros.core.alignment.starts import find_starts
from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.range_limits import scale_limits
from artrec_ros.core.image.blobs import find_blobs

CONFIG = RecognizerConfig()
EVERYTHING = settings(coarse_match=0.0, refine_keep=200, coarse_keep=10_000)  # that is of a possible size
SIZE = (200, 160)


def proposals(labels, marker, config=CONFIG, deadline=None):
    blobs = find_blobs(labels, {1}, config)
    cmap = ContourMap.build(blobs, SIZE)
    shapes, scales = [Shape.from_marker(marker)], scale_limits(config, None)
    return find_starts(blobs, cmap, shapes, {(0, 1)}, config, deadline or Deadline(), scales)


def test_couples_run_round_the_polygon():
    a = np.array([0, 1, 1 + 1j, 1j])
    first, second = anchor_couples(a, (1, 2))
    assert list(zip(first[:4], second[:4], strict=True)) == [(0, 1), (1, 1 + 1j), (1 + 1j, 1j), (1j, 0)]
    assert second[4:].tolist() == [1 + 1j, 1j, 0, 1]
    assert len(anchor_couples(a[:2], (2,))[0]) == 0  # no couple of an anchor with itself
    assert len(anchor_couples(a[:0], (1,))[0]) == 0


def test_the_true_pose_is_among_the_couples_and_none_is_too_small():
    labels = np.zeros(SIZE[::-1], np.uint8)
    draw(labels, flag(), Placed(90, 80, 0.6, 60), 1)
    found = proposals(labels, flag(), EVERYTHING)
    z = 60 * np.exp(0.6j)
    near = (np.abs(found.t - (90 + 80j)) < 1.5) & (np.abs(found.z - z) < 3)
    assert near.any()
    area = Shape.from_marker(flag()).area_m2 * np.abs(found.z) ** 2
    blob = np.count_nonzero(labels)
    assert area.min() >= 0.99 * CONFIG.alignment.min_area_ratio * blob
    assert area.max() <= 1.1 * CONFIG.alignment.max_area_ratio * blob


def test_scale_limits_hold():
    labels = np.zeros(SIZE[::-1], np.uint8)
    draw(labels, flag(), Placed(90, 80, 0.6, 60), 1)
    found = proposals(labels, flag(), replace(EVERYTHING, min_scale=50, max_scale=70))
    assert len(found)
    assert np.abs(found.z).min() >= 50 and np.abs(found.z).max() <= 70


def test_circles_are_proposed_for_discs_in_merged_blobs():
    labels = np.zeros(SIZE[::-1], np.uint8)
    draw(labels, disc("spot", 0.5), Placed(80, 80, 0, 40), 1)
    draw(labels, rectangle("bar", 2.0, 0.3), Placed(120, 80, 0, 40), 1)
    found = proposals(labels, disc("spot", 0.5))
    assert np.any((np.abs(found.t - (80 + 80j)) < 1) & (np.abs(np.abs(found.z) - 40) < 1.5))


def test_no_hypotheses_after_the_deadline():
    labels = np.full(SIZE[::-1], 1, np.uint8)
    deadline = Deadline(0)
    assert len(proposals(labels, flag(), deadline=deadline)) == 0
    assert deadline.hit


def test_a_part_of_a_deadline_ends_first_and_tells_the_whole():
    whole = Deadline(1000.0)
    assert not whole.part(0.5).expired
    assert whole.part(0.0).expired
    assert whole.hit and not whole.expired


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_overlap_is_the_share_of_the_smaller_area(turn):
    shapes = [Shape.from_marker(rectangle("square", 1.0, 1.0)), Shape.from_marker(rectangle("bar", 1.0, 0.25))]
    u = np.exp(1j * turn)
    t = 50 + 50j + u * np.array([0, 20, 0, 100, 10])
    z, none = np.array([40, 40, 20, 40, 40]) * u, np.zeros(5, np.int32)
    placed = Placements.similarities(t, z, np.array([0, 0, 0, 0, 1], np.int32), none, none)
    overlap = overlap_matrix(shapes, placed, np.array([1, 1, 1, 1, 1]))
    np.testing.assert_allclose(overlap, overlap.T)
    assert overlap[0, 1] == pytest.approx(0.5, abs=0.06)  # half a square aside
    assert overlap[0, 2] == pytest.approx(1.0, abs=0.02)  # a small one within
    assert overlap[0, 3] == 0
    assert overlap[0, 4] == pytest.approx(0.75, abs=0.06)
    other_class = overlap_matrix(shapes, placed, np.array([1, 2, 1, 1, 2]))
    assert other_class[0, 1] == 0 and other_class[0, 4] == 0  # a sticker lies on its part
