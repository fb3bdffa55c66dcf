"""Contours of blobs: their turn with the image, their inside, and where something else ends them."""

import numpy as np
import pytest
from cranes import BLUE, CONFIG, RED, SIZE
from scipy.spatial import cKDTree

from artrec_ros.core.image.blobs import find_blobs

pytestmark = pytest.mark.uncompiled


def test_contours_turn_with_the_image(scene):
    """By a quarter, points and normals alike; and the inside stays on the same side."""
    turned = find_blobs(np.ascontiguousarray(np.rot90(scene.labels)), {RED, BLUE}, CONFIG)
    upright = find_blobs(scene.labels, {RED, BLUE}, CONFIG)
    assert len(upright) == len(turned) >= 4
    for b in upright:
        x, y = b.contour.T
        expected = np.stack([y, SIZE[0] - 1 - x, b.normals[:, 1], -b.normals[:, 0]], axis=1)
        (same,) = (o for o in turned if cKDTree(o.contour).query(expected[:, :2])[0].max() < 1e-9)
        got = np.concatenate([same.contour, same.normals], axis=1)
        assert cKDTree(got).query(expected)[0].max() < 1e-9
        for blob in (b, same):
            x, y = blob.pixels.T.astype(int)
            assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0


def test_points_where_something_else_ends_are_cut(scene):
    for b in find_blobs(scene.labels, {RED}, CONFIG, (30, 20, 40, 30)):
        for (x, y), cut in zip(b.pixels.tolist(), b.cut, strict=True):
            assert cut == (x in (0, SIZE[0] - 1) or y in (0, SIZE[1] - 1) or (29 <= x <= 70 and 19 <= y <= 50))
