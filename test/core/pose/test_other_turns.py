"""Which of two mirrored turns a pose has is told by votes and contours together; the other is told and counted where it
may be the true one."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import DEFAULTS
from solids import (
    BACKGROUND,
    BLUE,
    BODY,
    RED,
    RIGHT_SIDE,
    camera_of,
    marker,
    pose,
    rectangle,
    render,
    sign,
    slide,
    truck,
    turn_between,
)

from artrec_ros.core.base.config import FloorConfig
from artrec_ros.core.geometry.floor import Floor
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.codes import UNKNOWN
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_turns import likelier_turns, mirrored_turns
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.turn_evidence import Evidence, evidence
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.claims import claims_of
from artrec_ros.core.verdict.descriptions import Describer
from artrec_ros.io.objects.solids import box_solid

CAMERA = camera_of()


def scene(model, *poses):
    frame = ImageFrame(LabelField(render(CAMERA, [(model, p, RED) for p in poses])), CAMERA)
    return WholeObjectFinder(Target(model.name, model, RED), DEFAULTS), frame, Poses.concatenate(list(poses))


@pytest.mark.parametrize("slant", [0.5, 0.9])
@pytest.mark.parametrize("model", [sign(), slide()], ids=lambda m: m.name)
def test_a_distant_plane_may_be_slanted_the_other_way(model, slant):
    finder, frame, at = scene(model, pose(0, 0, 2.0, slant, 0.1, model))
    told, (other,) = likelier_turns(finder, frame, at)
    assert turn_between(other.pose.rotation, told.R[0]) == pytest.approx(2 * slant, abs=0.15)
    assert 0.1 < other.probability < 0.5
    added = other.probability * other.spread(Pose(told.R[0], told.t[0]))
    assert np.sqrt(np.trace(added[3:, 3:])) == pytest.approx(np.sqrt(other.probability) * 2 * slant, rel=0.15)


@pytest.mark.parametrize(
    ("model", "z", "slant"), [(sign(), 0.35, 0.9), (truck(), 2.0, 0.5), (truck(bodies=False), 2.0, 0.9)]
)
def test_perspective_or_other_planes_tell_which_way(model, z, slant):
    at = pose(0, 0, z, slant, 0.1, model)
    told, others = likelier_turns(*scene(model, at))
    assert others == [None] and turn_between(told.R[0], at.R[0]) == 0


def test_what_is_wrong_and_can_be_told_is_turned():
    finder, frame, at = scene(sign(), pose(0, 0, 0.6, 0.9, 0.1))
    wrong = finder.required.flips(at)
    assert turn_between(wrong.R[0], at.R[0]) > 1.5
    told, _ = likelier_turns(finder, frame, finder.rest.fitted(frame, wrong))
    assert turn_between(told.R[0], at.R[0]) < 0.1


@pytest.mark.parametrize("x", [-0.8, 0.0, 0.9])
def test_far_from_the_images_middle_it_is_mirrored_about_the_line_of_sight(x):
    """A plane that faces the line of sight, not the optical axis, is its own mirror image."""
    finder, frame, at = scene(sign(), pose(x, 0.1, 2.0, 0.7, 0.1))
    flips = finder.required.flips(at)
    sight = at.t[0] / np.linalg.norm(at.t[0])
    normals = [R @ R_marker[:, 2] for R in (at.R[0], flips.R[0]) for R_marker in [_marker_turn(finder)]]
    was, now = (np.arccos(-n @ sight) for n in normals)
    assert was == pytest.approx(now, abs=0.03) and turn_between(flips.R[0], at.R[0]) > 0.5
    _, (other,) = likelier_turns(finder, frame, at)
    assert other is not None and turn_between(other.pose.rotation, flips.R[0]) < 0.2


def _marker_turn(finder):
    return finder.target.model.required.markers[0].T_component_marker.rotation


def test_what_does_not_stand_on_a_known_floor_is_none():
    finder, frame, at = scene(sign(), pose(0, 0, 2.0, 0.9, 0.1))
    floor = Floor.of(FloorConfig(camera_height_m=50.0))
    assert likelier_turns(finder, replace(frame, scene=Scene(floor=floor)), at)[1] == [None]


def test_a_turn_elsewhere_is_none():
    """Two signs beside each other: a fit that slid to the other one has all its votes, and is another object's."""
    finder, frame, both = scene(sign(), pose(-0.15, 0, 1.5, 0.9, 0.1), pose(0.15, 0, 1.5, -0.9, 0.1))
    mirrored, of = mirrored_turns(finder, frame, both)
    assert finder.required.is_at(mirrored, both[of]).all()
    assert not finder.required.is_at(both[[0]], both[[1]]).any()


