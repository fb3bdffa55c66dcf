import numpy as np
import pytest
from scene import Placed, capsule, disc, draw, flag, rectangle
from settings import settings

from artrec_ros.core.alignment.contour_map import ContourMap
from artrec_ros.core.alignment.matching import find_matches
from artrec_ros.core.alignment.placements import Placements, evidence, matched_share
from artrec_ros.core.alignment.refinement import refine, suppress
from artrec_ros.core.alignment.shapes import Shape
from artrec_ros.core.alignment.thinning_kernels import squared_pose_distance
from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.range_limits import scale_limits
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.contour_kernels import merge_boxes
from artrec_ros.core.model.marker import Marker

CONFIG = RecognizerConfig()
SIZE = (220, 180)


def blank_labels():
    return np.zeros(SIZE[::-1], np.uint8)


def find(labels, markers, config=CONFIG, wanted=None, blank=()):
    shapes = [Shape.from_marker(m) for m in markers]
    blobs = find_blobs(labels, {1, 2}, config, blank)
    cmap = ContourMap.build(blobs, labels.shape[::-1])
    wanted, scales = wanted or {(s, 1) for s in range(len(shapes))}, scale_limits(config, None)
    return find_matches(blobs, cmap, shapes, wanted, config, Deadline(), blank, scales)


def place(t, z):
    none = np.zeros(len(t), np.int32)
    return Placements.similarities(np.asarray(t, complex), np.asarray(z, complex), none, none, none)


def best_at(matches, truth, marker, shape=0):
    """The match nearest to truth: errors of place (px), angle (rad) and scale (share)."""
    mine = np.flatnonzero(matches.placed.shape == shape)
    off = np.abs(matches.placed.t[mine] - complex(truth.x, truth.y))
    n = mine[np.argmin(off)]
    z = matches.placed.z[n] * np.exp(1j * (marker.axis_angle - truth.theta)) / truth.scale
    return off.min(), abs(np.angle(z)), abs(abs(z) - 1), matches.evidence.share[n]


@pytest.mark.parametrize("seed", range(8))
def test_a_shape_is_found_where_it_was_drawn(seed):
    rng = np.random.default_rng(seed)
    truth = Placed(*rng.uniform(70, 110, 2), rng.uniform(-3, 3), rng.uniform(25, 60))
    labels = blank_labels()
    draw(labels, flag(), truth, 1)
    matches = find(labels, [flag()])
    place_px, angle, scale, share = best_at(matches, truth, flag())
    assert place_px < 0.3
    assert angle < 0.012
    assert scale < 0.015
    assert share > 0.95
    assert matches.placed.score[0] == matches.placed.score.max()


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_other_flank_is_another_shape(mirrored):
    labels = blank_labels()
    draw(labels, flag(mirrored=mirrored), Placed(100, 90, 0.7, 60), 1)
    matches = find(labels, [flag(), flag(mirrored=True)])
    right, wrong = (matches.evidence.share[matches.placed.shape == s].max(initial=0) for s in (mirrored, not mirrored))
    assert right > 0.95
    assert wrong < 0.8


def test_shapes_merged_in_one_blob_are_each_found():
    labels, bar = blank_labels(), rectangle("bar", 1.0, 0.22)
    truths = [Placed(80, 90, 0.3, 70), Placed(110, 105, 1.5, 70), Placed(130, 70, -0.4, 70)]
    for truth in truths:
        draw(labels, bar, truth, 1)
    assert len(find_blobs(labels, {1}, CONFIG)) == 1
    matches = find(labels, [bar])
    for truth in truths:
        assert best_at(matches, truth, bar)[0] < 1.5


def test_a_shape_split_by_an_occluder_is_found_once_and_whole():
    labels, bar = blank_labels(), rectangle("bar", 1.0, 0.25)
    truth = Placed(100, 90, 0.2, 120)
    draw(labels, bar, truth, 1)
    labels[:, 92:108] = 2  # a post in front of it
    assert len(find_blobs(labels, {1}, CONFIG)) == 2
    matches = find(labels, [bar])
    assert best_at(matches, truth, bar)[0] < 1.0
    assert best_at(matches, truth, bar)[2] < 0.02


