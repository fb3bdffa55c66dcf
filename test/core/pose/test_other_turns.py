"""Mirrored turns that an image bears out nearly as well are told, and counted."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, pose, render, sign, slide, truck, turn_between

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_turns import mirrored_of
from artrec_ros.core.pose.surface_model import Poses
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.claims import claims_of
from artrec_ros.core.verdict.descriptions import Describer

CAMERA = camera_of()


def scene(model, *poses):
    frame = ImageFrame(LabelField(render(CAMERA, [(model, p, RED) for p in poses])), CAMERA)
    return WholeObjectFinder(Target(model.name, model, RED), DEFAULTS), frame, Poses.concatenate(list(poses))


@pytest.mark.parametrize("slant", [0.5, 0.9])
@pytest.mark.parametrize("model", [sign(), slide()], ids=lambda m: m.name)
def test_a_distant_plane_may_be_slanted_the_other_way(model, slant):
    finder, frame, at = scene(model, pose(0, 0, 2.0, slant, 0.1, model))
    (mirrored,) = mirrored_of(finder, frame, at)
    assert turn_between(mirrored.poses.R[0], at.R[0]) == pytest.approx(2 * slant, abs=0.15)
    assert 0 < mirrored.probability < 0.5
    added = mirrored.beside(at)
    assert np.sqrt(np.trace(added[3:, 3:])) == pytest.approx(np.sqrt(mirrored.probability) * 2 * slant, rel=0.15)


@pytest.mark.parametrize(
    ("model", "z", "slant"), [(sign(), 0.35, 0.9), (truck(), 2.0, 0.5), (truck(bodies=False), 2.0, 0.9)]
)
def test_perspective_or_other_planes_tell_which_way(model, z, slant):
    assert mirrored_of(*scene(model, pose(0, 0, z, slant, 0.1, model))) == [None]


def test_what_does_not_stand_on_a_known_floor_is_none():
    finder, frame, at = scene(sign(), pose(0, 0, 2.0, 0.9, 0.1))
    floor = SimpleNamespace(standing=lambda R, t, slack: np.zeros(len(R), bool))
    assert mirrored_of(finder, replace(frame, scene=SimpleNamespace(floor=floor)), at) == [None]


def test_each_of_several_has_its_own():
    near, far = pose(-0.12, 0, 0.5, 0.9), pose(0.3, 0, 2.0, 0.9)
    first, second = mirrored_of(*scene(sign(), near, far))
    assert first is None and second is not None and second.poses.t[0, 2] == pytest.approx(2.0, rel=0.1)


def test_it_is_told_and_the_covariance_counts_it():
    finder, frame, at = scene(sign(), pose(0, 0, 2.0, 0.9, 0.1))
    (detection,) = Describer(finder).describe(list(verdicts_of(claims_of(finder, at, frame))), frame)
    other = detection.other_turn
    assert turn_between(other.pose.rotation, detection.pose.rotation) > 1.5
    assert np.sqrt(np.trace(detection.pose_covariance[3:, 3:])) > 0.8
    near, close, there = scene(sign(), pose(0, 0, 0.35, 0.9, 0.1))
    (sure,) = Describer(near).describe(list(verdicts_of(claims_of(near, there, close))), close)
    assert sure.other_turn is None and np.sqrt(np.trace(sure.pose_covariance[3:, 3:])) < 0.2
