"""Poses that come to rest on where an image's colours change."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, chain, pose, render, sign, truck, turn_between

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.pose.colour_fit import ColourFit
from artrec_ros.core.pose.pose_fit import fit_poses
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel

CAMERA, FINE = camera_of(), 4
INKS = np.array([(120, 125, 130), (35, 40, 190), (150, 60, 30), (225, 220, 215)], np.float32)  # floor, classes
SCENES = {
    "sign": (sign(), pose(0.02, 0, 0.7, 0.5, 0.2)),
    "truck": (truck(), pose(0, 0, 0.8, 0.4, 0.1, truck(), {"fore": 0.4, "hind": -0.3})),
    "chain": (chain(), pose(-0.1, 0.03, 0.7, 0.2, 0, chain(), {"arm": 0.2, "rod": 0.05, "finger": 0.4})),
}


def fine_camera() -> Camera:
    K = CAMERA.matrix.copy()
    K[:2] *= FINE
    K[:2, 2] += (FINE - 1) / 2  # a pixel's centre has whole numbers
    return Camera(K, np.zeros(0), (CAMERA.size[0] * FINE, CAMERA.size[1] * FINE))


def taken(model, truth, *, fat_px=0, blur_px=1.0, gamma=1.0, noise=1.5):
    """A frame whose labels end `fat_px` outside of markers, and on these half of the light of a lens of this blur."""
    labels = render(CAMERA, [(model, truth, RED)])
    if fat_px:
        labels = cv2.dilate(labels, np.ones((2 * fat_px + 1, 2 * fat_px + 1), np.uint8))
    numbers = np.unique(labels, return_inverse=True)[1].max()
    assert numbers < len(INKS)
    fine = render(fine_camera(), [(model, truth, RED)])
    order = np.searchsorted(np.unique(labels), fine)
    light = cv2.resize((INKS[order] / 255) ** gamma, CAMERA.size, interpolation=cv2.INTER_AREA)
    values = 255 * cv2.GaussianBlur(light, (0, 0), blur_px) ** (1 / gamma)
    image = np.clip(np.rint(values + np.random.default_rng(0).normal(0, noise, values.shape)), 0, 255)
    return ImageFrame(LabelField(labels), CAMERA, image=image.astype(np.uint8), gamma=gamma)


def used_of(surface, frame, truth):
    scores = surface.score(frame, truth, np.arange(len(surface.patches)), occlusion=True)
    return scores.agree[:, surface.markers] > 0.5


def both_fits(name, **options):
    """(relative error of range, turn) by labels alone, and then by colours."""
    model, truth = SCENES[name]
    surface, frame = SpatialModel(model, RED, DEFAULTS.votes), taken(model, truth, **options)
    used = used_of(surface, frame, truth)
    reach = DEFAULTS.fit.fine_reach_px
    by_labels = fit_poses(surface, frame, truth, used, reach, DEFAULTS.fit)  # which takes edges for where it ends
    by_colours = ColourFit(surface, DEFAULTS).fitted(frame, by_labels, used)
    return [
        (np.linalg.norm(p.t[0]) / np.linalg.norm(truth.t[0]) - 1, float(turn_between(p.R[0], truth.R[0])))
        for p in (by_labels, by_colours)
    ]


@pytest.mark.parametrize("name", list(SCENES))
@pytest.mark.parametrize("gamma", [1.0, 2.2])
def test_labels_a_pixel_off_do_not_change_the_range(name: str, gamma: float) -> None:
    labels, colours = both_fits(name, fat_px=1, gamma=gamma)
    assert abs(labels[0]) > 0.008  # a pixel all around
    assert abs(colours[0]) < 0.4 * abs(labels[0])


@pytest.mark.parametrize("name", list(SCENES))
def test_with_true_labels_poses_are_no_worse(name: str) -> None:
    labels, colours = both_fits(name)
    assert abs(colours[0]) <= max(abs(labels[0]), 0.003) and colours[1] <= max(labels[1], 0.03)


def test_values_that_are_no_light_put_edges_elsewhere() -> None:
    """Bright paint on a darker floor looks larger: what `image.gamma` is for."""
    model, truth = SCENES["sign"]
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    frame = taken(model, truth, blur_px=1.5, gamma=2.2)
    used, errors = used_of(surface, frame, truth), []
    for gamma in (1.0, 2.2):
        seen = replace(frame, gamma=gamma)
        found = ColourFit(surface, DEFAULTS).fitted(seen, truth, used)
        errors.append(abs(np.linalg.norm(found.t[0]) / np.linalg.norm(truth.t[0]) - 1))
    assert errors[1] < 0.5 * errors[0]


def test_where_colours_tell_nothing_poses_stay_on_the_labels() -> None:
    model, truth = SCENES["truck"]
    surface, frame = SpatialModel(model, RED, DEFAULTS.votes), taken(model, truth)
    used = used_of(surface, frame, truth)
    rest = fit_poses(surface, frame, truth, used, DEFAULTS.fit.fine_reach_px, DEFAULTS.fit, last=True)
    plain = ImageFrame(frame.field, CAMERA, image=np.full_like(frame.image, 90))
    found = ColourFit(surface, DEFAULTS).fitted(plain, rest, used)
    np.testing.assert_allclose(found.t, rest.t, atol=2e-3)


def test_joints_that_no_used_marker_tells_of_stay() -> None:
    model, truth = SCENES["chain"]
    surface, frame = SpatialModel(model, RED, DEFAULTS.votes), taken(model, truth)
    used = used_of(surface, frame, truth)
    kin = surface.kinematics
    unseen = 1 + int(np.argmax(surface.component[surface.markers][1:] == surface.component.max()))
    used[:, unseen] = False
    moved = kin.moves[surface.component[surface.markers]][used[0]].any(axis=0)
    start = Poses(truth.R, truth.t, truth.q + 0.05)
    found = ColourFit(surface, DEFAULTS).fitted(frame, start, used)
    assert not moved.all()
    np.testing.assert_allclose(found.q[:, ~moved], start.q[:, ~moved], atol=1e-9)


def test_without_markers_in_use_nothing_moves() -> None:
    model, truth = SCENES["sign"]
    surface, frame = SpatialModel(model, RED, DEFAULTS.votes), taken(model, truth)
    fit, none = ColourFit(surface, DEFAULTS), np.zeros((1, len(surface.markers)), bool)
    assert np.array_equal(fit.fitted(frame, truth, none).t, truth.t)
    assert len(fit.fitted(frame, truth[:0], none[:0])) == 0


def test_poses_that_would_lie_worse_or_lose_their_edges_stay() -> None:
    """Begun so far off that steps lead away."""
    model, truth = SCENES["sign"]
    surface, frame = SpatialModel(model, RED, DEFAULTS.votes), taken(model, truth)
    used, rng, stayed = used_of(surface, frame, truth), np.random.default_rng(1), 0
    fit = ColourFit(surface, DEFAULTS)
    for _ in range(40):
        start = Poses(truth.R, truth.t * (1 + rng.normal(0, 0.12, 3)), truth.q)
        found, (_, residual, weight) = fit.fitted(frame, start, used), fit.edges(frame, start, used)
        _, after, weigh = fit.edges(frame, found, used)
        stayed += np.array_equal(found.t, start.t)
        if not np.array_equal(found.t, start.t):
            assert weigh.sum() > 0.8 * weight.sum() and _mean(after, weigh) < _mean(residual, weight)
    assert stayed < 40


def _mean(residual: np.ndarray, weight: np.ndarray) -> float:
    return float(np.average(np.minimum(np.abs(residual), 3.0), weights=weight))
