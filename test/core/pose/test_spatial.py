"""Hypotheses of a spatial object: what hides what, where contours land, and what the labels say."""

from itertools import product

import numpy as np
import pytest
from settings import DEFAULTS
from solids import (
    BACKGROUND,
    BENT,
    BODY,
    RED,
    RIGHT_SIDE,
    camera_of,
    chain,
    contour_pixels,
    facing,
    frames_of,
    jolted,
    marker,
    pose,
    random_poses,
    render,
    sign,
    truck,
)

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.pixel_kernels import outline_pixels
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.image.codes import OWNED, UNKNOWN
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.surface import contains
from artrec_ros.core.pose.pose_fit import contour_fit
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel

CAMERA = camera_of((160, 120), 150.0)
FAR = 1.2  # where all of a marker is seen in one size
INSIDE, RIM, RING = DEFAULTS.votes.inside, DEFAULTS.votes.rim, DEFAULTS.votes.ring


def judged(surface, labels, poses, camera=CAMERA, occlusion=True, patches=None):
    patches = np.arange(len(surface.patches)) if patches is None else patches
    return surface.score(ImageFrame(LabelField(labels), camera), poses, patches, occlusion=occlusion)


def test_hypotheses_are_picked_and_joined():
    poses = random_poses(np.random.default_rng(0), chain(), 5)
    assert len(poses) == 5 and len(poses[[1, 3]]) == 2 and len(poses[poses.t[:, 2] < 0]) == 0
    again = Poses.concatenate([poses[[0]], poses[[1, 2]], poses[np.arange(3, 5)]])
    for name in ("R", "t", "q"):
        np.testing.assert_array_equal(getattr(again, name), getattr(poses, name))


@pytest.mark.uncompiled
@pytest.mark.parametrize(("depth", "slant"), [(1.0, 0.0), (0.25, 1.1), (0.2, -1.2)])
def test_a_marker_stands_for_the_pixels_that_it_fills(depth, slant):
    """Near ones under slant, too, whose far half is small in the image."""
    camera, surface = camera_of(), SpatialModel(sign(), RED, DEFAULTS.votes)
    at = pose(0.0, 0.0, depth, slant, 0.3)
    labels = render(camera, [(sign(), at, RED)])
    scores = judged(surface, labels, at, camera)
    assert scores.area_px[0, 0] == pytest.approx(np.sum(labels == RED), rel=0.12)
    half = labels.copy()
    half[:, 165:] = BACKGROUND  # the marker's far side, or its near one
    share = np.sum(half == RED) / np.sum(labels == RED)
    assert judged(surface, half, at, camera).agree[0, 0] == pytest.approx(share, abs=0.12)


@pytest.mark.uncompiled
def test_of_a_large_marker_small_shares_are_told_apart():
    """Else a climb finds poses that reach beyond their blob between the points: 36 of them err by .038 here."""
    camera, model, slant = camera_of(), sign(), (0.25, 0.4, 0.3)
    surface, labels = SpatialModel(model, RED, DEFAULTS.votes), render(camera, [(model, pose(0, 0, *slant), RED)])
    off = []
    for x, y in product(np.linspace(-0.03, 0.03, 13), np.linspace(-0.02, 0.02, 5)):
        at = pose(x, y, *slant)
        share = np.mean(labels[render(camera, [(model, at, RED)]) == RED] == RED)
        off.append(judged(surface, labels, at, camera).agree[0, 0] - share)
    assert np.mean(np.abs(off)) < 0.02 and np.max(np.abs(off)) < 0.06


def test_what_the_border_cuts_off_a_near_marker_does_not_outweigh_the_rest():
    camera, surface = camera_of(), SpatialModel(sign(), RED, DEFAULTS.votes)
    at = pose(0.1, 0.0, 0.25, -1.0, 0.0)
    scores = judged(surface, render(camera, [(sign(), at, RED)]), at, camera)
    inside = project(camera, np.concatenate([p.inside for p in surface.patches]) @ at.R[0].T + at.t[0])[:, 0] < 319.5
    assert 0.3 < inside.mean() < 0.8
    assert scores.agree[0, 0] >= inside.mean() - 0.15


