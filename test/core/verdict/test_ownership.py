"""Pixels that go to one object only."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import BENT, BLUE, RATIONAL, RED, StubJudge, camera_of, chain, jolted, pose, render, truck

from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.voter import Voter
from artrec_ros.core.verdict import ownership
from artrec_ros.core.verdict.claims import silhouette
from artrec_ros.core.verdict.contenders import Contenders
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.looks import Looks
from artrec_ros.core.verdict.ownership import share_out

CAMERA = camera_of()
TRUCK = truck()
LEFT = pose(-0.25, 0, 1.0, 0.3, model=TRUCK)
RIGHT = pose(0.25, 0.02, 1.1, -0.4, model=TRUCK, joints={"hind": 0.3})
JUDGE = StubJudge()


def candidates(finder, frame, poses):
    votes = finder.voter.votes(frame, poses, occlusion=True)
    order = np.argsort(-votes, kind="stable")
    return poses[order]


def image_of_two():
    return ImageFrame(LabelField(render(CAMERA, [(TRUCK, LEFT, RED), (TRUCK, RIGHT, RED)])), CAMERA)


def crowd(seed=0, n=6):
    rng = np.random.default_rng(seed)
    return Poses.concatenate([LEFT, jolted(rng, LEFT, n, 0.01, 0.1, 0.1), RIGHT, jolted(rng, RIGHT, n, 0.01, 0.1, 0.1)])


@pytest.mark.parametrize("seed", range(3))
def test_each_object_is_claimed_once_however_many_candidates_it_has(seed):
    frame = image_of_two()
    finder = WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)
    found = [(finder, candidates(finder, frame, crowd(seed)))]
    accepted = share_out(found, frame, JUDGE).accepted
    assert len(accepted) == 2
    for truth in (LEFT, RIGHT):
        assert sum(np.linalg.norm(v.claim.poses.t - truth.t) < 0.05 for v in accepted) == 1


@pytest.mark.parametrize(
    "near, far, meet",
    [
        (pose(0.05, 0, 0.8, 0.2, model=TRUCK), pose(0.2, 0, 1.2, 0.2, model=TRUCK), True),
        (pose(-0.02, 0, 0.8, 0.2, model=TRUCK), pose(0.2, 0, 1.2, 0.2, model=TRUCK), True),
        (LEFT, RIGHT, False),
    ],
    ids=["half in front", "touching", "apart"],
)
def test_a_claim_is_judged_by_pixels_that_no_claim_before_it_owns(near, far, meet):
    frame = ImageFrame(LabelField(render(CAMERA, [(TRUCK, near, RED), (TRUCK, far, RED)])), CAMERA)
    finder = WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)
    poses = Poses.concatenate([near, far])
    accepted = share_out([(finder, candidates(finder, frame, poses))], frame, JUDGE).accepted
    assert len(accepted) == 2
    before = [v.claim.votes for v in accepted]
    assert before == sorted(before, reverse=True)
    assert [v.owners for v in accepted] == [(), (accepted[0],) if meet else ()]
    left = frame
    for claim in (v.claim for v in accepted):
        expected = finder.voter.judge(left, claim.poses, occlusion=True)
        np.testing.assert_allclose(claim.scores.votes, expected.votes, rtol=1e-6, atol=1e-6)
        assert claim.votes == pytest.approx(float(finder.voter.votes(left, claim.poses, occlusion=True)[0]))
        left = left.without(silhouette(finder.surface, CAMERA, claim.poses))
    alone = finder.voter.votes(frame, accepted[1].claim.poses, occlusion=True)[0]
    assert (accepted[1].claim.votes != pytest.approx(float(alone))) == meet  # what they share went to the first


@pytest.mark.parametrize(("owned", "free"), [(0.3, True), (0.9, False)])
def test_what_others_leave_of_their_rims_in_space_is_no_object(owned, free):
    finder, judge = (
        WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS),
        replace(Judge.of(DEFAULTS), min_votes=-1e6),
    )
    frame = image_of_two()
    middles = [(hull, hull.mean(axis=0)) for hull in silhouette(finder.surface, CAMERA, LEFT)]
    rest = frame.without([np.float32(middle + np.sqrt(owned) * (hull - middle)) for hull, middle in middles])
    (verdict,) = judge.verdicts(finder, LEFT, rest)
    assert (judge.reason(verdict) != "almost all of it lies where others are found") == free


def test_targets_compete_for_pixels():
    frame = image_of_two()
    finders = [WholeObjectFinder(Target(name, TRUCK, RED), DEFAULTS) for name in ("one", "other")]
    found = [(f, candidates(f, frame, crowd())) for f in finders]
    accepted = share_out(found, frame, JUDGE).accepted
    assert len(accepted) == 2
    blue = WholeObjectFinder(Target("blue", TRUCK, BLUE), DEFAULTS)
    accepted = share_out([(blue, candidates(blue, frame, crowd()))], frame, JUDGE).accepted
    assert accepted == []


class CountingJudge(StubJudge):
    """Notes how many hypotheses it is asked about at once."""

    def verdicts(self, finder, poses, frame, seen=None):
        ASKED.append(len(poses))
        return super().verdicts(finder, poses, frame, seen)


ASKED: list[int] = []


def test_pixels_are_shared_out_anew_without_a_second_look_at_what_nobody_owns():
    frame, judge, looks = image_of_two(), CountingJudge(), Looks()
    finder = WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)
    found, more = ((finder, candidates(finder, frame, crowd(seed, n))) for seed, n in ((0, 6), (1, 3)))
    share_out([found], frame, judge, looks)
    ASKED.clear()
    accepted = share_out([found, more], frame, judge, looks).accepted
    assert len(more[1]) in ASKED and len(found[1]) not in ASKED
    anew = share_out([found, more], frame, JUDGE).accepted
    assert [v.claim.votes for v in accepted] == [v.claim.votes for v in anew]


def test_a_hypothesis_is_judged_once_in_one_frame():
    frame, judge = image_of_two(), CountingJudge().in_one_frame()
    finder = WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)
    rest = frame.without(silhouette(finder.surface, CAMERA, LEFT))
    ASKED.clear()
    trust = [judge.trust_and_place(finder, LEFT, look) for look in (frame, frame.unhurried(), rest, rest)]
    assert ASKED == [1, 1] and trust[0] == trust[1] != trust[2] == trust[3]


def test_what_is_not_accepted_takes_no_pixels_and_is_named_once_a_place():
    frame = image_of_two()
    finder = WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)
    found = [(finder, candidates(finder, frame, crowd()))]
    accepted, others, _ = share_out(found, frame, StubJudge(given=lambda verdict: 0.0))
    assert accepted == [] and len(others) == 2
    left_only = StubJudge(given=lambda verdict: float(verdict.claim.poses.t[0, 0] < 0))
    accepted, others, _ = share_out(found, frame, left_only)
    assert len(accepted) == 1 and len(others) == 1
    assert accepted[0].claim.poses.t[0, 0] < 0 < others[0].claim.poses.t[0, 0]
    whole = finder.voter.votes(frame, others[0].claim.poses, occlusion=True)[0]
    assert others[0].claim.votes == pytest.approx(float(whole))


def test_nothing_found_gives_nothing():
    frame = image_of_two()
    finder = WholeObjectFinder(Target("chain", chain(), RED), DEFAULTS)
    none = pose(model=chain())[np.zeros(0, int)]
    for found in ([], [(finder, none)]):
        accepted, others, _ = share_out(found, frame, JUDGE)
        assert list(accepted) == list(others) == []
    far_off = candidates(finder, frame, pose(5.0, model=chain()))
    accepted, others, _ = share_out([(finder, far_off)], frame, JUDGE)
    assert list(accepted) == list(others) == []


@pytest.mark.parametrize("lens", [(), BENT], ids=len)
def test_claims_that_stand_apart_are_not_judged_again(lens, monkeypatch):
    camera = camera_of(distortion=lens)
    frame = ImageFrame(LabelField(render(camera, [(TRUCK, LEFT, RED), (TRUCK, RIGHT, RED)])), camera)
    finder, judged = WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS), []
    judge = finder.voter.judge
    monkeypatch.setattr(finder.voter, "judge", lambda f, poses, **k: judged.append(len(poses)) or judge(f, poses, **k))
    turns = [rotation_from_rotvec(np.array([0.0, turn, 0.0])) for turn in (0.4, 0.5, 0.6)]
    rivals = Poses.concatenate([Poses(turn @ LEFT.R, LEFT.t, LEFT.q) for turn in turns])
    accepted = share_out([(finder, Poses.concatenate([LEFT, RIGHT, rivals]))], frame, JUDGE).accepted
    assert len(accepted) == 2
    assert judged == [5, 3]  # all of them; then the left one's rivals


def shared_with_a_larger_one(unseen):
    """What is told and what is not where two trucks stand, and a hypothesis of one of them that is a little larger."""
    larger, finder = Poses(LEFT.R, 0.9 * LEFT.t, LEFT.q), WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)
    frame = ImageFrame(LabelField(render(CAMERA, [(TRUCK, larger, RED), (TRUCK, RIGHT, RED)])), CAMERA)
    smaller_first = StubJudge(
        min_votes=1.0, unseen=unseen, given=lambda verdict: 1.0 if verdict.claim.poses.t[0, 2] > 0.95 else 0.1
    )
    return share_out([(finder, Poses.concatenate([LEFT, larger, RIGHT]))], frame, smaller_first)


@pytest.mark.parametrize("cleared", [True, False])
def test_what_an_object_leaves_of_itself_is_no_other_one(monkeypatch, cleared):
    """A hypothesis that is a little larger has a rim that the object does not own."""
    if not cleared:
        monkeypatch.setattr(ownership._Field, "_clear", lambda *args: None)
    accepted = shared_with_a_larger_one(unseen=True).accepted
    assert len(accepted) == (2 if cleared else 3)


def test_one_whose_required_component_is_out_of_sight_is_told_only_where_that_is_asked_for(monkeypatch):
    monkeypatch.setattr(ownership._Field, "_clear", lambda *args: None)
    accepted, others, _ = shared_with_a_larger_one(unseen=False)
    assert len(accepted) == 2
    assert [v.without_required for v in others] == ["is out of sight"]


@pytest.mark.parametrize("lens", [(), BENT, RATIONAL, (-0.3, 0.1)], ids=len)
def test_no_pixel_that_votes_look_at_lies_outside_of_a_claims_box(lens):
    """Whatever the lens bends out between corners: else a claim would not be judged again that an owner touches."""
    camera, finder = camera_of(distortion=lens), WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)
    rng, surface = np.random.default_rng(5), finder.surface
    poses = jolted(rng, pose(0, 0, 0.3, 0.3, model=TRUCK), 200, 0.08, 0.8, 0.6)  # as large as the image
    frames = surface.kinematics.forward(poses.R, poses.t, poses.q)
    points = np.concatenate([np.concatenate([p.inside, p.contour]) for p in surface.patches])
    component = np.concatenate([np.full(len(p.inside) + len(p.contour), p.component) for p in surface.patches])
    seen = project(camera, surface.place(frames, points, component))
    low, high = Contenders.of(finder, poses, camera).boxes.transpose(1, 0, 2)[:, :, None]
    reach = DEFAULTS.votes.ring_px + 0.5  # of a ring's point and its rounding
    held = ((seen - reach >= low) & (seen + reach <= high)).all(axis=(1, 2))
    in_view = (np.abs(seen) < 700).all(axis=(1, 2))  # and not beside the camera or behind it
    assert in_view.sum() > 100 and held[in_view].all()


def test_claims_keep_their_order_when_some_are_judged_again():
    """Which of two equal claims goes first does not hang on what was judged before."""
    frame = image_of_two()
    finders = [WholeObjectFinder(Target(name, TRUCK, RED), DEFAULTS) for name in ("one", "other")]
    far = pose(-0.25, -0.02, 2.2, 0.3, model=TRUCK)  # behind the left one: its votes fall when that owns its pixels
    found = [(finders[0], RIGHT), (finders[1], Poses.concatenate([LEFT, far, RIGHT]))]
    accepted = share_out(found, frame, JUDGE).accepted
    assert [v.claim.finder.target.name for v in accepted if v.claim.poses.t[0, 0] > 0] == ["one"]


def test_without_time_what_stands_in_an_objects_place_is_dropped_unjudged(monkeypatch):
    frame = image_of_two()
    finder = WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)
    poses = candidates(finder, frame, crowd())
    late, asked, judge = replace(frame, deadline=Deadline(0.0)), [], Voter.judge

    def counted(self, *args, **options):
        asked.append(True)
        return judge(self, *args, **options)

    monkeypatch.setattr(Voter, "judge", counted)
    accepted, others, _ = share_out([(finder, poses)], late, JUDGE)
    assert len(asked) == 1 and not others
    for truth in (LEFT, RIGHT):
        assert sum(np.linalg.norm(v.claim.poses.t - truth.t) < 0.05 for v in accepted) == 1
    assert not share_out([(finder, poses)], late, StubJudge(given=lambda verdict: 0.0))[1]
