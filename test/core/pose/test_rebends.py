"""Joints that carry joints, sought together."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, pose, rectangle, render, truck

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.climber import Climb
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.ranked import Ranked
from artrec_ros.core.pose.rebends import Rebends

CAMERA = camera_of()


def plate(name, outline, at=(0.0, 0.0, 0.0)):
    side = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
    points = outline.min(axis=0), outline.max(axis=0)
    return Marker(name, outline, *points, T_component_marker=Pose(side, np.array(at)))


def arm():
    """An upper link that leans to the camera or away from it, and below it a lower one that swings in its plane."""
    base = Component("base", (plate("face", rectangle(0.16, 0.1)),), required=True)
    lean = Joint("base", Pose.from_xyz_rpy((0.0, 0.0, 0.06)), np.array([1.0, 0, 0]), -1.2, 1.2)
    swing = Joint("upper", Pose.from_xyz_rpy((0.0, 0.0, 0.16)), np.array([0.0, 1.0, 0.0]), -1.4, 1.4)
    link = rectangle(0.03, 0.14, (0.0, 0.08))
    return ObjectModel(
        "arm",
        (
            base,
            Component("upper", (plate("face", link),), joint=lean),
            Component("fore", (plate("face", link),), joint=swing),
        ),
    )


@pytest.fixture(scope="module")
def finder():
    return WholeObjectFinder(Target("arm", arm(), RED), DEFAULTS)


def ranked(finder, frame, poses):
    return Ranked(poses, finder.voter.votes(frame, poses, occlusion=True))


@pytest.mark.parametrize("lean", [0.8, -0.8])
def test_what_hangs_on_a_link_tells_which_way_it_leans(finder, lean):
    truth = pose(0.0, 0.05, 0.7, 0.2, model=arm(), joints={"upper": lean, "fore": 0.9})
    wrong = pose(0.0, 0.05, 0.7, 0.2, model=arm(), joints={"upper": -lean, "fore": -1.3})
    frame = ImageFrame(LabelField(render(CAMERA, [(arm(), truth, RED)])), CAMERA)
    found = ranked(finder, frame, wrong)
    better = finder.bending.bent(frame, found, Climb(1, 4, 1.0))
    best = ranked(finder, frame, truth).votes[0]
    assert found.votes[0] < 0.8 * best
    assert better.votes[0] > 0.95 * best and len(better) == 2
    np.testing.assert_allclose(better.poses.q[0], truth.q[0], atol=0.08)
    assert finder.bending.bent(frame, better[:1], Climb(1, 4, 1.0)).votes[0] == better.votes[0]


def rebends_of(model):
    finder = WholeObjectFinder(Target(model.name, model, RED), DEFAULTS)
    return Rebends(finder.surface, DEFAULTS.search, DEFAULTS.votes.hidden_cost)


def test_joints_that_carry_none_are_left_to_the_climb():
    assert not rebends_of(truck()).any
    assert rebends_of(arm()).any


def chain(n):
    """Equal links, every other one of which leans to the camera or away from it: one that leans the wrong way lies on
    its own labels, and those that follow lie on their neighbours'."""
    link, base = (
        rectangle(0.03, 0.034, (0.0, 0.02)),
        Component("head", (plate("face", rectangle(0.1, 0.06)),), required=True),
    )
    parts = [base]
    for k in range(n):
        at = (0.0, 0.0, 0.03) if k == 0 else (0.0, 0.0, 0.04)
        axis = np.array([1.0, 0, 0]) if k % 2 == 0 else np.array([0.0, 1.0, 0.0])
        joint = Joint(parts[-1].name, Pose.from_xyz_rpy(at), axis, -0.6, 0.6)
        parts.append(Component(f"link_{k}", (plate("face", link),), joint=joint))
    return ObjectModel("chain", tuple(parts))


@pytest.mark.parametrize(
    "q", [(-0.5, 0.2, 0.5, -0.1, -0.5, 0.2, 0.5, -0.2), (-0.5, 0.2, -0.5, 0.5, 0.5, 0.4, 0.5, 0.5)]
)
def test_several_ways_side_by_side_find_what_joint_by_joint_misses(q):
    model = chain(8)
    finder = WholeObjectFinder(Target("chain", model, RED), DEFAULTS)
    joints = dict(zip([c.name for c in model.components[1:]], q, strict=True))
    truth = pose(0.0, 0.12, 0.6, 0.2, model=model, joints=joints)
    straight = pose(0.0, 0.12, 0.6, 0.2, model=model, joints={})
    frame = ImageFrame(LabelField(render(CAMERA, [(model, truth, RED)])), CAMERA)

    def best_of(ways):
        search = replace(DEFAULTS.search, bend_ways=ways)
        bent = Rebends(finder.surface, search, DEFAULTS.votes.hidden_cost).of(frame, straight)
        assert len(bent) <= ways and len(np.unique(bent.q.round(3), axis=0)) == len(bent)
        return finder.voter.votes(frame, bent, occlusion=True).max()

    most = finder.voter.votes(frame, truth, occlusion=True)[0]
    assert best_of(DEFAULTS.search.bend_ways) > 0.9 * most
    assert best_of(1) < 0.75 * most


def found_and_true(seed):
    """A chain's links about its mirrored head, found after a climb; the image, and where it is."""
    model, rng = chain(8), np.random.default_rng(seed)
    finder = WholeObjectFinder(Target("chain", model, RED), DEFAULTS)
    joints = {c.name: q for c, q in zip(model.components[1:], rng.uniform(-0.55, 0.55, 8), strict=True)}
    truth = pose(0.0, 0.12, 0.6, 0.6 if seed % 2 else -0.6, model=model, joints=joints)
    frame = ImageFrame(LabelField(render(CAMERA, [(model, truth, RED)])), CAMERA)
    bent = ranked(finder, frame, finder.bending._rebends.of(frame, finder.required.flips(truth)))
    best = finder.polished(frame, bent[[int(np.argmax(bent.votes))]], Climb(1, 11, 1.0))
    return finder, frame, best.best(1, DEFAULTS.search), truth