@pytest.mark.parametrize("background", [UNKNOWN, BACKGROUND])
def test_where_nothing_is_known_there_is_no_marker(background):
    """A mask without a background is to be read as one with one."""
    camera, surface = camera_of(), SpatialModel(sign(), RED, DEFAULTS.votes)
    small, large = pose(0.0, 0.0, 1.2), pose(0.0, 0.0, 0.6)
    labels = render(camera, [(sign(), small, RED)], background)
    votes = judged(surface, labels, Poses.concatenate([small, large]), camera).votes[:, 0]
    assert votes[0] > 0 > votes[1]


def normals_of(surface, camera, poses):
    """(H, M, m, 2) outward normals of all contours in the image."""
    frame = ImageFrame(LabelField(np.zeros(camera.size[::-1], np.uint8)), camera)
    return contour_fit(surface, frame, poses, np.ones((len(poses), len(surface.markers)), bool), 2, DEFAULTS.fit).normal


@pytest.mark.parametrize("lens", [(), BENT], ids=len)
def test_normals_point_out_of_the_projected_outline(lens):
    camera = camera_of(distortion=lens)
    model = truck()
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    rng = np.random.default_rng(3)
    at = jolted(rng, pose(0, 0, 0.9, model=model), 5, 0.05, 0.3, 0.3)
    frames, normals = frames_of(surface, at), normals_of(surface, camera, at)
    pixels = contour_pixels(surface, camera, at)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0)
    cosine, compared = facing(surface, frames, surface.markers), 0
    for h, k in np.argwhere(cosine > 0.2).tolist():
        patch = surface.patches[surface.markers[k]]
        dense = np.linspace(patch.marker.outline, np.roll(patch.marker.outline, -1, axis=0), 20, endpoint=False)
        dense = np.pad(dense.transpose(1, 0, 2).reshape(-1, 2), ((0, 0), (0, 1)))
        T, c = patch.marker.T_component_marker, patch.component
        outline = project(camera, T.apply(dense) @ frames.R[h, c].T + frames.t[h, c])
        assert contains(outline, pixels[h, k] - 0.3 * normals[h, k]).all()
        assert not contains(outline, pixels[h, k] + 0.3 * normals[h, k]).any()
        compared += 1
    assert compared > 5


@pytest.mark.uncompiled
@pytest.mark.parametrize("slant", [0.0, 0.6, 1.2, 1.35])
def test_a_disc_under_slant_has_an_ellipses_normals(slant):
    """A disc's conic C, seen through x = H X, is H^-T C H^-1; its normal at x is the direction of that times x."""
    radius, camera = 0.05, camera_of()
    ring = np.arange(2880) * np.pi / 1440
    disc = marker("face", radius * np.column_stack([np.cos(ring), np.sin(ring)]), RIGHT_SIDE, (0, 0, 0))
    model = ObjectModel("disc", (Component("plate", (disc,), required=True),))
    surface, at = SpatialModel(model, RED, DEFAULTS.votes), pose(0.1, -0.06, 0.5, slant, 0.4, model)
    plane = at.R[0] @ RIGHT_SIDE
    homography = camera.matrix @ np.column_stack([plane[:, :2], at.t[0]])
    inverse = np.linalg.inv(homography)
    conic = inverse.T @ np.diag([1.0, 1.0, -(radius**2)]) @ inverse
    points = np.insert(contour_pixels(surface, camera, at)[0, 0], 2, 1.0, axis=1)
    expected = (points @ conic)[:, :2]
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    expected *= np.sign(np.sum(expected * (points[:, :2] - points[:, :2].mean(axis=0)), axis=1))[:, None]
    np.testing.assert_allclose(normals_of(surface, camera, at)[0, 0], expected, atol=0.02)  # of 2880 sides


