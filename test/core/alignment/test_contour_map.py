"""The map of distances to the nearest contour, against OpenCV and a tree of all points."""

import cv2
import numpy as np
import pytest
from cranes import SIZE
from scipy.spatial import cKDTree

from artrec_ros.core.alignment import contour_map
from artrec_ros.core.alignment.contour_map import ContourMap
from artrec_ros.core.image.contour_kernels import merge_boxes

pytestmark = pytest.mark.uncompiled


@pytest.mark.parametrize("most_boxes", [64, 0])
def test_the_map_holds_opencvs_transform(monkeypatch, scene, most_boxes):
    """To the last bit, in boxes of their own and in one around all; and the nearest points are near."""
    monkeypatch.setattr(contour_map, "_MOST_BOXES", most_boxes)
    cmap, blobs = ContourMap.build(scene.blobs, SIZE), scene.blobs
    pixels = np.concatenate([b.pixels for b in blobs]) - np.array(cmap.origin)
    seen = ~np.concatenate([b.cut for b in blobs])
    distance = np.full(cmap.distance.shape, 255, np.uint8)
    for label, slot in cmap.slots.items():
        top, of_class = slot * cmap.height, np.array([blobs[b].label == label for b in cmap.blob[:-1]])
        corners = [pixels[cmap.blob[:-1] == n] for n, b in enumerate(blobs) if b.label == label]
        boxes = np.array([[*p.min(axis=0) - 16, *p.max(axis=0) + 17] for p in corners])
        whole = np.array([[*boxes[:, :2].min(axis=0), *boxes[:, 2:].max(axis=0)]])
        for left, above, right, below in (merge_boxes(boxes) if most_boxes else whole).tolist():
            canvas = np.full((below - above, right - left), 255, np.uint8)
            x, y = pixels[seen & of_class].T
            inside = (x >= left) & (x < right) & (y >= above) & (y < below)
            canvas[y[inside] - above, x[inside] - left] = 0
            far = cv2.distanceTransform(canvas, cv2.DIST_L2, 5)
            distance[top + above : top + below, left:right] = cv2.convertScaleAbs(far, alpha=15.0)
        rows, columns = np.nonzero(cmap.distance[top : top + cmap.height] < 200)
        index = cmap.nearest[top + rows, columns]
        assert (seen & of_class)[index].all()
        here = np.stack([columns, rows], axis=1)
        true = cKDTree(pixels[seen & of_class]).query(here)[0]
        np.testing.assert_allclose(np.hypot(*(pixels[index] - here).T), true, rtol=0.035)
    np.testing.assert_array_equal(cmap.distance, distance)
    assert 0 == distance.min() < distance.max() == 255
