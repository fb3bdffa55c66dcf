"""A marker that leans from the camera may lean towards it: what is seen tells, or the joint's deviation counts it."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import BLUE, CAB, RED, RIGHT_SIDE, camera_of, marker, pose, rectangle, render, slide, truck

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import other_bends as module
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_bends import Bends, likelier_bends, other_bends
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.claims import claims_of
from artrec_ros.core.verdict.descriptions import Describer
from artrec_ros.io.objects.solids import box_solid, cylinder_solid

CAMERA = camera_of()
FAR, NEAR = 3.0, 0.4


def gate(lower=-1.2):
    """A large plate, and a flag on it that swings about the vertical."""
    post = Component("post", (marker("face", CAB * 2, RIGHT_SIDE, (0, 0, 0)),), required=True)
    joint = Joint("post", Pose.from_xyz_rpy((0.21, 0, 0)), np.array([0.0, 0.0, 1.0]), lower, 1.2)
    flag = marker("face", rectangle(0.09, 0.06, (0.05, 0)), RIGHT_SIDE, (0, 0, 0))
    return ObjectModel("gate", (post, Component("flag", (flag,), label=BLUE, joint=joint)))


def seen(model, z, q, x=-0.21):
    at = pose(x, 0, z, 0.0, 0.0, model, {"flag": q})
    frame = ImageFrame(LabelField(render(CAMERA, [(model, at, RED)])), CAMERA)
    return WholeObjectFinder(Target(model.name, model, RED), DEFAULTS), frame, at


def bent(at, q):
    return Poses(at.R, at.t, np.full_like(at.q, q))


@pytest.mark.parametrize("q", [0.6, -0.6])
def test_far_off_its_variance_counts_the_other_bend(q):
    finder, frame, at = seen(gate(), FAR, q)
    told, more = likelier_bends(finder, frame, at)
    assert 0.1 * (2 * q) ** 2 < more[0, 0] < 0.6 * (2 * q) ** 2 and abs(told.q[0, 0]) == pytest.approx(0.6, abs=0.15)


@pytest.mark.parametrize("q", [0.6, -0.6])
def test_near_by_the_right_one_is_told_whichever_was_found(q):
    finder, frame, at = seen(gate(), NEAR, q, x=-0.1)
    for found in (at, finder.rest.fitted(frame, bent(at, -q))):
        told, more = likelier_bends(finder, frame, found)
        assert told.q[0, 0] == pytest.approx(q, abs=0.05) and more[0, 0] == 0


def test_it_is_bent_across_the_line_of_sight_and_within_its_limits():
    finder, frame, at = seen(gate(), 1.5, 0.6, x=0.2)
    bends = other_bends(finder, frame, at)
    sight = np.arctan2(0.2 + 0.21, 1.5)
    assert bends.joint.tolist() == [0] and bends.q[0] == pytest.approx(-0.6 - 2 * sight, abs=0.1)
    finder, frame, at = seen(gate(lower=0.0), FAR, 0.3)
    bends = other_bends(finder, frame, at)
    assert (bends.q >= 0).all()


def test_what_does_not_tip_its_marker_has_none():
    for model, joints in ((truck(), {"fore": 0.5, "hind": -0.4}), (slide(), {"bar": 0.05})):
        at = pose(0, 0, 1.0, 0.0, 0.0, model, joints)
        frame = ImageFrame(LabelField(render(CAMERA, [(model, at, RED)])), CAMERA)
        finder = WholeObjectFinder(Target(model.name, model, RED), DEFAULTS)
        told, more = likelier_bends(finder, frame, at)
        assert told is at and not more.any() and not len(other_bends(finder, frame, at).of)


@pytest.mark.parametrize("q", [0.03, 0.04, 0.05])
def test_what_slides_is_told_where_labels_like_it_better(q):
    model = slide()
    at = pose(0, 0, 1.0, 0.0, 0.0, model, {"bar": q})
    frame = ImageFrame(LabelField(render(CAMERA, [(model, at, RED)])), CAMERA)
    finder = WholeObjectFinder(Target(model.name, model, RED), DEFAULTS)
    told, _ = likelier_bends(finder, frame, bent(at, 0.0))
    np.testing.assert_allclose(told.q, at.q, atol=0.003)


@pytest.mark.parametrize("wrong", [-0.5, 0.0, 1.0])
def test_what_labels_like_better_elsewhere_is_told_there(wrong):
    model, joints = truck(), {"fore": 0.5, "hind": -0.4}
    at = pose(0, 0, 1.0, 0.0, 0.0, model, joints)
    frame = ImageFrame(LabelField(render(CAMERA, [(model, at, RED)])), CAMERA)
    finder = WholeObjectFinder(Target(model.name, model, RED), DEFAULTS)
    found = at.q.copy()
    found[0, model.joint_names.index("fore")] = wrong
    told, _ = likelier_bends(finder, frame, Poses(at.R, at.t, found))
    np.testing.assert_allclose(told.q, at.q, atol=0.03)


def test_deviations_that_are_told_count_it_while_there_is_time():
    def told(z, q, x, budget_s=100.0):
        finder, frame, at = seen(gate(), z, q, x)
        frame = replace(frame, deadline=Deadline(budget_s))
        (detection,) = Describer(finder).describe(list(verdicts_of(claims_of(finder, at, frame))), frame)
        return detection.joint_deviations["flag"]

    assert told(2.0, -0.6, -0.21) > 0.35 > 0.1 > told(NEAR, 0.6, -0.1)
    assert told(2.0, -0.6, -0.21, budget_s=-1.0) < 0.1


def two_arms():
    """A plate with two arms of two flags each: of one arm the first joint carries the second."""
    parts = [Component("post", (marker("face", CAB * 2, RIGHT_SIDE, (0, 0, 0)),), required=True)]
    for side in (-1, 1):
        parent, at = "post", Pose.from_xyz_rpy((0.21 * side, 0, 0))
        for name in ("upper", "lower"):
            flag = marker("face", rectangle(0.09, 0.06, (0.05 * side, 0)), RIGHT_SIDE, (0, 0, 0))
            joint = Joint(parent, at, np.array([0.0, 0.0, 1.0]), -1.2, 1.2)
            parts.append(Component(f"{name}{side}", (flag,), joint=joint))
            parent, at = parts[-1].name, Pose.from_xyz_rpy((0.1 * side, 0, 0))
    return ObjectModel("arms", tuple(parts))


def test_of_joints_that_carry_each_other_the_likeliest_alone_is_bent(monkeypatch):
    """Each bend brought with it what it carries; both together are a pose that nobody has judged."""
    finder, frame, at = seen(two_arms(), 1.5, 0.0)
    there = np.array([[0.5, -0.4, 0.1, 0.2], [0.1, 0.3, 0.0, 0.0], [0.0, 0.0, -0.6, 0.7]])  # each at rest by itself
    bends = Bends(
        Poses(np.repeat(at.R, 3, 0), np.repeat(at.t, 3, 0), there),
        np.zeros(3, int),
        np.array([0, 1, 2]),
        np.full(3, 0.02),
    )
    monkeypatch.setattr(module, "other_bends", lambda *_: bends)

    def told(odds):
        monkeypatch.setattr(module, "bend_evidence", lambda *_: Said(np.array(odds)))
        return likelier_bends(finder, frame, at)[0].q[0].tolist()

    assert told((3.0, 2.0, -3.0)) == [0.5, -0.4, 0.1, 0.2]
    assert told((2.0, 3.0, -3.0)) == [0.1, 0.3, 0.0, 0.0]
    assert told((3.0, -3.0, 2.0)) == [0.5, -0.4, -0.6, 0.7]  # arms do not carry each other
    assert told((-3.0, -3.0, -3.0)) == [0.0, 0.0, 0.0, 0.0]
    # of two bends of one joint the other one is a rival of what is told then
    both = Bends(Poses(bends.poses.R, bends.poses.t, np.diag([0.5, 0.0, 0.0, 0.0])[[0, 0, 0]] * [[1], [-1], [1]]),
                 np.zeros(3, int), np.zeros(3, int), np.full(3, 0.02))  # fmt: skip
    monkeypatch.setattr(module, "other_bends", lambda *_: both.where(np.array([True, True, False])))
    monkeypatch.setattr(module, "bend_evidence", lambda *_: Said(np.array((8.0, 7.9))))
    poses, more = likelier_bends(finder, frame, at)
    assert poses.q[0].tolist() == [0.5, 0.0, 0.0, 0.0] and more[0, 0] == pytest.approx(0.475, abs=0.01)
    monkeypatch.setattr(module, "other_bends", lambda *_: bends)
    # the one that is not bent may be, with what it carries: beside the likelier one
    monkeypatch.setattr(module, "bend_evidence", lambda *_: Said(np.array((8.0, 9.0, -9.0))))
    poses, more = likelier_bends(finder, frame, at)
    assert poses.q[0].tolist() == [0.1, 0.3, 0.0, 0.0]
    np.testing.assert_allclose(more[0], np.array([0.4**2, 0.7**2, 0.0, 0.0]) / (1 + np.exp(1)), rtol=1e-2)
    # and what was found, where that is hardly less likely
    monkeypatch.setattr(module, "bend_evidence", lambda *_: Said(np.array((-9.0, 1.5, -9.0))))
    np.testing.assert_allclose(
        likelier_bends(finder, frame, at)[1][0], np.array([0.1**2, 0.3**2, 0.0, 0.0]) / (1 + np.exp(1.5)), rtol=1e-2
    )


def arm():
    """A plate, a box that hangs from it and swings to and from the camera, and a cylinder that hangs from that."""
    post = Component("post", (marker("face", CAB * 2, RIGHT_SIDE, (0, 0, 0)),), required=True)
    hangs = lambda m: Pose.from_xyz_rpy((0, 0, -m))  # noqa: E731
    swings = lambda parent, at, low, high: Joint(parent, Pose.from_xyz_rpy(at), np.array([1.0, 0, 0]), low, high)  # noqa: E731
    box, rod = box_solid(Box(hangs(0.08), np.array([0.04, 0.04, 0.13]))), cylinder_solid(0.018, 0.12, hangs(0.075))
    upper = Component("upper", box[0], False, BLUE, swings("post", (-0.26, 0, 0.05), -1.5, 1.5), box[1])
    fore = Component("fore", rod[0], False, FORE, swings("upper", (0, 0, -0.16), -2.0, 2.0), rod[1])
    return ObjectModel("arm", (post, upper, fore))


FORE = BLUE + 1
ARMS = [(-0.7, 1.1), (-0.7, 0.2), (0.6, -1.2), (0.6, 0.3)]


def arm_seen(upper, fore, z=1.1):
    model = arm()
    at = pose(0.26, 0, z, 0.0, 0.0, model, {"upper": upper, "fore": fore})
    frame = ImageFrame(LabelField(render(CAMERA, [(model, at, RED)])), CAMERA)
    return WholeObjectFinder(Target(model.name, model, RED), DEFAULTS), frame, at


@pytest.mark.parametrize(("upper", "fore"), ARMS)
@pytest.mark.parametrize("bent_otherwise", [{"fore"}, {"upper"}])
def test_how_a_solid_limb_leans_is_among_what_is_compared_whichever_of_its_links_was_found_mirrored(
    upper, fore, bent_otherwise
):
    finder, frame, at = arm_seen(upper, fore)
    lean = [-upper if "upper" in bent_otherwise else upper]  # of each link, from straight down
    lean.append(-(upper + fore) if "fore" in bent_otherwise else upper + fore)
    found = finder.rest.fitted(frame, Poses(at.R, at.t, np.array([[lean[0], lean[1] - lean[0]]])))
    both = np.concatenate([found.q, other_bends(finder, frame, found).poses.q])
    assert np.abs(both - at.q).max(axis=1).min() < 0.2


def test_far_off_its_variance_counts_how_its_links_may_lean_together():
    finder, frame, at = arm_seen(0.6, -1.2, z=3.0)
    more = likelier_bends(finder, frame, at)[1][0]
    assert more[0] > 0.1 * 1.2**2 and more[1] > 0.1 * 1.2**2


@pytest.mark.parametrize("sides", [slice(0, 1), slice(1, 2), slice(None)])
def test_what_reaches_out_of_a_solid_is_mirrored_whichever_of_its_sides_are_borne_out(sides):
    finder, _, at = arm_seen(-0.7, 0.2)
    surface = finder.surface
    used = np.zeros((1, len(surface.markers)), bool)
    used[0, np.flatnonzero(surface.component[surface.markers] == 2)[sides]] = True
    bends = module._across(finder, at, used)
    assert bends.joint.tolist() == [0, 1]  # what hangs on a link that is not seen tells of it
    for joint, bent, middle in zip(bends.joint, bends.poses.q, ((0, 0, -0.08), (0, 0, -0.075)), strict=True):
        was, now = (surface.kinematics.forward(at.R, at.t, q[None]) for q in (at.q[0], bent))
        sight = was.R[0, joint + 1] @ middle + was.t[0, joint + 1]
        sight /= np.linalg.norm(sight)
        lean = [frames.R[0, joint + 1, :, 2] for frames in (was, now)]
        assert lean[0] @ sight == pytest.approx(-lean[1] @ sight, abs=0.05) and abs(lean[0] @ sight) > 0.1
        np.testing.assert_allclose(lean[0] - lean[0] @ sight * sight, lean[1] - lean[1] @ sight * sight, atol=0.05)


@dataclass
class Said:
    """Evidence of known log odds."""

    odds: np.ndarray

    def log_odds(self, weights):
        return self.odds
