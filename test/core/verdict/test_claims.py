"""Silhouettes, and what the labels say of candidates."""

import cv2
import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import BACKGROUND, BENT, RED, camera_of, pose, render, sign, truck

from artrec_ros.core.image.codes import OWNED
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.verdict.claims import MOST_KNOWN, claims_of, silhouette

CAMERA = camera_of()
TRUCK = truck()
LEFT = pose(-0.25, 0, 1.0, 0.3, model=TRUCK)


def mask_of(model, at, camera=CAMERA, shape=(240, 320)):
    field = LabelField(np.full(shape, BACKGROUND, np.uint8))
    return field.without(silhouette(SpatialModel(model, RED, DEFAULTS.votes), camera, at)).labels == OWNED


def grown(mask, px):
    return cv2.dilate(mask.astype(np.uint8), np.ones((2 * px + 1, 2 * px + 1), np.uint8)).astype(bool)


@pytest.mark.parametrize("lens", [(), BENT], ids=len)
@pytest.mark.parametrize("heading", [0.4, 2.5, -1.2])
def test_a_silhouette_covers_what_is_seen_of_an_object_and_little_else(heading, lens):
    camera = camera_of(distortion=lens)
    at = pose(0.02, 0, 0.9, heading, 0.2, TRUCK, {"fore": 0.5, "hind": -0.2})
    shown = render(camera, [(TRUCK, at, RED)]) != BACKGROUND
    mask = mask_of(TRUCK, at, camera)
    assert not (shown & ~grown(mask, 1)).any()
    assert not (mask & ~grown(shown, 2)).any()


def test_a_silhouette_without_bodies_is_the_markers_hulls_from_either_side():
    mask = mask_of(sign(), pose(0, 0, 0.8))
    shown = render(CAMERA, [(sign(), pose(0, 0, 0.8), RED)]) == RED
    assert not (shown & ~grown(mask, 1)).any()
    assert mask.sum() < 1.4 * shown.sum()
    assert mask_of(sign(), pose(0, 0, 0.8, np.pi)).sum() == pytest.approx(mask.sum(), rel=0.02)


def test_silhouettes_beyond_the_border_are_cut_and_those_out_of_view_are_empty():
    assert 0 < mask_of(TRUCK, pose(-0.55, 0, 1.0, model=TRUCK)).sum() < 0.8 * mask_of(TRUCK, LEFT).sum()
    assert not mask_of(TRUCK, pose(5.0, 0, 1.0, model=TRUCK)).any()
    close = mask_of(TRUCK, pose(0, 0, 0.08, model=TRUCK))  # partly behind the camera
    assert close.mean() > 0.5


def test_each_hypothesis_has_a_claim_in_its_order():
    frame = ImageFrame(LabelField(render(CAMERA, [(TRUCK, LEFT, RED)])), CAMERA)
    finder = WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)
    poses = Poses.concatenate([pose(5.0, 0, 1.0, model=TRUCK), LEFT])
    beyond, seen = claims_of(finder, poses, frame)
    assert beyond.votes == 0 < seen.votes
    np.testing.assert_array_equal(seen.poses.t, LEFT.t)
    np.testing.assert_allclose(seen.votes, finder.voter.votes(frame, LEFT, occlusion=True)[0])
    anchor = LEFT.R[0] @ finder.surface.anchor + LEFT.t[0]  # no joint carries the required component
    assert seen.depth_m == pytest.approx(anchor[2])
    assert seen.scale == pytest.approx(CAMERA.focal_px / anchor[2])
    assert len(claims_of(finder, poses[:0], frame)) == 0


@pytest.mark.parametrize(
    "limits, known",
    [
        ({}, MOST_KNOWN), ({"min_scale": 100.0}, MOST_KNOWN), ({"max_scale": 100.0}, MOST_KNOWN),
        ({"min_scale": 100.0, "max_scale": 200.0}, np.log(2)), ({"min_scale": 1.0, "max_scale": 1e4}, MOST_KNOWN),
        ({"min_scale": 100.0, "max_scale": 100.0}, 0.0),
    ],
)  # fmt: skip
def test_how_many_scales_are_possible_is_known_from_their_limits(limits, known):
    finder = WholeObjectFinder(Target("sign", sign(), RED), settings(**limits), facing=True)
    frame = ImageFrame(LabelField(np.zeros((240, 320), np.uint8))).faced()
    assert claims_of(finder, pose(0, 0, 0.8), frame).known == pytest.approx(known, abs=1e-6)
