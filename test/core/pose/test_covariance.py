"""What a covariance promises, held against truth: of 90 % regions about 90 % hold it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.stats import chi2
from settings import DEFAULTS
from solids import (
    BACKGROUND,
    BODY,
    CAB,
    RED,
    RIGHT_SIDE,
    camera_of,
    facing,
    jolted,
    marker,
    plate,
    pose,
    rectangle,
    render,
    sign,
    slide,
    truck,
)  # fmt: skip

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.codes import UNKNOWN
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.surface import INSIDE_POINTS
from artrec_ros.core.pose.covariance import pose_covariances, sources
from artrec_ros.core.pose.pose_fit import fit_poses
from artrec_ros.core.pose.surface_model import SpatialModel

CAMERA, KNOWN = camera_of(), DEFAULTS.covariance
REACH = (8, 6, 4, 3, 3, 2, 2)
MODELS = {"truck": truck(), "sign": sign(), "slide": slide()}


def cells(labels, size):
    """Labels of every `size`-th pixel, each for a cell of pixels around it."""
    rows, columns = (np.arange(n) // size * size + size // 2 for n in labels.shape)
    return labels[np.minimum(rows, len(labels) - 1)][:, np.minimum(columns, labels.shape[1] - 1)]


def torn(labels, rng):
    """Labels a pixel off this way or that, and neighbours together: their borders are ragged."""
    rows, columns = np.indices(labels.shape, np.float32)
    off = [cv2.GaussianBlur(rng.normal(size=labels.shape).astype(np.float32), (0, 0), 3.0) for _ in range(2)]
    rows, columns = rows + off[0] / off[0].std(), columns + off[1] / off[1].std()
    return cv2.remap(labels, columns, rows, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)


def scene(model, truth, camera=CAMERA, seam=False, rng=None, cell=1, spoil=None):
    """Surface, labels and the markers in view; with `seam`, pixels between two classes are mostly unknown.

    :param spoil: what becomes of labels by `rng`.
    """
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    labels = cells(render(camera, [(model, truth, RED)]), cell)
    labels = spoil(labels, rng) if spoil else labels
    if seam:
        mixed = np.zeros(labels.shape, bool)
        for axis in (0, 1):
            for step in (-1, 1):
                mixed |= np.roll(labels, step, axis) != labels
        labels = np.where(mixed & (rng.random(labels.shape) < 0.7), UNKNOWN, labels).astype(np.uint8)
    frames = surface.kinematics.forward(truth.R, truth.t, truth.q)
    amid = np.median(surface.shown(frames, surface.markers, INSIDE_POINTS), axis=2) > 0.5
    return surface, ImageFrame(LabelField(labels), camera), (facing(surface, frames, surface.markers) > 0.2) & amid


def rotation_error(R, truth):
    """Rotation vector that takes `truth` to `R`, along the camera's axes."""
    D = R @ truth.T
    axis = np.array([D[2, 1] - D[1, 2], D[0, 2] - D[2, 0], D[1, 0] - D[0, 1]])
    angle = np.arccos(np.clip((np.trace(D) - 1) / 2, -1, 1))
    return axis / 2 * (1.0 if angle < 1e-6 else angle / np.sin(angle))


def fits(name, count, seam=False, seed=0, cell=1, config=DEFAULTS, spoil=None):
    """Errors (n, 6+J) and covariances (n, 6+J, 6+J) of fits that begun near the truth."""
    model, rng = MODELS[name], np.random.default_rng(seed)
    errors, covariances = [], []
    while len(errors) < count:
        names = {c.name: rng.uniform(0.5 * c.joint.lower, 0.5 * c.joint.upper) for c in model.joint_components}
        truth = pose(*rng.uniform(-0.15, 0.15, 2), rng.uniform(0.6, 1.6), rng.uniform(-0.9, 0.9), 0.1, model, names)
        surface, frame, use = scene(model, truth, seam=seam, rng=rng, cell=cell, spoil=spoil)
        start = jolted(rng, truth, 1, 0.01, 0.05, 0.05)
        fit = fit_poses(surface, frame, start, use, REACH, DEFAULTS.fit)
        error = np.r_[fit.t[0] - truth.t[0], rotation_error(fit.R[0], truth.R[0]), fit.q[0] - truth.q[0]]
        if np.linalg.norm(error[3:]) > 0.4:
            continue  # the mirrored turn: no covariance tells of that
        errors.append(error)
        covariances.append(pose_covariances(surface, frame, fit, use, config)[0])
    return np.array(errors), np.array(covariances)


def shares(errors, covariances, part):
    """Shares of truths within 50 % and 90 % regions."""
    e, C = errors[:, part], covariances[:, part, part]
    distance = np.sum(e * np.linalg.solve(C, e[..., None])[..., 0], axis=1)
    return [float((distance < chi2.ppf(p, e.shape[1])).mean()) for p in (0.5, 0.9)]