@pytest.mark.uncompiled
@pytest.mark.parametrize("slant", [0.3, -0.9, 1.3])
def test_normals_are_perpendicular_to_the_sides_in_the_image(slant):
    camera, surface = camera_of(), SpatialModel(sign(), RED, DEFAULTS.votes)
    at = pose(0.05, 0.02, 0.6, slant, 0.2)
    room = np.empty((4, surface.contour.shape[1]))
    view = ImageFrame(LabelField(np.zeros((240, 320), np.uint8)), camera).view
    compiled = surface.compiled
    outline_pixels(at.R[0], at.t[0], compiled.contour[0], compiled.contour_along[0], view, room)
    np.testing.assert_allclose(room[:2].T, contour_pixels(surface, camera, at)[0, 0], atol=1e-9)
    np.testing.assert_allclose(room[2:].T, normals_of(surface, camera, at)[0, 0], atol=1e-12)
    corners = surface.patches[0].drawn[3:]
    corners = project(camera, corners @ at.R[0].T + at.t[0])
    sides = np.roll(corners, -1, axis=0) - corners
    off = room[:2].T[:, None] - corners  # (m, n, 2)
    length = np.linalg.norm(sides, axis=1)
    across = np.abs(off[..., 0] * sides[:, 1] - off[..., 1] * sides[:, 0]) / length
    share = np.sum(off * sides, axis=2) / length**2
    on = np.where((share >= -1e-9) & (share <= 1 + 1e-9), across, np.inf).argmin(axis=1)
    np.testing.assert_allclose(np.sum(room[2:].T * sides[on], axis=1) / length[on], 0.0, atol=1e-9)


@pytest.mark.uncompiled
@pytest.mark.parametrize("label", [RED, BODY, 0, OWNED])
def test_an_image_of_one_class_says_the_same_everywhere(label):
    """Votes are pixels times what a label says inside, and the contour's length times what it says on either side."""
    model = sign()
    surface, at = SpatialModel(model, RED, DEFAULTS.votes), pose(0, 0, FAR, 0.7, model=model)
    scores = judged(surface, np.full((120, 160), label, np.uint8), at)
    normal, centre = at.R[0] @ surface.normal[0], at.R[0] @ surface.centre[0] + at.t[0]
    cosine, f2 = -normal @ centre / np.linalg.norm(centre), CAMERA.matrix[0, 0] * CAMERA.matrix[1, 1]
    area_px = surface.area[0] * f2 / centre[2] ** 2 * cosine
    if label == OWNED:  # hidden: nothing is seen of it, and it says nothing
        assert scores.area_px[0, 0] == scores.agree[0, 0] == scores.votes[0, 0] == 0
        return
    assert scores.area_px[0, 0] == pytest.approx(area_px)
    assert scores.agree[0, 0] == (label == RED)
    votes = {RED: (INSIDE[0], RIM[0] + RING[0]), BODY: (INSIDE[2], RIM[2] + RING[2])}
    votes |= {0: (DEFAULTS.votes.inside_empty, RIM[1] + RING[1])}  # all of it is unknown
    ring_px = surface.perimeter[0] * (1 + cosine) / 2 * np.sqrt(f2) / centre[2] * DEFAULTS.votes.ring_width_px
    inside, ring = votes[label]
    if label == RED:  # amid its class a marker is not told by what lies inside
        inside = 0.0
    assert scores.votes[0, 0] == pytest.approx(inside * area_px + ring * ring_px, rel=1e-6)


@pytest.mark.uncompiled
def test_of_two_classes_each_has_the_share_of_points_that_lie_on_it():
    model = sign()
    surface, at = SpatialModel(model, RED, DEFAULTS.votes), pose(0.01, 0, FAR, 0.7, model=model)
    labels = np.full((120, 160), RED, np.uint8)
    labels[:, 80:] = BODY
    inside = project(CAMERA, np.concatenate([p.inside for p in surface.patches]) @ at.R[0].T + at.t[0])[:, 0]
    share = np.mean(inside < 79.5)
    assert 0.2 < share < 0.8
    assert judged(surface, labels, at).agree[0, 0] == pytest.approx(share)


@pytest.mark.uncompiled
@pytest.mark.parametrize("make", [chain, truck], ids=lambda m: m.__name__)
def test_each_joint_is_found_at_the_value_of_its_grid_that_the_labels_like_best(make):
    model = make()
    surface, rng = SpatialModel(model, RED, DEFAULTS.votes), np.random.default_rng(4)
    coarse = rng.choice([0, RED, BODY, 1], (12, 16)).astype(np.uint8)
    kin, labels = surface.kinematics, np.kron(coarse, np.ones((10, 10), np.uint8))
    frame = ImageFrame(LabelField(labels), CAMERA)
    poses = random_poses(rng, model, 3)
    found = surface.search_joints(frame, poses, surface.kinematics.grids(0.4))
    for h in range(len(poses)):
        best = poses[[h]]
        for c, j in enumerate(kin.joint_of):
            if j >= 0:
                grid, mine = kin.grid(j, 0.4), np.flatnonzero(surface.component == c)
                tried = best[np.zeros(len(grid), int)]
                tried.q[:, j] = grid
                votes = surface.score(frame, tried, mine, occlusion=False).votes.sum(axis=1)
                best = tried[[int(votes.argmax())]]
                assert votes[np.flatnonzero(grid == found.q[h, j])[0]] == pytest.approx(votes.max(), abs=1e-6)
                best.q[0, j] = found.q[h, j]
    assert len(np.unique(found.q)) > 1 and np.array_equal(found.t, poses.t)


