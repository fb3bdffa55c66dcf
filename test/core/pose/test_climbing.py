"""Climbing and sweeping on the votes: never worse, up the hill, within the joints' limits, and ended by the clock."""

from dataclasses import replace

import numba
import numpy as np
import pytest
from settings import DEFAULTS
from solids import BODY, RED, camera_of, chain, jolted, pose, render, sign, slide

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import climb_kernels as climbing
from artrec_ros.core.pose.climber import Climb
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.ranked import Ranked

pytestmark = pytest.mark.uncompiled
CAMERA, SEARCH = camera_of((96, 72), 90.0), DEFAULTS.search
MODEL = chain()
TRUTH = pose(0.05, 0.02, 0.6, 0.3, model=MODEL, joints={"arm": 0.2, "rod": 0.05, "finger": 0.5})


class Looks(Deadline):
    """Is over after so many looks at the clock."""

    def __init__(self, looks):
        super().__init__()
        self._left = looks

    @property
    def expired(self):
        self._left -= 1
        return self._left < 0


@pytest.fixture(scope="module")
def finder():
    return WholeObjectFinder(Target("chain", MODEL, RED), DEFAULTS)


@pytest.fixture(scope="module")
def frame():
    return ImageFrame(LabelField(render(CAMERA, [(MODEL, TRUTH, RED)])), CAMERA)


def start(n=3, seed=0):
    poses = jolted(np.random.default_rng(seed), TRUTH, n, 0.01, 0.1, 0.05)
    kin = WholeObjectFinder(Target("chain", MODEL, RED), DEFAULTS).surface.kinematics
    poses.q[:] = np.clip(poses.q, kin.lower, kin.upper)
    return poses


def votes_of(finder, frame, poses):
    return finder.voter.votes(frame, poses, occlusion=True)


def ranked(finder, frame, poses):
    return Ranked(poses, votes_of(finder, frame, poses))


def climbed(finder, frame, poses, rounds, spread=1.0):
    """Poses and their votes after a climb."""
    found = finder.climber.climb(frame, ranked(finder, frame, poses), Climb(len(poses), rounds, spread))
    return found.poses, found.votes


def same(one, other):
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in ("R", "t", "q"))


def test_the_search_climbs_and_no_hypothesis_gets_worse(finder, frame):
    poses = start(n=4)
    before = votes_of(finder, frame, poses)
    found, votes = climbed(finder, frame, poses, 4)
    assert (votes >= before).all() and np.median(votes - before) > 20
    np.testing.assert_allclose(votes_of(finder, frame, found), votes, rtol=1e-9)
    np.testing.assert_allclose(found.R @ found.R.transpose(0, 2, 1), np.tile(np.eye(3), (4, 1, 1)), atol=1e-9)
    kin = finder.surface.kinematics
    assert (found.q >= kin.lower).all() and (found.q <= kin.upper).all()


def test_each_hypothesis_climbs_alone(finder, frame):
    poses = start()
    together, _ = climbed(finder, frame, poses, 1)
    for h in range(len(poses)):
        assert same(climbed(finder, frame, poses[[h]], 1)[0], together[[h]])
    assert same(poses, start())  # what was handed in is as it was


def test_the_clock_ends_a_climb_between_two_hypotheses(finder, frame):
    poses = start(n=3)
    whole, _ = climbed(finder, frame, poses, 9)
    for done in (0, 1, 2):
        ended, votes = climbed(finder, replace(frame, deadline=Looks(done)), poses, 9)
        assert same(ended[:done], whole[:done]) and same(ended[done:], poses[done:])
        np.testing.assert_allclose(votes_of(finder, frame, ended), votes, rtol=1e-9)


def curtain(boxes):
    """A plate, and before it a bar of so many boxes in a row that slides aside."""
    base, bar = slide().components
    row = np.linspace(-0.06, 0.06, boxes) if boxes > 1 else [0.0]
    bodies = tuple(Box(Pose.from_xyz_rpy((x, 0.02, 0.0)), np.array([0.13 / boxes, 0.02, 0.07])) for x in row)
    joint = Joint("plate", Pose.from_xyz_rpy((0, -0.05, 0)), np.array([1.0, 0, 0]), -0.4, 0.4, "prismatic")
    return ObjectModel("curtain", (base, replace(bar, joint=joint, bodies=bodies, body_label=BODY)))


COMPILED = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="so many boxes take long as plain Python")
MANY = pytest.param(66, 0.36, 0.02, marks=COMPILED)


@pytest.mark.parametrize(("boxes", "begun", "truth"), [(1, 0.0, 0.36), (1, 0.36, 0.02), MANY])
def test_votes_that_are_counted_anew_in_part_are_those_of_the_whole(boxes, begun, truth):
    """Of what a joint's move shows, and of what it hides; of 66 boxes some share a bit."""
    model, camera = curtain(boxes), camera_of((110, 36), 40.0)
    finder, at = WholeObjectFinder(Target("curtain", model, RED), DEFAULTS), pose(0, 0, 0.4, 0.2, model=model)
    frame = ImageFrame(LabelField(render(camera, [(model, replace(at, q=np.array([[truth]])), RED)])), camera)
    start = ranked(finder, frame, replace(at, q=np.array([[begun]])))
    swept = finder.climber.sweep(frame, start)
    assert abs(swept.poses.q[0, 0] - truth) < 0.06
    np.testing.assert_allclose(votes_of(finder, frame, swept.poses), swept.votes, rtol=1e-9)
    found, votes = climbed(finder, frame, start.poses, 1, 2.0)
    assert not same(found, start.poses)
    np.testing.assert_allclose(votes_of(finder, frame, found), votes, rtol=1e-9)


