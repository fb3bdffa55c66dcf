"""Arms with balls on their joints: a ball's blob tells its place in space, and nothing of its turn."""

from __future__ import annotations

import numpy as np
import pytest
from settings import settings
from solids import BLUE, BODY, RED, camera_of, marker, render

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import other_bends
from artrec_ros.core.pose.ball_blobs import BallBlobs
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.objects.solids import ball_solid

CAMERA = camera_of((400, 400), 300.0)
HAND = 6
RADII = {"base": 0.07, "elbow": 0.06, "wrist": 0.05, "hand": 0.04}
UPRIGHT = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)


def arm():
    """Four balls of four colours, each a link's length from the one before."""

    def ball(name, label, z, joint=None):
        markers, _ = ball_solid(RADII[name], Pose.from_xyz_rpy((0, 0, z)))
        return Component(name, markers, required=joint is None, label=label, joint=joint)

    def joint(parent, z, axis):
        return Joint(parent, Pose.from_xyz_rpy((0, 0, z)), np.array(axis, float), -1.5, 1.5)

    parts = (
        ball("base", RED, 0.0),
        ball("elbow", BLUE, 0.0, joint("base", 0.25, (1, 0, 0))),
        ball("wrist", BODY, 0.3, joint("elbow", 0.0, (0, 1, 0))),
        ball("hand", HAND, 0.25, joint("wrist", 0.3, (1, 0, 0))),
    )
    return ObjectModel("arm", parts)


def somewhere(n):
    """A pose: the arm stands, in any direction, and is bent."""
    rng = np.random.default_rng(n)
    R = UPRIGHT @ rotation_from_rotvec([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
    t = np.array([rng.uniform(-0.3, 0.3), 0.25, rng.uniform(1.5, 2.0)])
    return Poses(R[None], t[None], rng.uniform(-1.3, 1.3, (1, 3)))


def middles(model, poses):
    """(4, 3) the balls' in the camera."""
    kin = Kinematics(model)
    frames = kin.forward(poses.R, poses.t, poses.q)
    own = np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0.3], [0, 0, 0.25]])
    return np.einsum("cij,cj->ci", frames.R[0], own) + frames.t[0]


def told(model, found):
    q = np.array([[found.joints.get(name, 0.0) for name in model.joint_names]])
    return Poses(found.pose.rotation[None], found.pose.position[None], q)


def engine_of(model):
    config = settings(time_budget_ms=60000.0)
    return Recognizer((Target("arm", model, RED),), config, Segmenter(ImageConfig()), calibrated=True)


@pytest.mark.parametrize("n", [9, 10, 17, 21, 22, 25, 28, 29])
def test_links_lean_to_the_side_that_the_size_of_their_balls_tells(n):
    """Each of these was told with balls that are a tenth to two thirds larger or smaller than those in view, or without
    one of them."""
    model, true = arm(), somewhere(n)
    (found,) = engine_of(model).recognize(render(CAMERA, [(model, true, RED)]), CAMERA).detections
    assert [c.component for c in found.components] == list(RADII)
    there, here = middles(model, told(model, found)), middles(model, true)
    assert np.linalg.norm(project(CAMERA, there) - project(CAMERA, here), axis=1).max() < 2
    assert np.abs(there[:, 2] / here[:, 2] - 1).max() < 0.05


def test_blobs_speak_of_the_balls_on_them_alone():
    model, true = arm(), somewhere(38)
    surface = SpatialModel(model, RED, settings().votes)
    assert surface.sides.balls == {0, 1, 2, 3}
    labels = render(CAMERA, [(model, true, RED)])
    blobs, shown = find_blobs(labels, [RED, BLUE, BODY, HAND], settings()), [of[0] for of in surface.markers_of]
    balls = BallBlobs(surface)
    assert balls.under(CAMERA, true, shown, blobs) is None
    beside = Poses(true.R, true.t + [0.03, 0.0, 0.0], true.q)
    found = balls.under(CAMERA, beside, shown, blobs)
    np.testing.assert_allclose(found.at, project(CAMERA, middles(model, true)), atol=1.0)
    np.testing.assert_allclose(found.scale * middles(model, true)[:, 2] / CAMERA.focal_px, 1, atol=0.03)
    elsewhere = Poses(true.R, true.t + [0.0, 0.8, 0.0], true.q)
    assert balls.under(CAMERA, elsewhere, shown, blobs) is None


def test_a_disc_is_as_far_as_its_radius_says():
    """A blob's area is what a camera shows of a ball."""
    surface = SpatialModel(arm(), RED, settings().votes)
    for c, radius in enumerate(RADII.values()):
        (p, *_) = surface.markers_of[c]
        assert surface.sides.blobs[1][p] == pytest.approx(np.pi * radius**2, rel=0.005)


def sphere(centre, radius, camera):
    """(H, W) bool: whose line of sight meets a ball."""
    v, u = np.indices(camera.size[::-1])
    rays = np.dstack(
        [(u - camera.matrix[0, 2]) / camera.focal_px, (v - camera.matrix[1, 2]) / camera.focal_px, 1 + 0 * u]
    )
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    return (rays @ centre) ** 2 > centre @ centre - radius**2


LONE = ObjectModel("ball", (Component("all", ball_solid(0.05, Pose.from_xyz_rpy((0.2, 0, 0)))[0], required=True),))


