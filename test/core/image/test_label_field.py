"""Look-ups of labels, also beyond the border, and the width of a segmenter's seam."""

import cv2
import numpy as np
import pytest
from settings import DEFAULTS
from solids import BACKGROUND, RED

from artrec_ros.core.image.codes import EMPTY, OUTSIDE, OWNED, UNKNOWN
from artrec_ros.core.image.label_field import LabelField


def disc_image(seam=0, outer=BACKGROUND, radius=25.0):
    """RED within `radius`, then `seam` unknown pixels, then `outer`."""
    y, x = np.mgrid[:90, :100]
    r = np.hypot(x - 50.3, y - 44.6)
    return np.select([r <= radius, r <= radius + seam], [RED, UNKNOWN], outer).astype(np.uint8)


def test_any_place_has_a_label():
    rng = np.random.default_rng(0)
    labels = rng.integers(0, 8, (7, 11), np.uint8)
    points = rng.uniform(-4, 15, (500, 2))
    found = LabelField(labels).at(points)
    for (x, y), label in zip(np.rint(points).astype(int), found, strict=True):
        inside = 0 <= x < 11 and 0 <= y < 7
        assert label == (labels[y, x] if inside else OUTSIDE)


def test_look_ups_keep_their_shape_and_far_away_is_outside():
    field = LabelField(np.ones((4, 5), np.uint8))
    assert field.at(np.zeros((2, 3, 6, 2))).shape == (2, 3, 6)
    assert field.at(np.zeros((0, 2))).shape == (0,)
    far = np.array([[1e12, 0], [-1e12, 1e12], [0, -1e9], [4.5001, 0], [-0.5001, 0]])
    np.testing.assert_array_equal(field.at(far), OUTSIDE)
    np.testing.assert_array_equal(field.at(np.array([[4.49, 3.49], [-0.49, -0.49]])), 1)


@pytest.mark.parametrize("seam", [0, 1, 2, 3])
def test_a_seam_is_measured(seam):
    assert LabelField(disc_image(seam)).seam_px(RED) == pytest.approx(seam / 2, abs=0.3)


def patches(gap=2):
    """Two patches of one robot side by side on a plain floor: a part of each border is near the other."""
    labels = np.full((90, 100), UNKNOWN, np.uint8)
    labels[30:50, 20:40] = RED
    labels[30:50, 40 + gap : 60 + gap] = 4
    return labels


def test_a_gap_between_two_patches_is_no_seam():
    """It made the patches larger, and bent robots' joints further by five degrees."""
    field = LabelField(patches())
    near, border, _ = field._near_px(RED)
    assert DEFAULTS.seams.border_share * border < len(near) < DEFAULTS.seams.clear_share * border
    assert field.seam_px(RED) == field.seam_px(4) == 0.0


def test_where_the_segmenter_leaves_seams_around_other_classes_the_gap_is_one_too():
    both = np.hstack([patches(), disc_image(2)])
    both[both == RED] = 5  # the disc, too: it is of a class of its own
    both[:, :100][patches() == RED] = RED
    assert LabelField(both).seam_px(RED) == pytest.approx(1.0, abs=0.3)


def test_what_may_be_a_body_of_no_class_around_a_marker_is_no_seam():
    """A rim of two pixels of a robot's body: its marker was taken for larger by as much."""
    field = LabelField(disc_image(2), on_bodies=[RED])
    assert field.seam_px(RED) == 0.0
    assert field.most_seam_px(RED) == pytest.approx(1.0, abs=0.3)  # for all that is known
    tight = np.hstack([disc_image(2), np.where(disc_image() == RED, 4, 5).astype(np.uint8)])
    assert LabelField(tight, on_bodies=[RED]).seam_px(RED) == 0.0


def test_around_such_a_marker_the_seam_is_what_it_is_around_other_classes():
    other = disc_image(2)
    other[other == RED] = 4
    field = LabelField(np.hstack([disc_image(4), other]), on_bodies=[RED])
    assert field.seam_px(RED) == field.seam_px(4) == pytest.approx(1.0, abs=0.2)


def test_where_nothing_known_follows_there_is_no_seam():
    assert LabelField(disc_image(outer=UNKNOWN)).seam_px(RED) == 0.0
    assert LabelField(np.full((9, 9), RED, np.uint8)).seam_px(RED) == 0.0
    assert LabelField(disc_image()).seam_px(7) == 0.0  # a class that is not there