@pytest.mark.parametrize("name, seam", [("truck", False), ("truck", True), ("sign", True), ("slide", False)], ids=str)
def test_regions_hold_the_truth_as_often_as_they_say(name, seam):
    """Or somewhat more often: nothing is half hidden here, and nothing merged."""
    errors, covariances = fits(name, 40, seam)
    for part in (slice(0, 3), slice(3, 6), slice(0, 6)):
        half, most = shares(errors, covariances, part)
        assert half > 0.4 and most > 0.8
        e, C = errors[:, part], covariances[:, part, part]
        assert 0.15 < np.mean(e * np.linalg.solve(C, e[..., None])[..., 0]) < 1.3  # 1: exactly as they say


def known_before(surface, depth_m):
    """Standard deviations of pose and joints without any image."""
    joints = DEFAULTS.fit.joint_sigma * surface.kinematics.unit
    return np.r_[[KNOWN.most_range_share * depth_m] * 3, [KNOWN.most_turn_rad] * 3, joints]


@pytest.mark.parametrize("name", sorted(MODELS))
def test_it_is_a_covariance_even_of_nothing(name):
    truth = pose(0.05, -0.02, 0.9, 0.4, 0.1, MODELS[name])
    surface, frame, use = scene(MODELS[name], truth)
    for used in (use, np.zeros_like(use)):
        C = pose_covariances(surface, frame, truth, used, DEFAULTS)[0]
        n = 6 + surface.kinematics.n_joints
        assert C.shape == (n, n)
        np.testing.assert_array_equal(C, C.T)
        assert np.linalg.eigvalsh(C).min() > 0
    # nothing in use: what was known before
    np.testing.assert_allclose(np.sqrt(np.diag(C)), known_before(surface, 0.9))


@pytest.mark.parametrize("label", [UNKNOWN, BACKGROUND, BODY, RED])
def test_an_image_without_edges_says_nothing(label):
    truth = pose(0.0, 0.0, 0.9, 0.4, 0.1, MODELS["truck"])
    surface, _, use = scene(MODELS["truck"], truth)
    frame = ImageFrame(LabelField(np.full((240, 320), label, np.uint8)), CAMERA)
    C = pose_covariances(surface, frame, truth, use, DEFAULTS)[0]
    np.testing.assert_allclose(np.sqrt(np.diag(C)), known_before(surface, 0.9), rtol=1e-6)


def test_more_markers_say_more_and_depth_is_known_least():
    truth = pose(0.0, 0.0, 1.0, 0.5, 0.1, MODELS["truck"])
    surface, frame, use = scene(MODELS["truck"], truth)
    one = use & (surface.component[surface.markers] == 0)
    assert one.sum() < use.sum()
    less, more = (pose_covariances(surface, frame, truth, u, DEFAULTS)[0] for u in (one, use))
    assert np.trace(more[:3, :3]) < np.trace(less[:3, :3]) and np.trace(more[3:, 3:]) < np.trace(less[3:, 3:])
    assert more[2, 2] > 2 * max(more[0, 0], more[1, 1])


def test_farther_away_less_is_known():
    near, far = (pose(0.0, 0.0, z, 0.5, 0.1, MODELS["truck"]) for z in (0.7, 1.4))
    spread = []
    for truth in (near, far):
        surface, frame, use = scene(MODELS["truck"], truth)
        spread.append(np.sqrt(np.diag(pose_covariances(surface, frame, truth, use, DEFAULTS)[0])))
    assert np.all(spread[1][:3] > 1.3 * spread[0][:3]) and spread[1][2] > 2 * spread[0][2]


def test_more_markers_say_no_more_of_what_shifts_all_edges():
    """As light from a side does, and a lens: it moves the place by as much, however many markers an object has."""
    truth = pose(0.0, 0.0, 1.0, 0.5, 0.1, MODELS["truck"])
    surface, frame, use = scene(MODELS["truck"], truth)
    one = use & (surface.component[surface.markers] == 0)
    known, pixel_m = known_before(surface, 1.0)[None], truth.t[0, 2] / CAMERA.matrix[0, 0]
    for used in (one, use):
        shift = sources(surface, frame, truth, used, known, DEFAULTS).shift[0]
        np.testing.assert_allclose(np.sqrt(np.diag(shift)[:2]), pixel_m, rtol=0.15)
    shifted = replace(DEFAULTS, covariance=replace(KNOWN, shift_px=2.0))
    C = pose_covariances(surface, frame, truth, use, shifted)[0]
    assert np.all(np.sqrt(np.diag(C)[:2]) > 1.7 * pixel_m)


def test_a_seam_makes_the_range_less_sure():
    rng = np.random.default_rng(0)
    truth = pose(0.0, 0.0, 1.0, 0.5, 0.1, MODELS["truck"])
    spread = []
    for seam in (False, True):
        surface, frame, use = scene(MODELS["truck"], truth, seam=seam, rng=rng)
        spread.append(pose_covariances(surface, frame, truth, use, DEFAULTS)[0][2, 2])
    assert spread[1] > 1.5 * spread[0]


