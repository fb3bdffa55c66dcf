"""What is known of the floor in fits: objects stand on it as far as the image does not tell otherwise."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, marker, rectangle, render

from artrec_ros.core.base.config import FloorConfig
from artrec_ros.core.geometry.floor import Floor
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec, rotation_from_rpy
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.colour_fit import ColourFit
from artrec_ros.core.pose.covariance import pose_covariances
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.floor_term import equations, floor_term, is_told
from artrec_ros.core.pose.pose_fit import fit_poses
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.pose.turn_evidence import turn_odds
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.io.objects.solids import box_solid

CAMERA, HIGH_M, PITCH_DEG = camera_of((640, 480), 600.0), 1.2, 80.0
FLOOR = FloorConfig(
    camera_height_m=HIGH_M, camera_pitch_deg=PITCH_DEG, height_tolerance_m=0.02, max_tilt_deg=5.0
)  # fmt: skip
OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
IN_CAMERA = Pose(rotation_from_rpy(np.radians([0.0, PITCH_DEG, 0.0])) @ OPTICAL, np.array([0.0, 0.0, HIGH_M])).inverse()
SIDES, BODIES = box_solid(Box(Pose.from_xyz_rpy((0, 0, 0.02)), np.array([0.04, 0.04, 0.04])))
CUBE = ObjectModel("cube", (Component("block", SIDES, True, label=RED, bodies=BODIES),))
TWO = ObjectModel(
    "two",
    tuple(
        Component(name, (marker("face", rectangle(0.04, 0.04), np.eye(3), (x, 0, 0)),), x < 0)
        for name, x in (("left", -0.2), ("right", 0.2))
    ),
)


def standing(height_m=0.0, heading=0.3, leaning=0.0):
    T = IN_CAMERA.rotation, IN_CAMERA.apply(np.array([0.25, 0.05, height_m]))
    R = rotation_from_rpy([leaning, 0.0, heading])
    return Poses((T[0] @ R)[None], T[1][None], np.zeros((1, 0)))


def known(floor: FloorConfig | None) -> Scene:
    return Scene(floor=Floor.of(floor) if floor else None)


def fitted(model, labels, start, floor, image=None):
    """A last fit, and its covariance."""
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    frame = ImageFrame(LabelField(labels), CAMERA, image=image, scene=known(floor))
    use = surface.score(frame, start, surface.markers, occlusion=True).agree > 0.5
    fit = fit_poses(surface, frame, start, use, (4, 3, 3, 2, 2), DEFAULTS.fit, last=True)
    if image is not None:
        fit = ColourFit(surface, DEFAULTS).fitted(frame, fit, use)
    return fit, pose_covariances(surface, frame, fit, use, DEFAULTS)[0]


def thick(model, at):
    """Labels that reach a pixel beyond the object all around."""
    labels = render(CAMERA, [(model, at, RED)])
    larger = cv2.dilate((labels == RED).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    return np.where(larger, RED, labels).astype(np.uint8)


def range_of(poses):
    return float(np.linalg.norm(poses.t[0]))


def test_its_equations_are_what_height_and_leaning_cost():
    rng = np.random.default_rng(1)
    floor = Floor.of(FLOOR)
    term = floor_term(floor, DEFAULTS.fit)
    R = rotation_from_rotvec(rng.normal(0, 0.7, (6, 3)) + (np.pi / 2, 0, 0))
    poses = Poses(R, rng.normal(0, 1, (6, 3)), np.zeros((6, 0)))
    A, b = equations(term, poses, 7)

    def cost(moved):
        off = np.stack([floor.heights(moved.t) / floor.height_sigma_m,
                        np.radians(floor.tilts_deg(moved.R)) / floor.leaning_sigma_rad])  # fmt: skip
        return (off**2).sum(axis=0) / 2 * DEFAULTS.fit.point_sigma_px**2

    step = 1e-5
    for k, way in enumerate(np.eye(6)):
        there, back = (
            cost(Poses(rotation_from_rotvec(s * way[3:]) @ R, poses.t + s * way[:3], poses.q)) for s in (step, -step)
        )
        np.testing.assert_allclose(b[:, k], (there - back) / (2 * step), rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(A, A.swapaxes(1, 2))
    assert not A[:, 6].any() and not b[:, 6].any()
    upwards = np.r_[0, 0, 0, floor.up, 0]  # turns about it lean nothing, and ways along the floor change no height
    np.testing.assert_allclose(A @ upwards, 0.0, atol=1e-12)
    along = np.r_[np.cross(floor.up, [1, 0, 0]), 0, 0, 0, 0]
    np.testing.assert_allclose(A @ along, 0.0, atol=1e-9)


def test_nothing_is_added_where_no_floor_is_known_or_objects_face_the_camera():
    A, b = equations(floor_term(None, DEFAULTS.fit), standing(), 6)
    assert not A.any() and not b.any() and not is_told(floor_term(None, DEFAULTS.fit))
    frame = ImageFrame(LabelField(np.zeros((48, 64), np.uint8)), CAMERA, scene=known(FLOOR))
    assert frame.faced().scene.floor is None and frame.scene.floor is not None


@pytest.mark.parametrize("in_colour", [False, True])
def test_a_cube_whose_labels_are_thick_is_as_far_off_as_its_floor(in_colour):
    at = standing()
    labels = thick(CUBE, at)
    image = None
    if in_colour:
        image = np.where((labels == RED)[..., None], (40, 30, 200), (90, 90, 90)).astype(np.uint8)
    free, wide = fitted(CUBE, labels, at, None, image)
    held, narrow = fitted(CUBE, labels, at, FLOOR, image)
    assert abs(range_of(free) / range_of(at) - 1) > 0.04
    assert abs(range_of(held) / range_of(at) - 1) < 0.015
    assert Floor.of(FLOOR).tilts_deg(held.R)[0] < 2.5
    up = Floor.of(FLOOR).up
    assert up @ narrow[:3, :3] @ up < 1.05 * Floor.of(FLOOR).height_sigma_m ** 2
    assert np.linalg.det(narrow) < np.linalg.det(wide)
    # which way it is turned on the floor the image tells alone
    assert up @ narrow[3:, 3:] @ up > 0.2 * (up @ wide[3:, 3:] @ up)


def test_what_the_image_shows_in_the_air_stays_there():
    at = standing(height_m=0.09)
    held, _ = fitted(TWO, render(CAMERA, [(TWO, at, RED)]), at, replace(FLOOR, height_tolerance_m=0.1))
    assert Floor.of(FLOOR).heights(held.t)[0] == pytest.approx(0.09, abs=0.005)


def test_of_two_turns_the_upright_one_is_as_much_likelier_as_it_leans_less():
    finder = WholeObjectFinder(Target("cube", CUBE, RED), DEFAULTS)
    at, other = standing(), standing(leaning=np.radians(4))
    labels = LabelField(render(CAMERA, [(CUBE, at, RED)]))
    free, held = (
        turn_odds(finder, ImageFrame(labels, CAMERA, scene=known(floor)), at, other) for floor in (None, FLOOR)
    )
    assert held - free == pytest.approx(-((4 / 2.5) ** 2) / 2, rel=1e-6)


@pytest.mark.parametrize("tolerance_m, at_least", [(0.02, 3.0), (0.2, 1.5), (1.2, 1.0)])
def test_the_fewer_places_a_floor_leaves_the_likelier_an_object_is(tolerance_m, at_least):
    finder, at = WholeObjectFinder(Target("cube", CUBE, RED), DEFAULTS), standing()
    labels = LabelField(render(CAMERA, [(CUBE, at, RED)]))
    odds = []
    for floor in (None, replace(FLOOR, height_tolerance_m=tolerance_m)):
        frame = ImageFrame(labels, CAMERA, scene=known(floor))
        p = float(Judge.of(DEFAULTS).verdicts(finder, at, frame).probability[0])
        odds.append(p / (1 - p))
    times = odds[1] / odds[0]
    assert times > at_least if at_least > 1 else times == pytest.approx(1.0)  # from the lens on: any range
