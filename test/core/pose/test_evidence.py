"""Votes of labels, look-ups beyond the border, and the width of a segmenter's seam."""

import cv2
import numpy as np
import pytest
from solids import BACKGROUND, BODY, RED

from artrec_ros.core.image.label_field import OUTSIDE, OWNED, UNKNOWN, LabelField
from artrec_ros.core.pose.votes import VoteRoles


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


def test_where_nothing_known_follows_there_is_no_seam():
    assert LabelField(disc_image(outer=UNKNOWN)).seam_px(RED) == 0.0
    assert LabelField(np.full((9, 9), RED, np.uint8)).seam_px(RED) == 0.0
    assert LabelField(disc_image()).seam_px(7) == 0.0  # a class that is not there


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


def test_each_role_is_listed_once():
    roles = VoteRoles()
    asked = [roles.inside(RED), roles.rim(RED), roles.ring(RED, 0), roles.ring(RED, BODY), roles.body(BODY, RED)]
    assert asked == [0, 1, 2, 3, 4]
    assert [roles.inside(RED), roles.body(BODY, RED), roles.inside(7)] == [0, 4, 5]
    assert roles.table.shape == (6, 256) and roles.table.dtype == np.float32


def test_what_each_place_says():
    roles = VoteRoles()
    names = ("inside", "rim", "ring", "ring_on_body", "body")
    index = (roles.inside(RED), roles.rim(RED), roles.ring(RED, 0), roles.ring(RED, BODY), roles.body(BODY, RED))
    votes = dict(zip(names, roles.table[list(index)], strict=True))
    for row in votes.values():
        assert row[OUTSIDE] == 0
        assert abs(row[OWNED]) <= 0.3 and abs(row[UNKNOWN]) < 2
        assert np.abs(row).max() <= 4.5  # no pixel decides alone
    for name in ("inside", "rim"):
        assert votes[name][RED] > 0 > votes[name][UNKNOWN] > votes[name][BODY] == votes[name][7]
    for name in ("ring", "ring_on_body"):  # one's own colour outside of an outline refutes it
        assert votes[name].argmin() == RED
    assert votes["ring"][7] >= 0 and votes["ring_on_body"][BODY] > 0 > votes["ring_on_body"][7]
    assert votes["body"][BODY] > 0 > votes["body"][RED] > votes["body"][7]


def test_a_body_of_unknown_colour_says_nothing():
    roles = VoteRoles()
    role = roles.body(0, RED)
    assert not roles.table[role].any()


def test_a_body_of_the_markers_own_colour_is_no_contradiction():
    roles = VoteRoles()
    body, ring = roles.body(RED, RED), roles.ring(RED, RED)
    assert roles.table[body, RED] > 0
    assert roles.table[ring, RED] < 0


def test_labels_are_not_copied_needlessly_nor_changed():
    labels = disc_image()
    field = LabelField(labels)
    assert field.labels is labels
    assert field.padded.size == (90 + 2) * (100 + 2)
    padded = cv2.copyMakeBorder(labels, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=OUTSIDE)
    np.testing.assert_array_equal(field.padded, padded.ravel())