def test_where_in_a_seam_an_edge_lies_may_be_otherwise_around_each_marker():
    """A flag stands before a floor, the plate's marker on a body: how wide the flag looks tells how far it is turned,
    and no other marker tells how much wider it looks than it is."""
    plate = Component("plate", (marker("face", CAB, RIGHT_SIDE, (0, 0, 0)),), required=True)
    hinge = Joint("plate", Pose.from_xyz_rpy((0.0, 0.0, 0.1)), np.array([0.0, 0.0, 1.0]), -1.2, 1.2)
    flag = Component("flag", (marker("face", rectangle(0.08, 0.06), RIGHT_SIDE, (0, 0, 0)),), joint=hinge)
    model, turn = ObjectModel("flagged", (plate, flag)), 0.7
    truth = pose(0, 0, 0.8, 0.0, 0.0, model, {"flag": turn})
    surface, frame, use = scene(model, truth, seam=True, rng=np.random.default_rng(0))
    found = sources(surface, frame, truth, use, known_before(surface, 0.8)[None], DEFAULTS)
    half_px = CAMERA.focal_px / 0.8 * 0.04
    by_px = np.sqrt(found.seam[0, 6, 6]) / found.seams_px[0]
    assert by_px == pytest.approx(1 / (half_px * np.sin(turn)), rel=0.5)


def test_what_may_be_a_seam_or_a_body_of_no_class_makes_it_as_unsure():
    rng, model = np.random.default_rng(0), MODELS["slide"]
    truth = pose(0.0, 0.0, 1.0, 0.5, 0.1, model)
    surface, frame, use = scene(model, truth, seam=True, rng=rng)
    seam = pose_covariances(surface, frame, truth, use, DEFAULTS)[0][2, 2]
    either = replace(frame, field=LabelField(frame.field.codes, on_bodies=[RED]))
    assert either.field.seam_px(RED) < frame.field.seam_px(RED)
    assert pose_covariances(surface, either, truth, use, DEFAULTS)[0][2, 2] > 0.8 * seam


@pytest.mark.parametrize("name", ["truck", "slide"])
def test_labels_in_cells_of_pixels_are_known_to_be_rough(name):
    """As networks give them whose labels are a third of the image's size."""
    smooth = replace(DEFAULTS, covariance=replace(KNOWN, rough_gain=0.0))
    held = [shares(*fits(name, 40, cell=3, config=c), slice(0, 6))[1] for c in (DEFAULTS, smooth)]
    assert held[0] > 0.7 and held[1] < held[0] - 0.2


@pytest.mark.parametrize("name", ["sign", "truck"])
def test_borders_that_are_off_where_labels_are_sure_are_known_to_be(name):
    smooth = replace(DEFAULTS, covariance=replace(KNOWN, rough_gain=0.0))
    held = [shares(*fits(name, 40, config=c, spoil=torn), slice(0, 6))[1] for c in (DEFAULTS, smooth)]
    assert held[0] > 0.75 and held[1] < held[0] - 0.2


def test_blended_colours_make_the_range_less_sure_and_hardly_where_it_lies():
    """An outline that is wider all around looks nearer, not elsewhere; how far apart several are that does not change,
    but each may be wider by itself, and so several are less sure, too, by less."""
    ratios = []
    for model in (plate(), truck()):
        truth = pose(0.0, 0.0, 0.6, 0.5, 0.1, model)
        surface, frame, use = scene(model, truth)
        colours = replace(frame, image=np.zeros((*frame.field.labels.shape, 3), np.uint8))
        plain, blended = (np.diag(pose_covariances(surface, f, truth, use, DEFAULTS)[0]) for f in (frame, colours))
        ratios.append(blended[:3] / plain[:3])
    one, several = ratios
    assert one[2] > 1.3 and np.all(one[:2] < 1.8) and 1.3 < several[2] < 0.6 * one[2]


@pytest.mark.parametrize("name", sorted(MODELS))
def test_many_are_told_of_as_each_alone(name):
    rng, truth = np.random.default_rng(0), pose(0.0, 0.0, 0.9, 0.4, 0.1, MODELS[name])
    surface, frame, use = scene(MODELS[name], truth)
    poses = jolted(rng, truth, 3, 0.002, 0.01, 0.02)
    uses = np.array([use[0], np.zeros_like(use[0]), use[0] & (np.arange(use.shape[1]) == use[0].argmax())])
    together = pose_covariances(surface, frame, poses, uses, DEFAULTS)
    for n in range(3):
        alone = pose_covariances(surface, frame, poses[n : n + 1], uses[n : n + 1], DEFAULTS)[0]
        np.testing.assert_allclose(together[n], alone, rtol=1e-9, atol=1e-15)
    assert pose_covariances(surface, frame, poses[:0], uses[:0], DEFAULTS).shape == (0, *alone.shape)
