"""First placements of outlines, against all of them tried one by one."""

import itertools

import numpy as np
import pytest
from cranes import RED, placed_points
from settings import settings

from artrec_ros.core.alignment.counting_kernels import by_count
from artrec_ros.core.alignment.placements import matched_share
from artrec_ros.core.alignment.starts import find_starts
from artrec_ros.core.alignment.whole_contours import WholeContours
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.range_limits import scale_limits
from artrec_ros.core.image.blobs import blob_anchors

pytestmark = pytest.mark.uncompiled


def test_points_are_counted(scene, starts):
    """As one reads them from the map one by one."""
    cmap, few = scene.cmap, starts.take(np.arange(0, len(starts), 5))
    few = few.replace(t=few.t + np.linspace(0, 5, len(few)))
    share = matched_share(cmap, scene.shapes, few, 2.0, Deadline())
    for n in range(len(few)):
        hits = 0
        for p in placed_points(few, n, scene.shapes[few.shape[n]].points) - complex(*cmap.origin):
            x, y = round(p.real), round(p.imag)
            inside = 0 <= x < cmap.distance.shape[1] and 0 <= y < cmap.height
            hits += inside and cmap.distance[few.slot[n] * cmap.height + y, x] <= 30
        assert share[n] == hits / 120
    assert share.min() < 0.5 < share.max()
    late = Deadline(0)
    assert not matched_share(cmap, scene.shapes, few, 2.0, late).any() and late.hit


def test_counts_are_sorted_and_equal_ones_keep_their_order():
    count = np.random.default_rng(0).integers(0, 9, 60)
    assert by_count(count, 60, 8).tolist() == np.argsort(-count, kind="stable").tolist()
    assert by_count(count[:0], 0, 8).tolist() == []


@pytest.mark.parametrize("changes", [{}, {"coarse_keep": 20, "couple_spans": (1, 3)}, {"max_scale": 33.0}])
def test_starts_are_the_best_of_all_hypotheses(scene, changes):
    """Of every couple of anchors and every way to lie on the whole contour, tried one by one."""
    config = settings(coarse_step=8, **changes)
    scales = scale_limits(config, None)
    found = find_starts(scene.blobs, scene.cmap, scene.shapes, {(0, RED)}, config, Deadline(), scales)
    shape, most = scene.shapes[0], config.max_scale or np.inf
    for b, blob in enumerate(scene.blobs):
        mine = found.take(np.flatnonzero(found.blob == b))
        if blob.label != RED:
            assert not len(mine)
            continue
        tried = []
        for polygon in blob_anchors(blob, config):
            p, q = polygon @ np.array([1, 1j]), shape.anchors
            spans = config.alignment.couple_spans
            for i, j, span, other in itertools.product(range(len(p)), range(len(q)), spans, spans):
                if span < len(p) and other < len(q):
                    z = (p[(i + span) % len(p)] - p[i]) / (q[(j + other) % len(q)] - q[j])
                    tried.append((p[i] - z * q[j], z))
        laid = WholeContours([blob]).laid([shape], *np.zeros((2, 1), int), config.alignment.whole_ways)
        tried += [(t[0], z[0]) for t, z in zip(*(np.array(laid).transpose(0, 2, 1)), strict=True)]
        t, z = np.array(tried).T
        area = shape.area_m2 * np.abs(z) ** 2
        low = max(config.min_blob_px, config.alignment.min_area_ratio * blob.area_px)
        high = config.alignment.max_area_ratio * blob.area_px
        t, z, area = (a[(low <= area) & (area <= high) & (np.abs(z) <= most)] for a in (t, z, area))
        tolerance = np.clip(config.alignment.tolerance_share * np.sqrt(area), 1.0, config.alignment.tolerance_px)
        slot = scene.cmap.slots[RED]
        where = t[:, None] + z[:, None] * shape.points - complex(*scene.cmap.origin)
        x = np.clip(np.rint(where.real), 0, scene.cmap.distance.shape[1] - 1).astype(int)
        y = np.clip(np.rint(where.imag), 0, scene.cmap.height - 1).astype(int)
        near = scene.cmap.distance[slot * scene.cmap.height + y, x] <= np.floor(tolerance * 15)[:, None]
        share = near.mean(axis=1)
        passed = (near[:, ::8].mean(axis=1) >= config.alignment.coarse_match) & (share >= config.alignment.coarse_match)
        assert bool(len(mine)) == passed.any()
        if not len(mine):
            continue
        assert mine.score[0] == mine.score.max() == pytest.approx(share[passed].max())
        assert len(mine) <= max(4, len(blob.pixels) // 8)
        for n in range(len(mine)):
            same = (np.abs(t - mine.t[n]) < 1e-6) & (np.abs(z - mine.z[n]) < 1e-6)
            assert same.any() and np.abs(share[same] - mine.score[n]).min() < 1e-12
        apart = np.hypot(np.abs(mine.t[:, None] - mine.t), shape.rms_radius_m * np.abs(mine.z[:, None] - mine.z))
        reach = np.maximum(1.0, config.alignment.same_start * shape.rms_radius_m * np.abs(mine.z))
        for a, better in itertools.combinations(range(len(mine)), 2):
            assert apart[a, better] > reach[a] - 1e-9
        if "coarse_keep" not in changes:  # what is not kept is near one as good, unless the quota is full
            for n in np.flatnonzero(passed) if len(mine) < max(4, len(blob.pixels) // 8) else ():
                d = np.hypot(np.abs(mine.t - t[n]), shape.rms_radius_m * np.abs(mine.z - z[n]))
                assert ((d <= reach + 1e-9) & (mine.score >= share[n] - 1e-12)).any()
    assert len(found)