@pytest.mark.parametrize("turn", [(0, 0, 0), (1.0, -2.0, 0.5)])
@pytest.mark.parametrize("centre", [(0.0, 0.0, 0.3), (0.14, -0.1, 0.25), (-0.3, 0.2, 0.6)])
def test_the_outline_of_a_ball_is_that_of_a_sphere(turn, centre):
    """Near the camera and aside, however its object is turned."""
    R, centre = rotation_from_rotvec(np.array(turn, float)), np.array(centre)
    pose = Poses(R[None], (centre - R @ [0.2, 0, 0])[None], np.zeros((1, 0)))
    surface = SpatialModel(LONE, RED, settings().votes)
    frames = surface.kinematics.seen(pose.R, pose.t, pose.q)
    drawn = surface.place(frames, surface.patches[0].drawn[3:], np.zeros(64, np.int64))[0]
    to_centre = centre / np.linalg.norm(centre)
    along = drawn @ to_centre / np.linalg.norm(drawn, axis=1)
    assert np.arccos(along) == pytest.approx(np.arcsin(0.05 / np.linalg.norm(centre)), rel=2e-3)
    (found,) = (
        Recognizer((Target("ball", LONE, RED),), settings(), Segmenter(ImageConfig()), calibrated=True)
        .recognize(np.where(sphere(centre, 0.05, CAMERA), RED, 0).astype(np.uint8), CAMERA)
        .detections
    )
    assert found.score > 0.8
    here = found.pose.apply(np.array([[0.2, 0, 0]]))[0]
    np.testing.assert_allclose(here, centre, atol=0.01 * np.linalg.norm(centre))


def test_what_a_ball_carries_is_where_its_joint_takes_it():
    """It turns with the ball, not with the camera."""
    model, true = arm(), somewhere(3)
    kin = Kinematics(model)
    seen, own = kin.seen(true.R, true.t, true.q), kin.forward(true.R, true.t, true.q)
    np.testing.assert_allclose(seen.origin, own.origin)
    places = np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0.3], [0, 0, 0.25]])
    at = np.einsum("cij,cj->ci", seen.R[0], places) + seen.t[0]
    np.testing.assert_allclose(project(CAMERA, at), project(CAMERA, middles(model, true)), atol=1e-9)
    np.testing.assert_allclose(np.einsum("ci,ci->c", seen.R[0, :, :, 2], at / np.linalg.norm(at, axis=1)[:, None]), -1)


@pytest.mark.parametrize("nearer_m", [0.0, 0.2])
def test_a_ball_stands_out_of_what_is_in_it(nearer_m):
    """A rod through its middle hides nothing of it, one before it does."""
    model, true = arm(), somewhere(3)
    towards = true.R[0].T @ -true.t[0] / np.linalg.norm(true.t[0])
    rod = Box(Pose.from_xyz_rpy(nearer_m * towards), np.array([0.04, 0.04, 0.04]))
    joint = Joint("base", Pose.identity(), np.array([0.0, 0.0, 1.0]), 0.0, 0.0, "fixed")
    sign = marker("sign", 0.02 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), np.eye(3), (0, 0, 0.1))
    link = Component("link", (sign,), label=HAND, joint=joint, bodies=(rod,))
    model = ObjectModel("arm", (*model.components, link))
    surface = SpatialModel(model, RED, settings().votes)
    shown = surface.shown(surface.kinematics.seen(true.R, true.t, true.q), surface.markers[:1], 36)
    assert shown.mean() == 1 if nearer_m == 0 else shown.mean() < 0.9


@pytest.mark.parametrize("x_px", [-20.0, -8.0, 4.0])
def test_a_ball_that_the_border_cuts_is_told_by_what_shows(x_px):
    """Its centre may lie beyond."""
    at = np.array([x_px, 200.0])
    centre = np.append((at - CAMERA.matrix[:2, 2]) / CAMERA.focal_px, 1.0) * 0.3
    labels = np.where(sphere(centre, 0.05, CAMERA), RED, 0).astype(np.uint8)
    engine = Recognizer((Target("ball", LONE, RED),), settings(), Segmenter(ImageConfig()), calibrated=True)
    (found,) = engine.recognize(labels, CAMERA).detections
    assert found.score > 0.6
    here = found.pose.apply(np.array([[0.2, 0, 0]]))[0]
    np.testing.assert_allclose(here, centre, atol=0.06 * np.linalg.norm(centre))


def test_a_ball_is_bent_to_the_other_side_of_its_joint():
    """Seen along neither axis nor lever it lies as far behind as before, at the same place in the image; one that its
    joint turns in place is bent to none."""
    one, two = (ball_solid(0.02, Pose.from_xyz_rpy((0, 0, z)))[0] for z in (0.0, 0.2))
    joint = [Joint(parent, Pose.identity(), np.array([0.0, 1.0, 0.0]), -3.1, 3.1) for parent in ("base", "still")]
    parts = Component("base", one, True), Component("still", one, joint=joint[0]), Component("out", two, joint=joint[1])
    surface = SpatialModel(ObjectModel("arm", parts), RED, settings().votes)
    assert surface.component[surface.markers[surface.across[0]]].tolist() == [2]
    finder = WholeObjectFinder(Target("arm", surface.model, RED), settings())
    pose = Poses(np.eye(3)[None], np.array([[0.0, 0.0, 20.0]]), np.array([[0.0, 0.5]]))
    bends = other_bends._across(finder, pose, np.ones((1, 3), bool))
    assert bends.joint.tolist() == [1]
    assert np.cos(bends.poses.q[0, 1] - (np.pi - 0.5)) == pytest.approx(1, abs=1e-3)
