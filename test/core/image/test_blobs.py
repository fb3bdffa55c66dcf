import cv2
import numpy as np
import pytest
from scene import Placed, draw, rectangle
from settings import settings

from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.image import blobs
from artrec_ros.core.image.blobs import anchor_points, blob_anchors, find_blobs

CONFIG = RecognizerConfig()


def test_blobs_are_per_class_and_specks_are_dropped():
    labels = np.zeros((60, 80), np.uint8)
    labels[5:15, 5:25] = 2
    labels[15:25, 5:25] = 3  # touches the first: another class, another blob
    labels[40:50, 40:60] = 2
    labels[30:32, 30:32] = 2  # a speck
    blobs = find_blobs(labels, {2, 3, 7}, CONFIG)
    assert [(b.label, b.area_px) for b in blobs] == [(2, 200.0), (2, 200.0), (3, 200.0)]
    assert len(find_blobs(labels, {2}, settings(min_blob_px=4))) == 3
    assert find_blobs(np.zeros((0, 0), np.uint8) + np.zeros((1, 1), np.uint8), {1}, CONFIG) == ()


def test_holes_are_ignored():
    labels = np.zeros((60, 60), np.uint8)
    labels[10:50, 10:50] = 1
    whole = find_blobs(labels, {1}, CONFIG)[0]
    labels[20:40, 20:40] = 2
    holed = find_blobs(labels, {1}, CONFIG)
    assert len(holed) == 1
    np.testing.assert_array_equal(holed[0].pixels, whole.pixels)
    assert holed[0].area_px == whole.area_px


def test_what_lies_in_a_ring_of_its_own_class_is_a_blob_too():
    """A red border around the whole scene, and a red marker on a white plate in a red field."""
    labels = np.zeros((80, 100), np.uint8)
    labels[30:50, 40:60] = 1
    alone = find_blobs(labels, {1}, CONFIG)
    cv2.rectangle(labels, (2, 2), (97, 77), 1, 1)
    ring, inside = find_blobs(labels, {1}, CONFIG)
    np.testing.assert_array_equal(inside.pixels, alone[0].pixels)
    assert ring.area_px == 96 * 76