def test_each_of_several_has_its_own():
    near, far = pose(-0.12, 0, 0.5, 0.9), pose(0.3, 0, 2.0, 0.9)
    _, (first, second) = likelier_turns(*scene(sign(), near, far))
    assert first is None and second is not None and second.pose.position[2] == pytest.approx(2.0, rel=0.1)


def test_votes_and_contours_speak_for_the_true_turn():
    finder, frame, at = scene(sign(), pose(0, 0, 0.7, 0.9, 0.1))
    mirrored = finder.rest.fitted(frame, finder.required.flips(at))
    against, for_it = evidence(finder, frame, at, mirrored), evidence(finder, frame, mirrored, at)
    assert against.votes[0] < 0 < for_it.votes[0] and against.contours[0] < 0 < for_it.contours[0]
    assert against.contours[0] == pytest.approx(-for_it.contours[0])
    assert Evidence(np.zeros(1), np.zeros(1)).log_odds((-1.0, 2.0, 3.0))[0] == -1.0


PX = 1 / 300  # of a pixel a metre from the camera
PLATE = ObjectModel(
    "plate", (Component("c", (marker("m", rectangle(60 * PX, 60 * PX), RIGHT_SIDE, (0, 0, 0)),), required=True),)
)
NEAR_ALL, ON_HALF = pose(0.3 * PX, 0.6 * PX), pose(12 * PX)  # of the edges of one that is straight ahead


def ragged(background, seed):
    """Labels of a plate straight ahead, of whose border a third of the pixels are wrong."""
    labels, rng = render(CAMERA, [(PLATE, pose(), RED)], background), np.random.default_rng(seed)
    own, around = (labels == RED).astype(np.uint8), np.ones((3, 3), np.uint8)
    wrong = (cv2.dilate(own, around) > cv2.erode(own, around)) & (rng.random(own.shape) < 0.3)
    return LabelField(np.where(wrong, np.where(own, background, RED), labels).astype(np.uint8))


def half_for_all(field):
    """What contours say for the one that lies on half of its edges, and how much for the other one."""
    finder, frame = WholeObjectFinder(Target("plate", PLATE, RED), DEFAULTS), ImageFrame(field, CAMERA)
    said, back = (evidence(finder, frame, *two).contours[0] for two in ((NEAR_ALL, ON_HALF), (ON_HALF, NEAR_ALL)))
    assert back == pytest.approx(-said)
    return said


@pytest.mark.parametrize("background", [BACKGROUND, UNKNOWN], ids=["known", "empty"])
@pytest.mark.parametrize("seed", range(3))
def test_contours_that_should_lie_on_edges_and_lie_on_none_speak_against_a_place(background, seed):
    """Half of the moved one's lie better on edges than the other's, for those that do not are left out there."""
    assert half_for_all(ragged(background, seed)) < -2


def test_contours_that_another_object_may_hide_speak_against_none():
    (x, y), field = CAMERA.matrix[:2, 2], LabelField(render(CAMERA, [(PLATE, pose(), RED)]))
    beside = [np.array([(x + s * a, y + b) for a in (12, 60) for b in (-45, 45)], np.float32) for s in (-1, 1)]
    assert half_for_all(field.without(beside, nearer=True)) > 1