def test_joints_left_at_the_deadline_stay():
    surface = SpatialModel(truck(), RED, DEFAULTS.votes)
    poses = random_poses(np.random.default_rng(4), truck(), 5)
    late = ImageFrame(LabelField(np.zeros((120, 160), np.uint8)), CAMERA, Deadline(0.0))
    found = surface.search_joints(late, poses, surface.kinematics.grids(0.4))
    np.testing.assert_array_equal(found.q, poses.q)


@pytest.mark.parametrize("bodies", [True, False])
def test_the_truth_gets_more_votes_than_what_is_near_it(bodies):
    model = truck(bodies)
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    truth = pose(0, 0, 0.9, 0.4, model=model, joints={"fore": 0.4, "hind": -0.3})
    labels = render(CAMERA, [(model, truth, RED)])
    rng = np.random.default_rng(4)
    off = jolted(rng, truth, 60, 0.05, 0.25, 0.3)
    far = Poses(truth.R, truth.t + (3.0, 0, 0), truth.q)
    votes = judged(surface, labels, Poses.concatenate([truth, off, far])).votes.sum(axis=1)
    assert votes[0] > 0
    assert np.mean(votes[1:-1] < votes[0]) > 0.95
    assert votes[-1] == 0  # beyond the border: nothing for, nothing against


def test_what_is_measured_of_a_marker_in_full_view():
    model = sign()
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    truth = pose(0.02, 0.01, 0.5, 0.5, 0.3)
    labels = render(CAMERA, [(model, truth, RED)])
    scores = judged(surface, labels, truth)
    assert scores.area_px[0, 0] == pytest.approx(np.count_nonzero(labels == RED), rel=0.05)
    assert scores.agree[0, 0] > 0.95
    away = Poses(truth.R @ np.diag([-1.0, -1.0, 1.0]), truth.t, truth.q)
    behind = Poses(truth.R, truth.t * (1, 1, -1), truth.q)
    for unseen in (away, behind):
        scores = judged(surface, labels, unseen)
        assert scores.votes[0, 0] == scores.area_px[0, 0] == scores.agree[0, 0] == 0


def test_a_marker_behind_another_part_is_not_judged():
    model = truck()
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    labels = np.full((120, 160), BODY, np.uint8)
    leg = next(i for i in surface.markers if surface.patches[i].marker.name == "outer_left")
    turned = pose(0, 0, 0.9, 0.0, model=model, joints={"fore": 0.3})
    assert judged(surface, labels, turned).area_px[0, leg] == 0
    for heading in np.linspace(0, 6, 13):
        at = pose(0, 0, 0.9, heading, model=model)
        shown, all_of_it = (judged(surface, labels, at, occlusion=o).area_px for o in (True, False))
        assert (shown <= all_of_it + 1e-9).all()


def test_no_hypotheses_give_no_scores():
    surface = SpatialModel(truck(), RED, DEFAULTS.votes)
    none = pose(model=truck())[np.zeros(0, int)]
    scores = judged(surface, np.ones((120, 160), np.uint8), none)
    assert scores.votes.shape == scores.area_px.shape == (0, len(surface.patches))
    frame = ImageFrame(LabelField(np.ones((120, 160), np.uint8)), CAMERA)
    assert surface.search_joints(frame, none, surface.kinematics.grids(0.2)).q.shape == none.q.shape


def test_patches_scores_do_not_depend_on_which_others_are_asked_for():
    model = truck()
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    truth = pose(0, 0, 0.9, 0.4, model=model)
    labels = render(CAMERA, [(model, truth, RED)])
    whole = judged(surface, labels, truth)
    for some in (surface.markers, np.array([0, 4, 9]), np.flatnonzero(~surface.is_marker)):
        np.testing.assert_allclose(judged(surface, labels, truth, patches=some).votes, whole.votes[:, some])
