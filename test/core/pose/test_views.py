"""Views of flat markers: outlines, anchors, alignment with blobs, and the two turns in space that each stands for."""

import cv2
import numpy as np
import pytest
from scene import apply_similarity, disc
from scene import flag as flat_flag
from settings import DEFAULTS
from solids import BENT, CAB, RED, RIGHT_SIDE, camera_of, marker, sign

from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import rotation_from_rotvec
from artrec_ros.core.image.codes import LABELS
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.pose.view_bank import BlobShape, ViewBank
from artrec_ros.core.pose.views import anchors_of, blob_couples, flips_of, lift, long_axis, moments_of, view_bank
from artrec_ros.core.pose.votes import VoteRoles

FLAG = marker("flag", CAB, RIGHT_SIDE, (0, 0, 0))


def shoelace(points):
    x, y = points.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)


def filled(outline, size=(200, 160)):
    """(H, W) labels: RED inside of a polygon in pixels, 1 outside of it."""
    labels = np.ones(size[::-1], np.uint8)
    cv2.fillPoly(labels, [np.rint(outline * 16).astype(np.int32)], RED, shift=4)
    return labels


@pytest.mark.parametrize("shape", [FLAG, flat_flag(), flat_flag(mirrored=True), disc("disc", 0.05)])
def test_a_view_is_the_outline_squeezed_along_one_direction(shape):
    bank = view_bank(shape, DEFAULTS.guesses)
    assert bank[0].turn == 0
    assert shoelace(bank[0].outline) == pytest.approx(shape.area)
    for view in bank:
        assert shoelace(view.outline) == pytest.approx(view.area)  # and runs the way blobs' contours do
        assert view.area == pytest.approx(shape.area * np.cos(view.turn))
        along = np.array([np.cos(view.direction), np.sin(view.direction)])
        for direction, factor in ((along, np.cos(view.turn)), (along[::-1] * (-1, 1), 1.0)):
            assert np.ptp(view.outline @ direction) == pytest.approx(np.ptp(shape.image_outline @ direction) * factor)
        np.testing.assert_allclose(np.linalg.norm(view.contour_normal, axis=1), 1.0)
        edges = np.linalg.norm(np.roll(view.outline, -1, axis=0) - view.outline, axis=1)
        assert view.perimeter == pytest.approx(edges.sum())


def test_no_two_views_of_a_bank_are_the_same_and_a_disc_needs_fewer():
    keys = {np.round(v.outline, 9).tobytes() for v in view_bank(FLAG, DEFAULTS.guesses)}
    assert len(keys) == len(view_bank(FLAG, DEFAULTS.guesses))
    assert 1 < len(view_bank(disc("disc", 0.05), DEFAULTS.guesses)) < len(keys)


@pytest.mark.parametrize("size", [1e-3, 1.0, 50.0])
def test_anchors_are_the_corners_whatever_the_size(size):
    anchors = anchors_of(FLAG.image_outline * size, 0.02)
    assert len(anchors) == len(CAB)
    distance = np.linalg.norm(anchors[:, None] - FLAG.image_outline * size, axis=2).min(axis=1)
    assert distance.max() < 1e-3 * size
    assert 6 <= len(anchors_of(disc("disc", 0.05).image_outline * size, 0.02)) <= 24


def test_couples_join_each_anchor_with_the_next_and_the_one_after():
    square = np.array([(0, 0), (20, 0), (20, 20), (0, 20)], float)
    first, second = blob_couples(square, (1.0,))
    assert len(first) == len(second) == 8
    apart = np.linalg.norm(first - second, axis=1)
    np.testing.assert_allclose(np.sort(apart), [20] * 4 + [20 * np.sqrt(2)] * 4)
    assert len(blob_couples(square, (1.0, 2.0))[0]) == 8  # those of both tolerances once
    speck = np.array([(3.0, 3.0)])
    assert [len(c) for c in blob_couples(speck, (1.0,))] == [0, 0]