def test_amid_unknown_pixels_it_is_empty_but_not_in_seams_and_speckles():
    labels = disc_image(outer=UNKNOWN)
    labels[40:48, 45:53] = UNKNOWN  # a hole that is no wider than two seams
    field, reach = LabelField(labels), DEFAULTS.seams.reach_px
    y, x = np.mgrid[:90, :100]
    codes = field.at(np.stack([x, y], axis=-1))
    far = np.hypot(x - 50.3, y - 44.6) > 25 + 1.5 * reach
    assert (codes[far] == EMPTY).all()
    np.testing.assert_array_equal(codes[~far & (codes != EMPTY)], labels[~far & (codes != EMPTY)])
    assert (codes[40:48, 45:53] == UNKNOWN).all()
    assert not np.any(field.labels == EMPTY)


def test_of_an_ignored_rectangle_nothing_is_known():
    labels = np.zeros((60, 80), np.uint8)
    codes = LabelField(labels, ignored=(0, 0, 40, 60)).at(np.array([[10, 30], [42, 30], [70, 30]]))
    assert codes.tolist() == [UNKNOWN, UNKNOWN, EMPTY]


def test_pixels_of_another_object_leave_the_image_but_not_the_seam():
    labels = disc_image(2)
    field = LabelField(labels)
    seam = field.seam_px(RED)
    less = field.without([np.float32([[-3, -3], [51, -3], [51, 500], [-3, 500]])])
    at = np.array([[30.0, 44.0], [60.0, 44.0]])
    assert less.at(at).tolist() == [OWNED, RED]
    assert field.at(at).tolist() == [RED, RED]
    np.testing.assert_array_equal(labels, disc_image(2))
    assert less.seam_px(RED) == seam


def test_labels_are_not_copied_needlessly_nor_changed():
    labels = disc_image()
    field = LabelField(labels)
    assert field.labels is labels
    assert field.padded.size == (90 + 2) * (100 + 2)
    padded = cv2.copyMakeBorder(labels, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=OUTSIDE)
    np.testing.assert_array_equal(field.padded, padded.ravel())


@pytest.mark.uncompiled
def test_a_seams_gaps_are_those_to_the_nearest_pixel_of_another_known_class():
    coarse = np.random.default_rng(4).choice([0, RED, 5, OWNED], (7, 8), p=[0.5, 0.3, 0.15, 0.05])
    labels = np.kron(coarse, np.ones((5, 5))).astype(np.uint8)
    known = np.argwhere(~np.isin(labels, (UNKNOWN, OWNED, OUTSIDE, RED)))
    expected = []
    for y, x in np.argwhere(labels == RED).tolist():
        if not (4 <= y < 31 and 4 <= x < 36) or (labels[y - 1 : y + 2, x - 1 : x + 2] == RED).all():
            continue
        off = known - (y, x)
        near = np.hypot(*off[np.abs(off).max(axis=1) <= 4].T)
        expected.append(near.min() - 1 if len(near) else np.inf)
    assert np.isinf(expected).any() and len(set(expected)) > 3
    np.testing.assert_allclose(np.sort(LabelField(labels)._gaps_px(RED)[0]), np.sort(expected))


def test_a_seam_does_not_come_and_go_with_the_pixels_that_are_looked_at():
    """A floor around patches, a third of which has but a seam around it: which pixels of the border are
    looked at must not decide."""
    labels = np.full((540, 960), 5, np.uint8)
    for n, (x, y) in enumerate((x, y) for x in range(60, 900, 100) for y in range(60, 480, 100)):
        gap = 10 if n % 3 else 2
        labels[y - gap : y + 20 + gap, x - gap : x + 20 + gap] = UNKNOWN
        labels[y : y + 20, x : x + 20] = RED
    seams = {LabelField(labels[rows:, 2 * rows :]).seam_px(RED) for rows in range(16)}
    assert len(seams) == 1


@pytest.mark.uncompiled
@pytest.mark.parametrize("size", [(1, 1), (8, 8), (9, 9), (9, 1)])
def test_small_images_and_absent_classes_have_no_seam(size):
    field = LabelField(np.full(size, RED, np.uint8))
    assert field.seam_px(RED) == field.seam_px(RED + 1) == 0.0


@pytest.mark.uncompiled
@pytest.mark.parametrize("turns", range(4))
def test_every_side_of_a_large_blob_tells_its_seam(turns):
    labels = np.zeros((460, 620), np.uint8)
    labels[10:450, 10:610], labels[:, :9] = RED, 5  # only one side has something known beside it
    gaps = LabelField(np.rot90(labels, turns).copy())._gaps_px(RED)[0]
    assert np.isfinite(gaps).sum() > 5
    assert np.median(gaps[np.isfinite(gaps)]) == 1.0