def test_contours_are_lost_where_labels_deny_that_anything_ends():
    labels = render(CAMERA, [(PLATE, pose(), RED)])
    middle = round(CAMERA.matrix[0, 2])

    def lost(field, at):
        """Those of a plate, and how many pixels they are right of the true one's middle."""
        finder, frame = WholeObjectFinder(Target("plate", PLATE, RED), DEFAULTS), ImageFrame(field, CAMERA)
        used = np.ones((1, 1), bool)
        fit, _, _ = finder.rest.edges(frame, at, used)
        return finder.rest.lost(frame, at, used, fit)[0, 0], fit.point[0, 0, :, 0] - middle

    assert not lost(LabelField(labels), NEAR_ALL)[0].any()
    gone, right = lost(LabelField(labels), ON_HALF)
    assert gone[np.abs(right + 18) < 2].all() and gone[np.abs(right - 42) < 2].all()
    assert not gone[(right > -13) & (right < 25)].any()
    labels[:, middle + 33 :] = UNKNOWN
    gone, right = lost(LabelField(labels, ignored=(middle + 33, 0, 500, 500)), ON_HALF)
    assert gone[np.abs(right + 18) < 2].all() and not gone[right > 32].any()
    gone, right = lost(LabelField(labels), pose(170 * PX))  # partly beyond the image
    assert gone[right < 141].all() and not gone[right > labels.shape[1] - middle].any()


@pytest.mark.parametrize(("model", "least"), [(sign(), 0.8), (slide(), 0.5)])
def test_it_is_told_and_the_covariance_counts_it(model, least):
    finder, frame, at = scene(model, pose(0, 0, 2.0, 0.9, 0.1, model))
    (detection,) = Describer(finder).describe(list(verdicts_of(claims_of(finder, at, frame))), frame)
    other = detection.other_turn
    assert turn_between(other.pose.rotation, detection.pose.rotation) > 1.5
    assert other.joints.keys() == detection.joints.keys()
    assert np.sqrt(np.trace(detection.pose_covariance[3:, 3:])) > least
    near, close, there = scene(sign(), pose(0, 0, 0.35, 0.9, 0.1))
    (sure,) = Describer(near).describe(list(verdicts_of(claims_of(near, there, close))), close)
    assert sure.other_turn is None and np.sqrt(np.trace(sure.pose_covariance[3:, 3:])) < 0.2


def beetle():
    """A box with a flap of one class on either side, and a small head of another one above its middle plane."""
    trunk = Box(Pose.identity(), np.array([0.2, 0.1, 0.04]))
    head = Box(Pose.from_xyz_rpy((0.115, 0, 0.015)), np.array([0.03, 0.05, 0.03]))
    parts = [Component("trunk", box_solid(trunk)[0], required=True, bodies=(trunk,))]
    parts.append(Component("head", box_solid(head)[0], label=BLUE, bodies=(head,)))
    for name, side in (("left", 1), ("right", -1)):
        leg = Box(Pose.from_xyz_rpy((0, 0.06 * side, 0)), np.array([0.03, 0.11, 0.02]))
        hinge = Joint("trunk", Pose.from_xyz_rpy((0, 0.05 * side, 0)), np.array([0.0, 0.0, 1.0]), -0.5, 0.5)
        parts.append(Component(name, box_solid(leg)[0], label=BODY, joint=hinge, bodies=(leg,)))
    return ObjectModel("beetle", tuple(parts))


def test_half_a_turn_of_a_box_is_told_by_what_it_bears_out():
    """Its flaps lie where they did, bent the other way; its head is where the other pose has nothing."""
    model, from_above = beetle(), np.array([[0, 1, 0], [0.6, 0, -0.8], [-0.8, 0, -0.6]], float)
    R, q = from_above @ rotation_from_rotvec([0, 0, 0.8]), np.array([[0.3, -0.1]])
    at = Poses(R[None], np.array([[0.0, 0.0, 0.9]]), q)
    finder, frame, at = scene(model, at)
    wrong = finder.rest.fitted(frame, Poses(R[None] @ np.diag([1.0, -1.0, -1.0]), at.t, q[:, ::-1] * -1))
    told, (other,) = likelier_turns(finder, frame, wrong)
    assert turn_between(told.R[0], R) < 0.1 and np.allclose(told.q, q, atol=0.1)
    assert other is None or other.probability < 0.3
    told, _ = likelier_turns(finder, frame, finder.rest.fitted(frame, at))
    assert turn_between(told.R[0], R) < 0.1


def test_a_turn_after_which_all_looks_the_same_is_no_other_one():
    brick = Box(Pose.identity(), np.array([0.2, 0.1, 0.04]))
    model = ObjectModel("brick", (Component("brick", box_solid(brick)[0], required=True, bodies=(brick,)),))
    assert len(WholeObjectFinder(Target("brick", model, RED), DEFAULTS).in_place) == 0
    assert len(WholeObjectFinder(Target("beetle", beetle(), RED), DEFAULTS).in_place) == 3