def shape_of(contour, couples=True, area_px=None):
    """A blob's shape from its exact outline."""
    none = np.zeros((0, 2)), np.zeros((0, 2))
    area = shoelace(contour) if area_px is None else area_px
    return BlobShape(area, blob_couples(contour, (1.0, 2.0)) if couples else none, moments_of(contour))


def aligned(views, labels, shape, most=1_000):
    roles = VoteRoles(DEFAULTS.votes, LABELS)
    inside, ring = roles.inside((RED,)), roles.ring((RED,), ())
    limits = SpatialModel(sign(), RED, DEFAULTS.votes).limits
    bank = ViewBank(views, roles.table[inside], roles.table[ring], limits, DEFAULTS.guesses)
    return bank.align(ImageFrame(LabelField(labels), camera_of((200, 160))), shape, most)


def far_between(view, T, contour):
    """(H,) greatest distance of a placed outline from a contour, corner by corner."""
    return np.linalg.norm(apply_similarity(T, view.outline) - contour, axis=2).max(axis=1)


@pytest.mark.uncompiled
@pytest.mark.parametrize("number", [0, 3, 12, -1])
def test_the_best_alignment_of_a_view_with_its_own_blob_is_the_truth(number):
    view = view_bank(FLAG, DEFAULTS.guesses)[number]
    contour = apply_similarity(np.array([[90.0, 70.0, 0.7, 450.0]]), view.outline)[0]
    T, votes, of = aligned([view], filled(contour), shape_of(contour))
    assert far_between(view, T[:1], contour)[0] < 1.5
    assert (np.diff(votes) <= 0).all() and (votes >= 0.5 * votes[0]).all() and not of.any()


@pytest.mark.uncompiled
def test_of_all_views_the_blobs_own_has_most_votes():
    bank = view_bank(FLAG, DEFAULTS.guesses)
    contour = apply_similarity(np.array([[90.0, 70.0, 0.7, 900.0]]), bank[12].outline)[0]
    T, votes, of = aligned(bank, filled(contour), shape_of(contour), 40)
    assert len(T) == len(votes) == len(of) == 40 and len(set(of.tolist())) > 1
    assert of[0] == 12 and far_between(bank[12], T[:1], contour)[0] < 1.5


@pytest.mark.uncompiled
def test_alignments_far_too_small_or_large_for_the_blob_are_left_out():
    view = view_bank(FLAG, DEFAULTS.guesses)[0]
    contour = apply_similarity(np.array([[90.0, 70.0, 0.0, 450.0]]), view.outline)[0]
    T, _, _ = aligned([view], filled(contour), shape_of(contour))
    seen = view.area * T[:, 3] ** 2
    assert len(T) and seen.min() > DEFAULTS.guesses.least_area_px and seen.max() < 2 * shoelace(contour)
    assert not len(aligned([view], filled(contour), shape_of(contour, area_px=1.0))[0])


@pytest.mark.uncompiled
def test_a_blob_without_couples_is_aligned_by_its_moments():
    view = view_bank(FLAG, DEFAULTS.guesses)[0]
    contour = apply_similarity(np.array([[60.0, 50.0, -0.4, 500.0]]), view.outline)[0]
    T, _, _ = aligned([view], filled(contour), shape_of(contour, couples=False))
    assert 1 <= len(T) <= 4 and far_between(view, T[:1], contour)[0] < 0.5
    np.testing.assert_allclose(T[:, 3], 500.0, rtol=1e-6)