def test_rings_in_rings_are_all_found_and_specks_in_holes_are_not():
    """A target of rings, pinholes all over, and in its middle a square; in one of the gaps a speck."""
    labels = np.zeros((120, 120), np.uint8)
    for side in (110, 80, 50):
        cv2.rectangle(labels, (60 - side // 2, 60 - side // 2), (60 + side // 2, 60 + side // 2), 1, 4)
    labels[50:70, 50:70] = 1
    labels[np.random.default_rng(1).random(labels.shape) < 0.01] = 0
    labels[25:27, 58:60] = 1
    areas = [round(b.area_px) for b in find_blobs(labels, {1}, CONFIG)]
    assert len(areas) == 4 and areas[-1] <= 400 < areas[-2]


def test_what_lies_in_a_hole_is_found_however_narrow_the_gap_around_it_is():
    labels = np.ones((140, 140), np.uint8)
    labels[60:82, 60:82] = 0
    labels[61:81, 61:81] = 1
    assert [b.area_px for b in find_blobs(labels, {1}, settings(min_blob_px=300))] == [140 * 140, 400]


def test_many_rings_in_rings_take_no_time_and_no_stack():
    y, x = np.mgrid[:2400, :2400]
    rings = (np.maximum(abs(x - 1200), abs(y - 1200)) % 2).astype(np.uint8)
    blobs = find_blobs(rings, {1}, settings(max_blobs=5000))
    assert len(blobs) == 600


@pytest.mark.parametrize("angle", [0.0, 0.2, 0.5, np.pi / 4, 1.2])
@pytest.mark.parametrize("side", [20.0, 60.0])
def test_subpixel_contour_removes_the_half_pixel(angle, side):
    labels = np.zeros((120, 120), np.uint8)
    draw(labels, rectangle("square", 1.0, 1.0), Placed(60.3, 59.6, angle, side), 1)
    blob = find_blobs(labels, {1}, CONFIG)[0]
    raw, corrected = (cv2.contourArea(c.astype(np.float32)) for c in (blob.pixels, blob.contour))
    assert abs(corrected / side**2 - 1) < 0.02
    assert abs(raw / side**2 - 1) > 1.5 * abs(corrected / side**2 - 1)


def test_normals_point_outward():
    labels = np.zeros((100, 100), np.uint8)
    cv2.circle(labels, (50, 50), 30, 1, -1)
    blob = find_blobs(labels, {1}, CONFIG)[0]
    outward = (blob.contour - 50) / np.linalg.norm(blob.contour - 50, axis=1, keepdims=True)
    assert np.min(np.sum(outward * blob.normals, axis=1)) > 0.9


@pytest.mark.uncompiled
def test_points_on_the_border_and_along_blanked_rectangles_are_no_evidence():
    labels = np.zeros((40, 40), np.uint8)
    labels[10:20, 0:30] = 1
    blob = find_blobs(labels, {1}, CONFIG, blank=(30, 0, 10, 40))[0]
    x = blob.pixels[:, 0]
    assert set(x[blob.cut]) == {0, 29}
    assert not blob.cut[(x > 0) & (x < 29)].any()


def test_anchors_of_a_polygon_are_its_corners():
    labels = np.zeros((120, 120), np.uint8)
    draw(labels, rectangle("bar", 1.0, 0.5), Placed(60, 60, 0.4, 60), 1)
    blob = find_blobs(labels, {1}, CONFIG)[0]
    corners = np.array([(30, 15), (-30, 15), (-30, -15), (30, -15)]) @ [
        [np.cos(0.4), np.sin(0.4)],
        [-np.sin(0.4), np.cos(0.4)],
    ]
    anchors = blob_anchors(blob, CONFIG)[-1]
    assert len(anchors) == 4
    for corner in corners + 60:
        assert np.linalg.norm(anchors - corner, axis=1).min() < 1.5


def test_ragged_blobs_get_no_more_anchors_than_allowed():
    rng = np.random.default_rng(0)
    labels = (rng.random((200, 200)) < 0.6).astype(np.uint8)
    blob = find_blobs(labels, {1}, CONFIG)[0]
    assert len(anchor_points(blob.contour, 1.0)) > CONFIG.blobs.max_anchors
    assert all(3 <= len(a) <= CONFIG.blobs.max_anchors for a in blob_anchors(blob, CONFIG))


def test_only_the_largest_blobs_are_kept():
    labels = np.zeros((50, 200), np.uint8)
    for n in range(8):
        labels[5 : 10 + n, 25 * n + 2 : 25 * n + 12] = 1
    kept = find_blobs(labels, {1}, settings(max_blobs=3))
    assert [b.area_px for b in kept] == [120.0, 110.0, 100.0]


@pytest.mark.parametrize("classes", [2, 3, 5, 9])
def test_specks_left_out_early_change_no_blob(monkeypatch, classes):
    """Noise is rid of its specks before contours are drawn: the same blobs come out."""
    labels = np.random.default_rng(classes).integers(0, classes, (97, 131)).astype(np.uint8)
    config = settings(min_blob_px=12, max_blobs=10_000)
    assert blobs._crowd((labels == 1).view(np.uint8)) > blobs._CROWDED
    early = find_blobs(labels, {1, 2}, config)
    monkeypatch.setattr(blobs, "_CROWDED", 1.0)
    late = find_blobs(labels, {1, 2}, config)
    assert len(late) or classes == 9
    assert [(b.label, b.area_px) for b in early] == [(b.label, b.area_px) for b in late]
    for one, other in zip(early, late, strict=True):
        np.testing.assert_array_equal(one.pixels, other.pixels)


def test_plain_images_are_not_crowded():
    labels = np.zeros((60, 80), np.uint8)
    labels[5:15, 5:25] = labels[20:50, 40:60] = 1
    assert blobs._crowd((labels == 1).view(np.uint8)) <= blobs._CROWDED