def test_discs_are_found_alone_and_bitten():
    labels, sticker = blank_labels(), disc("sticker", 0.5)
    alone, bitten = Placed(60, 60, 0.0, 30), Placed(150, 100, 0.0, 40)
    for truth in (alone, bitten):
        draw(labels, sticker, truth, 1)
    labels[100:, 140:200] = np.where(np.arange(60) > 20, 2, labels[100:, 140:200])
    matches = find(labels, [sticker])
    for truth in (alone, bitten):
        place_px, _, scale, _ = best_at(matches, truth, sticker)
        assert place_px < 0.6
        assert scale < 0.04


def test_two_capsules_in_one_blob():
    labels, link = blank_labels(), capsule("link", 0.14, 1.0)
    upper, lower = Placed(60, 70, 0.2, 70), Placed(125, 87, 0.3, 70)
    for truth in (upper, lower):
        draw(labels, link, truth, 1)
    matches = find(labels, [link])
    for truth in (upper, lower):
        assert best_at(matches, truth, link)[0] < 3


def test_what_the_image_cuts_off_is_not_held_against_a_shape():
    labels = blank_labels()
    truth = Placed(20, 90, 0.0, 60)
    draw(labels, flag(), truth, 1)
    matches = find(labels, [flag()])
    place_px, _, _, share = best_at(matches, truth, flag())
    assert place_px < 1
    assert share > 0.9
    n = int(np.argmax(matches.placed.score))
    assert 0.6 < matches.evidence.visible[n] < 0.95
    assert matches.evidence.score[n] > 0.85


def test_blanked_rectangles_hide_like_the_border():
    labels = blank_labels()
    truth = Placed(60, 90, 0.0, 60)
    draw(labels, flag(), truth, 1)
    labels[:, :45] = 0
    blank = (0, 0, 45, SIZE[1])
    with_blank, without = (best_at(find(labels, [flag()], blank=b), truth, flag())[3] for b in (blank, ()))
    assert with_blank > 0.9 > without


@pytest.mark.uncompiled
def test_all_points_of_a_true_pose_match_and_none_of_a_far_one():
    labels = blank_labels()
    draw(labels, flag(), Placed(90, 90, 0.0, 50), 1)
    shapes = [Shape.from_marker(flag())]
    cmap = ContourMap.build(find_blobs(labels, {1}, CONFIG), SIZE)
    placed = place([90 + 90j, 90 + 90j, 5000 - 9000j], [50, 25, 50])
    share = matched_share(cmap, shapes, placed, 2.0, Deadline())
    assert share[0] == 1
    assert share[1] < 0.5
    assert share[2] == 0
    assert evidence(cmap, shapes, placed, CONFIG).share[0] > 0.98


def test_the_gap_between_two_blobs_is_no_shape():
    labels = blank_labels()
    labels[40:140, 40:90] = labels[40:140, 110:160] = 1
    shapes = [Shape.from_marker(rectangle("bar", 1.0, 0.2))]
    cmap = ContourMap.build(find_blobs(labels, {1}, CONFIG), SIZE)
    gap = place([99.5 + 89.5j], [100j])  # its long sides run along the blobs' edges, from outside
    assert matched_share(cmap, shapes, gap, 2.0, Deadline())[0] > 0.8
    assert evidence(cmap, shapes, gap, CONFIG).share[0] < 0.1


def test_each_class_has_contours_of_its_own():
    labels = blank_labels()
    draw(labels, rectangle("a", 1.0, 1.0), Placed(60, 90, 0.0, 40), 1)
    draw(labels, rectangle("a", 1.0, 1.0), Placed(150, 90, 0.0, 40), 2)
    matches = find(labels, [rectangle("a", 1.0, 1.0)], wanted={(0, 1), (0, 2)})
    for label, x in ((1, 60), (2, 150)):
        assert np.abs(matches.placed.t[matches.labels == label] - complex(x, 90)).max() < 15
    only = find(labels, [rectangle("a", 1.0, 1.0)], wanted={(0, 2)})
    assert set(only.labels) == {2}