@pytest.mark.uncompiled
@pytest.mark.parametrize("label, inside, ring", [(RED, 4.0, -4.0), (1, -3.5, 0.3), (0, -0.3, 0.0)])
def test_a_similaritys_votes_are_areas_times_what_the_labels_say(label, inside, ring):
    """In an image of one class."""
    view, k = view_bank(FLAG, DEFAULTS.guesses)[7], 500.0
    contour = apply_similarity(np.array([[100.0, 80.0, 0.3, k]]), view.outline)[0]
    _, votes, _ = aligned([view], np.full((160, 200), label, np.uint8), shape_of(contour, couples=False))
    expected = inside * view.area * k**2 + ring * view.perimeter * k * 1.5
    assert len(votes) == (4 if expected > 0 else 0)
    np.testing.assert_allclose(votes, expected, rtol=1e-6)


@pytest.mark.parametrize("lens", [(), BENT], ids=len)
def test_both_lifted_poses_look_like_the_view(lens):
    camera = camera_of(distortion=lens)
    rng = np.random.default_rng(1)
    bank = view_bank(FLAG, DEFAULTS.guesses)
    n = len(bank)
    T = np.column_stack([rng.uniform(60, 260, n), rng.uniform(50, 190, n), rng.uniform(-3, 3, n), np.full(n, 60.0)])
    flips = flips_of(np.array([v.turn for v in bank]), np.array([v.direction for v in bank]))
    R, t = lift(flips, np.arange(n), T, camera, np.zeros(3))
    assert R.shape == (2 * n, 3, 3) and t.shape == (2 * n, 3)
    np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.tile(np.eye(3), (2 * n, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1.0)
    flat = np.pad(FLAG.outline - FLAG.centroid, ((0, 0), (0, 1)))
    for i, view in enumerate(bank):
        seen = apply_similarity(T[[i]], view.outline)[0]
        for flip in (i, n + i):
            assert R[flip][:, 2] @ t[flip] < 0  # its face is turned to the camera
            np.testing.assert_allclose(project(camera, t[flip]), T[i, :2], atol=0.1)
            pixels = project(camera, flat @ R[flip].T + t[flip])
            # 12 px long and 5 m away: perspective and the lens bend this by no more
            apart = np.linalg.norm(pixels[:, None] - seen, axis=2).min(axis=1)
            assert apart.max() < (1.0 if lens else 0.6)
        turned = np.arccos(np.clip(-R[i][:, 2] @ t[i] / np.linalg.norm(t[i]), -1, 1))
        assert turned == pytest.approx(view.turn, abs=0.02)


def test_any_frame_fixed_to_a_marker_is_lifted():
    rng, bank = np.random.default_rng(2), view_bank(FLAG, DEFAULTS.guesses)
    flips = flips_of(np.array([v.turn for v in bank]), np.array([v.direction for v in bank]))
    view, T = rng.integers(0, len(bank), 30), rng.uniform((0, 0, -3, 30), (320, 240, 3, 400), (30, 4))
    R_marker, t_marker = lift(flips, view, T, camera_of(), np.zeros(3))
    R_in, t_in = rotation_from_rotvec([0.3, -0.8, 1.1]), np.array([0.02, -0.1, 0.05])  # of the frame in the marker's
    R, t = lift(flips @ R_in, view, T, camera_of(), R_in.T @ t_in)
    np.testing.assert_allclose(R, R_marker @ R_in, atol=1e-12)
    np.testing.assert_allclose(t, t_marker + R_marker @ t_in, atol=1e-12)


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.5, 3.0])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 300.0])
def test_a_rectangle_s_long_axis_ends_where_it_does(turn, scale):
    way = np.array([np.cos(turn), np.sin(turn)])
    across = np.array([-way[1], way[0]])
    outline = scale * (np.array([5.0, 7.0]) + [a * 2.0 * way + b * 0.5 * across for a, b in
                                               ((-1, -1), (1, -1), (1, 1), (-1, 1))])  # fmt: skip
    axis = long_axis(outline)
    assert np.abs(axis.half @ way) == pytest.approx(2.0 * scale, rel=1e-4)
    assert np.abs(axis.half @ across) < 1e-3 * scale
    assert axis.ratio == pytest.approx(4.0, rel=1e-3)