@pytest.mark.parametrize("seed", [4, 9, 13])
def test_joints_are_sought_for_the_mirrored_turn_of_the_head_too(seed):
    """With those of the wrong turn the right one has few votes."""
    finder, frame, wrong, truth = found_and_true(seed)
    best = ranked(finder, frame, truth).votes[0]
    assert wrong.votes[0] < 0.8 * best
    better = finder.bending.bent(frame, wrong, Climb(3, 13, 0.7))
    assert better.votes[0] > (1 - DEFAULTS.search.bend_least) * best
    np.testing.assert_allclose(better.poses.q[0], truth.q[0], atol=0.1)


def test_where_parts_are_not_on_their_labels_other_beginnings_are_bent_too():
    finder, frame, wrong, truth = found_and_true(0)
    astray = pose(0.0, 0.12, 0.9, 0.0, 1.5, model=chain(8), joints={})
    begun = Poses(truth.R, truth.t, astray.q)
    best, climb = ranked(finder, frame, truth), Climb(3, 13, 0.7)
    found = finder.bending.bent(frame, ranked(finder, frame, astray), climb)[:1]
    assert found.votes[0] < 0.2 * best.votes[0]
    assert finder.bending.bent(frame, found, climb, begun).votes[0] > best.votes[0]
    assert len(finder.bending.bent(frame, best, climb, wrong.poses)) == 1  # nothing is left to be explained


def leaning(name, parent, at, axis=(1.0, 0, 0), limit=0.6):
    joint = Joint(parent, Pose.from_xyz_rpy(at), np.array(axis, float), -limit, limit)
    return Component(name, (plate("face", rectangle(0.03, 0.05, (0.0, 0.028))),), joint=joint)


def bends_of(model, q, ways=16, labels=None):
    """Ways to bend an object that shows with joints `q`, from straight ones; and its true joints."""
    finder = WholeObjectFinder(Target(model.name, model, RED), DEFAULTS)
    truth, straight = (pose(0.0, 0.1, 0.5, 0.2, model=model, joints=joints) for joints in (q, {}))
    labels = render(CAMERA, [(model, truth, RED)]) if labels is None else labels
    rebends = Rebends(finder.surface, replace(DEFAULTS.search, bend_ways=ways), DEFAULTS.votes.hidden_cost)
    frame = ImageFrame(LabelField(labels), CAMERA)
    bent = rebends.of(frame, straight)
    return bent.q, truth.q[0], finder.voter.votes(frame, bent, occlusion=True)


def test_fingers_that_hang_on_one_palm_know_nothing_of_each_other():
    """Of each the best way stays before the next one is looked at."""
    parts, q = [Component("palm", (plate("face", rectangle(0.28, 0.05)),), required=True)], {}
    for k, x in enumerate((-0.12, -0.04, 0.04, 0.12)):
        parts += [
            leaning(f"near_{k}", "palm", (x, 0.0, 0.026)),
            leaning(f"far_{k}", f"near_{k}", (0.0, 0.0, 0.06), (0, 1.0, 0)),
        ]
        q |= {f"near_{k}": 0.5 if k % 2 else -0.5, f"far_{k}": 0.4}
    found, truth, votes = bends_of(ObjectModel("hand", tuple(parts)), q)
    np.testing.assert_allclose(found[np.argmax(votes)], truth, atol=0.25)
    assert len(np.unique(found[:, :6], axis=0)) == 1 < len(found)  # of the last one more than one way is followed


def test_a_fixed_link_between_joints_counts():
    """The links before and behind it face away."""
    away = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]], float)
    small, wide = rectangle(0.03, 0.05, (0.0, 0.028)), rectangle(0.12, 0.03, (0.0, 0.02))
    back = replace(plate("face", small), T_component_marker=Pose(away, np.zeros(3)))
    fixed = Joint("near", Pose.from_xyz_rpy((0.0, 0.0, 0.06)), np.array([1.0, 0, 0]), 0.0, 0.0, kind="fixed")
    lean, turn = (leaning("near", "base", (0.0, 0.0, 0.026)).joint, leaning("far", "bar", (0.0, 0.0, 0.04)).joint)
    base = Component("base", (plate("face", rectangle(0.16, 0.05)),), required=True)
    near = Component("near", (back,), joint=lean)
    bar = Component("bar", (plate("face", wide),), joint=fixed)
    far = Component("far", (back,), joint=turn)
    for angle in (0.5, -0.5):
        found, truth, _ = bends_of(ObjectModel("arm", (base, near, bar, far)), {"near": angle, "far": 0.3})
        assert abs(found[0, 0] - truth[0]) < 0.25


def test_where_a_joint_goes_round_both_ends_are_one_place():
    model = ObjectModel(
        "dial",
        (
            Component("base", (plate("face", rectangle(0.16, 0.05)),), required=True),
            leaning("near", "base", (0.0, 0.0, 0.026)),
            leaning("far", "near", (0.0, 0.0, 0.06), (0, 1.0, 0), np.pi),
        ),
    )
    found, truth, votes = bends_of(model, {"near": 0.4, "far": 3.12})
    assert abs(np.angle(np.exp(1j * (found[np.argmax(votes)] - truth)))).max() < 0.25
    found, _, _ = bends_of(model, {}, labels=np.zeros((240, 320), np.uint8))
    assert len(np.unique(np.exp(1j * found).round(6), axis=0)) == len(found)