def test_refinement_pulls_disturbed_poses_back():
    labels = blank_labels()
    draw(labels, flag(), Placed(90, 90, 0.4, 60), 1)
    shapes = [Shape.from_marker(flag())]
    cmap = ContourMap.build(find_blobs(labels, {1}, CONFIG), SIZE)
    z = 60 * np.exp(0.4j)
    rng = np.random.default_rng(0)
    t0 = 90 + 90j + rng.normal(0, 2, 30) + 1j * rng.normal(0, 2, 30)
    z0 = z * (1 + rng.normal(0, 0.06, 30)) * np.exp(1j * rng.normal(0, 0.06, 30))
    refined = refine(cmap, shapes, place(t0, z0), CONFIG, Deadline())
    assert np.median(np.abs(refined.t - (90 + 90j))) < 0.15
    assert np.median(np.abs(np.angle(refined.z / z))) < 0.006
    assert np.median(np.abs(np.abs(refined.z / z) - 1)) < 0.01


def test_refinement_that_changes_the_scale_too_much_is_undone():
    labels = blank_labels()
    draw(labels, flag(), Placed(90, 90, 0.0, 60), 1)
    cmap = ContourMap.build(find_blobs(labels, {1}, CONFIG), SIZE)
    start = place([91 + 90j], [56.0])
    free, bound = (
        refine(cmap, [Shape.from_marker(flag())], start, settings(max_refined_scale=m), Deadline()) for m in (1.4, 1.01)
    )
    assert abs(free.z[0]) == pytest.approx(60, rel=0.01)
    assert bound.z[0] == pytest.approx(56) and bound.t[0] == 91 + 90j


def test_refinement_leaves_hypotheses_far_from_any_contour():
    labels = blank_labels()
    draw(labels, flag(), Placed(90, 90, 0.4, 30), 1)
    cmap = ContourMap.build(find_blobs(labels, {1}, CONFIG), SIZE)
    far = place([1e4 + 1e4j], [30.0])
    refined = refine(cmap, [Shape.from_marker(flag())], far, CONFIG, Deadline())
    np.testing.assert_allclose(refined.t, far.t)
    np.testing.assert_allclose(np.abs(refined.z), 30)


def squeezed(marker, theta, cosine, direction):
    """The marker turned by theta in the image and then squeezed by `cosine` along a direction."""
    z = marker.image_outline @ np.array([1, 1j]) * np.exp(1j * (theta - marker.axis_angle - direction))
    z = (z.real * cosine + 1j * z.imag) * np.exp(1j * direction)
    return Marker("squeezed", np.stack([z.real, -z.imag], axis=1), np.zeros(2), np.array([1.0, 0.0]))


@pytest.mark.parametrize("seed", range(6))
def test_markers_turned_out_of_the_plane_are_found_with_their_true_scale(seed):
    rng = np.random.default_rng(seed)
    theta, direction = rng.uniform(-3, 3, 2)
    labels, slant = blank_labels(), np.radians(40)
    draw(labels, squeezed(flag(), theta, np.cos(slant), direction), Placed(100, 90, 0.0, 50), 1)
    shapes = [flag(), flag(mirrored=True)]
    flat, slanted = (find(labels, shapes, settings(max_slant_deg=deg)) for deg in (0.0, 55.0))
    best = int(np.argmax(slanted.placed.score))
    assert slanted.placed.shape[best] == 0
    assert slanted.placed.scale[best] == pytest.approx(50, rel=0.02)
    assert slanted.evidence.share[best] > 0.95 > flat.evidence.share.max()


def test_slant_is_bounded():
    labels = blank_labels()
    draw(labels, squeezed(flag(), 0.3, np.cos(np.radians(60)), 0.9), Placed(100, 90, 0.0, 60), 1)
    placed = find(labels, [flag()], settings(max_slant_deg=30, min_match=0.3)).placed
    squeeze = (np.abs(placed.z) - np.abs(placed.w)) / placed.scale
    assert squeeze.min() >= np.cos(np.radians(30)) - 1e-9