def test_where_nothing_is_better_nothing_moves(finder):
    poses, nothing = start(), ImageFrame(LabelField(np.zeros((1, 1), np.uint8)), CAMERA)  # all of it lies outside
    found, votes = climbed(finder, nothing, poses, 2)
    assert same(found, poses) and not votes.any()


def test_steps_too_short_to_matter_end_a_climb(finder, frame):
    poses = start()
    assert same(climbed(finder, frame, poses, 9, spread=SEARCH.least_step / 2)[0], poses)


def test_nothing_to_climb_and_an_object_without_joints(finder, frame):
    none = start()[np.zeros(0, int)]
    found, votes = climbed(finder, frame, none, 3)
    assert len(found) == len(votes) == 0
    at = pose(0, 0, 0.5, 0.2, model=sign())
    lone = WholeObjectFinder(Target("sign", sign(), RED), DEFAULTS)
    seen = ImageFrame(LabelField(render(CAMERA, [(sign(), at, RED)])), CAMERA)
    near = jolted(np.random.default_rng(1), at, 2, 0.02, 0.05, 0.0)
    found, votes = climbed(lone, seen, near, 3)
    assert (votes > votes_of(lone, seen, near)).all() and found.q.shape == (2, 0)


def moved(z, lower=(-1.0, 0.0), upper=(1.0, 2 * np.pi), endless=(False, True)):
    """t and q (2,) after a step z (8,) from (.1, .2, 2) and (.9, 6)."""
    steps = climbing.Steps(1.5, 0.03, 0.12, 0.15, 1.6, -0.7, 0.01)
    m = climbing.Moves(
        steps, 100.0, 0.0, np.inf, np.array(lower), np.array(upper), np.array([1.0, 1.0]), np.array(endless)
    )
    tried = climbing.Tried(np.empty((3, 3)), np.empty(3), np.empty(2), np.empty((3, 3, 3)))
    climbing.move(m, np.array(z, float), np.eye(3), np.array([0.1, 0.2, 2.0]), np.array([0.9, 6.0]), tried)
    return tried


def test_a_step_is_measured_in_pixels_in_shares_of_depth_in_radians_and_in_joints_units():
    aside, near, turned = moved(np.eye(8)[0] * 2), moved(np.eye(8)[2] * -1), moved(np.eye(8)[5] * 0.5)
    np.testing.assert_allclose(aside.t, (0.1 + 2 * 1.5 / 100 * 2.0, 0.2, 2.0))
    np.testing.assert_allclose(near.t, np.array([0.1, 0.2, 2.0]) * (1 - 0.03))
    angle = 0.5 * 0.12
    np.testing.assert_allclose(turned.R[0], (np.cos(angle), -np.sin(angle), 0.0))
    np.testing.assert_allclose(moved(np.eye(8)[6] * -2).q, (0.9 - 2 * 0.15, 6.0))


def test_joints_stop_at_their_limits_or_go_round():
    np.testing.assert_allclose(moved([0] * 6 + [4, 4]).q, (1.0, (6.0 + 4 * 0.15) % (2 * np.pi)))
    np.testing.assert_allclose(moved([0] * 6 + [-40, 0]).q, (-1.0, 6.0))


def test_a_sweep_brings_each_joint_in_turn_to_the_best_of_all_its_values(finder, frame):
    poses, kin = start(n=2, seed=3), finder.surface.kinematics
    poses.q[:] = kin.lower
    found = finder.climber.sweep(frame, ranked(finder, frame, poses))
    for h in range(len(poses)):
        best = poses[[h]]
        for j in range(kin.n_joints):
            tries = [best.q[0, j], *kin.grid(j, SEARCH.joint_step)]
            several = best[np.zeros(len(tries), int)]
            several.q[:, j] = tries
            best = several[[int(votes_of(finder, frame, several).argmax())]]
        np.testing.assert_array_equal(found.poses.q[h], best.q[0])
        assert found.votes[h] == pytest.approx(votes_of(finder, frame, best)[0])
    assert (found.poses.q != poses.q).any() and np.array_equal(found.poses.t, poses.t)


def test_the_clock_ends_a_sweep_between_some_hypotheses_and_the_next(finder, frame):
    poses = start(n=9, seed=3)
    poses.q[:] = finder.surface.kinematics.lower
    begun = ranked(finder, frame, poses)
    whole = finder.climber.sweep(frame, begun).poses
    first = finder.climber.sweep(replace(frame, deadline=Looks(1)), begun).poses
    np.testing.assert_array_equal(first.q[:8], whole.q[:8])
    np.testing.assert_array_equal(first.q[8:], poses.q[8:])


def test_a_component_that_speaks_against_itself_counts_as_hidden_at_a_price(finder, frame):
    poses = start(n=8, seed=1)
    poses.q[4:] = finder.surface.kinematics.lower
    surface, scores = finder.surface, finder.voter.judge(frame, poses, occlusion=True)
    expected, dear = np.zeros(8), 0
    for c in range(len(MODEL.components)):
        mine = surface.component == c
        votes = scores.votes[:, mine].sum(axis=1)
        price = -DEFAULTS.votes.hidden_cost * scores.area_px[:, mine & surface.is_marker].sum(axis=1)
        expected += votes if c == surface.root else np.maximum(votes, price)
        dear += int((votes < price).sum())
    assert dear
    np.testing.assert_allclose(finder.voter.total(scores), expected, rtol=1e-9)
    np.testing.assert_allclose(votes_of(finder, frame, poses), expected, rtol=1e-9)