@pytest.mark.uncompiled
@pytest.mark.parametrize("order", [1, 2, 4])
def test_pose_distance_is_the_rms_over_the_outline(order):
    marker = {1: flag(), 2: rectangle("bar", 1.0, 0.4), 4: rectangle("square", 1.0, 1.0)}[order]
    shape = Shape.from_marker(marker)
    p = shape.points - shape.points.mean()
    t, z, z0 = 3 + 1j, 20 * np.exp(0.1j), 21.0 + 0j
    turns = np.exp(2j * np.pi * np.arange(order) / order)
    want = min(np.mean(np.abs(t + z * p - z0 * u * p) ** 2) for u in turns)
    radius = float(np.sqrt(np.mean(np.abs(p) ** 2)))
    assert squared_pose_distance(t, z * turns[-1], 0j, z0, radius, order, 1e9) == pytest.approx(want)
    assert squared_pose_distance(t, z, 0j, z0, radius, order, 5.0) == pytest.approx(10)  # of the places alone


@pytest.mark.uncompiled
def test_suppression_keeps_the_best_of_a_place_modulo_symmetry():
    shapes = [Shape.from_marker(rectangle("bar", 1.0, 0.4))]
    placed = place([0, 1, 0, 100], [50, 50, -50, 50]).replace(score=np.array([0.5, 0.9, 0.7, 0.1]))
    kept = suppress(placed, np.zeros(4, int), shapes, np.full(4, 9), CONFIG, 0.12)
    assert kept.tolist() == [1, 3]
    assert suppress(placed, np.zeros(4, int), shapes, np.full(4, 1), CONFIG, 0.12).tolist() == [1]


@pytest.mark.parametrize("scale", [30, 300])
def test_a_found_shape_explains_its_whole_contour_however_large_it_is(scale):
    labels = np.zeros((600, 800), np.uint8)
    draw(labels, flag(), Placed(400, 300, 0.4, scale), 1)
    matches = find(labels, [flag()])
    assert len(matches.explained(0)) > 0.95 * (len(matches.cmap.points) - 1)


@pytest.mark.uncompiled
def test_what_lies_between_points_that_match_is_explained_unless_it_is_long():
    labels = np.zeros((60, 90), np.uint8)
    labels[10:30, 10:50] = labels[40:50, 10:50] = 3
    blobs = find_blobs(labels, [3], CONFIG)
    cmap = ContourMap.build(blobs, labels.shape[::-1])
    count, both = len(blobs[0].pixels), len(cmap.points) - 1
    assert cmap.stretches(np.array([3, 7, -1, 9, 30]), 5).tolist() == [3, 4, 5, 6, 7, 9, 30]
    assert cmap.stretches(np.array([count - 2, 1]), 5).tolist() == [0, 1, count - 2, count - 1]  # round the end
    assert cmap.stretches(np.array([count - 1, count]), 5).tolist() == [count - 1, count]  # not into another blob
    assert cmap.stretches(np.arange(both), 5).tolist() == list(range(both))


@pytest.mark.parametrize("gap", [10, 200])
def test_the_map_tells_the_nearest_contour_point_wherever_blobs_lie(gap):
    labels = np.zeros((90, 100 + gap), np.uint8)
    labels[30:50, 20:40] = labels[35:60, 40 + gap : 60 + gap] = 1
    blobs = find_blobs(labels, {1}, CONFIG)
    cmap = ContourMap.build(blobs, labels.shape[::-1])
    pixels = np.concatenate([b.pixels for b in blobs]) @ np.array([1, 1j])
    rows, columns = np.indices(cmap.distance.shape)
    where = (columns + 1j * rows + complex(*cmap.origin)).ravel()
    true = np.abs(where[:, None] - pixels).min(axis=1)
    near = true < 12
    index = cmap.nearest.ravel()
    np.testing.assert_allclose(np.abs(where - pixels[index.clip(max=len(pixels) - 1)])[near], true[near], atol=0.2)
    read = cmap.distance.ravel() / 15
    np.testing.assert_allclose(read[near], true[near], atol=0.4)
    assert (read[~near] > 11).all()


@pytest.mark.uncompiled
def test_boxes_that_overlap_are_merged_until_none_does():
    boxes = np.array([[0, 0, 10, 10], [30, 0, 40, 10], [8, 8, 31, 9], [50, 50, 60, 60], [60, 50, 70, 60]])
    merged = {tuple(b) for b in merge_boxes(boxes).tolist()}
    assert merged == {(0, 0, 40, 10), (50, 50, 60, 60), (60, 50, 70, 60)}
