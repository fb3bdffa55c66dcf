"""The probability that an object is there: doubt that waits, doubt that is borne, cuts, predictions."""

from dataclasses import replace

import numpy as np
import pytest
from squares import TEAM, robot
from test_tracking import PERIOD, START, flat, frame, posed

from artrec_ros.core.base.config import ExistenceConfig, RecognizerConfig, TrackingConfig
from artrec_ros.core.base.deferred import Deferred
from artrec_ros.core.model.found import ImagePose, Instance, Missing, OtherObject, OtherPlace
from artrec_ros.core.model.frame_result import Rejection
from artrec_ros.core.model.target import Target
from artrec_ros.core.tracking.existence import Continuity, Existence, newcomers
from artrec_ros.core.tracking.tracker import Tracker

CONFIG = ExistenceConfig()


def at(x, score=0.99, **kw):
    return replace(posed(x, **kw), score=score)


def told(frames, config=None, period=PERIOD, **how):
    tracker = Tracker(config or TrackingConfig(), **how)
    return [tracker.update(START + k * period, frame(*found)).detections for k, found in enumerate(frames)]


def places(detections):
    return [round(float(d.pose.position[0]), 3) for d in detections]


def test_clutter_of_one_frame_is_not_told():
    seen = [[at(0.0)] for _ in range(10)]
    seen[5].append(at(0.8, 0.6))
    assert [places(d) for d in told(seen)] == [[0.0]] * 10


def test_clutter_of_one_frame_is_not_told_where_there_is_nothing_else():
    seen = [[]] * 10 + [[at(0.8, 0.6)]] + [[]] * 5
    assert not any(told(seen))


def test_a_doubtful_newcomer_is_told_when_it_is_seen_again():
    seen = [[at(0.0)] for _ in range(10)]
    for found in seen[5:]:
        found.append(at(0.8, 0.8))
    counts = [len(d) for d in told(seen)]
    assert counts[:6] == [1] * 6 and counts[6:] == [2] * 4


def test_who_waits_to_be_seen_again_is_told_among_what_is_turned_down():
    """An image of which nothing is said would be one in which nothing was found."""
    other = Rejection("robot", "too far", 0.1, 1.0, 2.0)
    tracker, here = Tracker(TrackingConfig()), replace(frame(at(0.8, 0.75)), rejected=(other,))
    for k in range(5):
        tracker.update(START + k * PERIOD, frame())
    result = tracker.update(START + 5 * PERIOD, here)
    waits, *others = result.rejected
    assert not result.detections and others == [other]
    assert "by all images so far is below 0.4: one that is seen again is told" in waits.reason and waits.score < 0.4
    seen = here.detections[0]
    assert (waits.object, waits.x, waits.y) == (seen.object, seen.image.x, seen.image.y)
    result = tracker.update(START + 6 * PERIOD, here)
    assert len(result.detections) == 1 and result.rejected == (other,)


def test_a_sure_newcomer_is_told_at_once():
    seen = [[at(0.0)]] * 5 + [[at(0.0), at(0.8, 0.97)]]
    assert [len(d) for d in told(seen)] == [1] * 5 + [2]


def test_doubt_of_one_frame_does_not_end_an_object():
    seen = [[at(0.0), at(0.8)] for _ in range(20)]
    seen[10] = [at(0.0), at(0.8, 0.41)]
    detections = told(seen)
    assert {len(d) for d in detections} == {2}
    assert detections[10][1].score > 0.9 and len({d[1].id for d in detections}) == 1


def test_a_withheld_newcomer_takes_no_number():
    seen = [[at(0.0), at(0.5)]] * 5 + [[at(0.0), at(0.5), at(-0.8, 0.5)]] + [[at(0.0), at(0.5), at(0.9)]]
    assert [d.id for d in told(seen)[-1]] == [0, 1, 2]


@pytest.mark.parametrize("score", [0.05, 0.41, 0.6, 0.9, 1.0])
def test_the_first_frame_counts_as_a_single_one(score):
    (first,) = told([[at(0.0, score)]])
    assert first[0].score == score


@pytest.mark.parametrize("score", [0.41, 0.6, 0.9])
def test_after_a_cut_each_frame_counts_as_a_single_one(score):
    """Three that stood still for a second, and then three others at once."""
    before = [[at(x) for x in (-0.6, 0.0, 0.6)]] * 30
    after = [at(x, score, y=0.4, z=2.0) for x in (-0.9, 0.3, 0.9)]
    detections = told([*before, after])[-1]
    assert len(detections) == 3 and [d.score for d in detections] == pytest.approx([score] * 3, abs=0.06)


@pytest.mark.parametrize("score", [0.45, 0.7])
def test_frames_far_apart_count_as_single_ones(score):
    seen = [[at(0.0)], [at(0.0), at(0.8, score)]] * 5
    assert [len(d) for d in told(seen, period=PERIOD * 8)] == [1, 2] * 5


def test_shuffled_frames_tell_what_single_ones_do():
    rng = np.random.default_rng(0)
    seen = [
        [at(x, s, y=y, z=z) for (x, y, z), s in zip(rng.uniform((-0.9, -0.6, 1.5), (0.9, 0.6, 3), (3, 3)),
                                                    rng.choice([0.45, 0.8, 0.97], 3), strict=True)]
        for _ in range(200)
    ]  # fmt: skip
    missing = sum(len(found) - len(d) for found, d in zip(seen, told(seen), strict=True))
    assert missing <= 6  # 1 %, while it is learned that they are no sequence


def test_an_object_put_elsewhere_is_told_at_once():
    seen = [[at(-0.5)]] * 30 + [[at(0.5, 0.9, z=2.0)]]
    assert places(told(seen)[-1]) == [0.5]


def test_scores_of_others_are_left_alone():
    """Profile paper's are no probabilities."""
    seen = [[at(0.0, 0.7)]] * 5 + [[at(0.0, 0.2), at(0.8, 0.3)]]
    detections = told(seen, recognizer=RecognizerConfig(memory=False))
    assert [d.score for d in detections[-1]] == [0.2, 0.3] and detections[0][0].id == detections[-1][0].id


def test_scores_are_calibrated_where_frames_are_independent():
    """Objects that move, come and go, and clutter that does not stay, with scores as calibrated as can be."""
    rng, said, true = np.random.default_rng(4), [], []
    for _ in range(60):
        tracker, spots = Tracker(TrackingConfig()), rng.uniform((-0.8, -0.5, 1.5), (0.8, 0.5, 2.5), (2, 3))
        for k in range(20):
            found = [(True, at(p[0] + 0.02 * (k - 10), rng.beta(8, 2), y=p[1], z=p[2])) for p in spots]
            if rng.random() < 0.3:
                x, y, z = rng.uniform((-0.8, -0.5, 1.5), (0.8, 0.5, 2.5))
                found.append((False, at(x, rng.beta(2, 8), y=y, z=z)))
            found = [f for f in found if f[1].score >= 0.4]
            detections = tracker.update(START + k * PERIOD, frame(*(d for _, d in found))).detections
            real = {(d.image.x, d.image.y) for ok, d in found if ok}
            said += [d.score for d in detections]
            true += [(d.image.x, d.image.y) in real for d in detections]
    assert np.mean(said) == pytest.approx(np.mean(true), abs=0.03)


@pytest.mark.parametrize("shown", ["1", "10", "110", "111110"])
@pytest.mark.parametrize("score", [0.45, 0.6, 0.9])
def test_what_stands_still_is_believed_as_much_as_one_frame_has_it(score, shown):
    """Clutter that looks like an object does so in each frame, or in many; a little of its place is noise."""
    rng = np.random.default_rng(0)
    seen = [[at(rng.normal(0, 0.0005), score, y=rng.normal(0, 0.0005))] * int(shown[k % len(shown)]) for k in range(60)]
    last = [d.score for found in told(seen, targets=[Target("red", robot(), TEAM)])[30:] for d in found]
    assert max(last, default=0.0) < score + 0.1
    assert shown != "1" or (min(last) > score - 0.05 and len(last) == 30)


@pytest.mark.parametrize("score", [0.6, 0.9])
def test_what_moves_and_is_found_again_is_believed_more(score):
    seen = [[at(0.02 * k, score)] for k in range(40)]
    last = [d[0].score for d in told(seen, targets=[Target("red", robot(), TEAM)])[20:]]
    assert min(last) > 0.97


@pytest.mark.parametrize("score", [0.5, 0.8])
def test_one_of_several_parts_alone_is_believed_as_much_as_by_one_frame_though_it_moves(score):
    """Clutter moves in the image where the camera does, and is the same patch in each frame. What has but one part
    shows no more."""
    part, lacks = Instance("body", "top", score, 0.0, 0.0, 0.0, 100.0), Missing("cap", "not seen", 0.0, 0.0)

    def last(*parts, missing=()):
        seen = [[replace(at(0.02 * k, score), components=parts, missing=missing)] for k in range(40)]
        return [d[0].score for d in told(seen, targets=[Target("red", robot(), TEAM)])[20:]]

    assert last(part, missing=(lacks,)) == pytest.approx([score] * 20, abs=0.02)
    assert min(last(part, part, missing=(lacks,))) > 0.97
    assert min(last(part)) > 0.97


ELSEWHERE = {"turned": at(0.3, turn=1.6), "farther off": at(0.34, z=1.14)}


@pytest.mark.parametrize("score", [0.5, 0.99])
@pytest.mark.parametrize("pose", ELSEWHERE)
@pytest.mark.parametrize("frames", [1, 6])
def test_who_is_seen_where_nobody_can_have_come_is_believed_as_much_as_by_one_frame(pose, score, frames):
    """What was known of it was known of another place: it counts where that is seen again, while nothing else is
    believed. In a row such frames confirm each other, the more the less what they say is beyond what can be."""
    known, nonsense = [at(0.01 * k) for k in range(31)], replace(ELSEWHERE[pose], score=score)
    detections = told([*[[d] for d in known[:30]], *[[nonsense]] * frames, [known[30]]])
    assert [[d.id for d in found] for found in detections] == [[0]] * (31 + frames)
    assert detections[30][0].score == pytest.approx(score, abs=0.01)
    assert max(found[0].score for found in detections[30 : 30 + min(frames, 2)]) < (1 + score) / 2 + 0.01
    assert detections[-1][0].score > (0.95 if frames == 1 else score - 0.01)


def test_what_is_known_counts_where_a_sighting_has_no_pose():
    known = [at(0.01 * k) for k in range(40)]
    unposed = [replace(d, pose=None, pose_covariance=None, score=0.5) for d in known[31:]]
    detections = told([*[[d] for d in known[:30]], [replace(ELSEWHERE["turned"], score=0.5)], *[[d] for d in unposed]])
    assert detections[30][0].score == pytest.approx(0.5, abs=0.01)
    assert min(found[0].score for found in detections[31:]) > 0.95


@pytest.mark.parametrize("every", [1, 4, 8])
def test_who_turns_fast_is_believed_more_than_by_one_frame(every):
    """4 rad/s, of which all images or every eighth are seen."""
    angles = [4.0 / 30 * every * k for k in range(40)]
    seen = [[at(0.02 * every * k / 4, 0.8, turn=a)] for k, a in enumerate(angles)]
    scores = [d[0].score for d in told(seen, period=PERIOD * every, targets=[Target("red", robot(), TEAM)])]
    assert min(scores[10:]) > 0.9


@pytest.mark.parametrize("step", [0.0, 0.001, 0.002, 0.004, 0.02])
def test_what_frames_agree_on_is_believed_as_much_as_by_one_however_slowly_it_moves(step):
    seen = [[at(step * k, 0.3)] for k in range(60)]
    how = {"targets": [Target("red", robot(), TEAM)], "recognizer": RecognizerConfig(min_probability=0.2)}
    last = [d[0].score for d in told(seen, **how)[30:]]
    assert min(last) > 0.28


def test_a_candidate_in_its_place_that_is_not_told_is_no_miss():
    """An object in doubt, of which every other frame says too little to tell it, and every other one enough."""
    tracker, both = Tracker(TrackingConfig()), list[list[bool]]()
    missing = Tracker(TrackingConfig())
    for k in range(60):
        enough = k % 2 == 0
        found = frame(at(0.01 * k, 0.45)) if enough else replace(frame(), doubtful=(at(0.01 * k, 0.35),))
        without = replace(found, doubtful=())
        told = [bool(t.update(START + k * PERIOD, f).detections) for t, f in ((tracker, found), (missing, without))]
        both += [told] if enough else []
        assert enough or told == [False, False]
    assert sum(new for new, _ in both[5:]) == 25 and sum(old for _, old in both[5:]) < 5


def test_a_doubtful_candidate_elsewhere_is_nobody_and_looked_at_only_where_somebody_is_missed():
    tracker, asked = Tracker(TrackingConfig()), list[int]()
    for k in range(10):
        doubtful = Deferred(lambda k=k: asked.append(k) or (at(0.8, 0.35),))
        found = replace(frame(at(0.0)) if k != 7 else frame(), doubtful=doubtful)
        assert len(tracker.update(START + k * PERIOD, found).detections) == (k != 7)
    assert asked == [7]


@pytest.mark.parametrize("there", [[at(0.05)], [at(0.6)], [at(0.6, 0.55), at(-0.6, 0.55)], []])
def test_clutter_where_an_object_was_is_not_taken_for_it(there):
    """It leaps within its size, is carried off, the scene is another one, or nothing is seen of it."""
    seen = []
    for clutter in ((), (at(0.0, 0.15),)):
        tracker = Tracker(TrackingConfig(predict=0.1), [Target("red", robot(), TEAM)])
        frames = [frame(at(0.0))] * 10 + [replace(frame(*there), doubtful=clutter)] * 30
        told = [tracker.update(START + k * PERIOD, f).detections for k, f in enumerate(frames)]
        assert not any(d.predicted for found in told[13:] for d in found)
        seen.append([[(d.id, places([d])) for d in found if not d.predicted] for found in told])
    assert seen[0] == seen[1]


@pytest.mark.parametrize("whole", [0, 10])
def test_what_may_lie_elsewhere_as_well_is_not_believed_more_for_it_lies_so_again(whole):
    """Two of three like parts are seen, frame after frame, and each time one of two ways in which they may lie is told:
    more of them know no better. Frames before, that saw all three, do, and fade slowly."""
    parts = tuple(Instance(name, "dot", 0.9, 0.0, 0.0, 0.0, 100.0) for name in ("left", "tail"))
    elsewhere = OtherPlace(ImagePose(0.0, 0.0, 0.6, 100.0), 0.45)
    doubtful = replace(flat(0.0), score=0.5, components=parts, other_place=elsewhere)
    sure = replace(doubtful, score=0.99, other_place=None)
    seen = [
        [replace(sure if k < whole else doubtful, image=ImagePose(100.0 + 3 * k, 0.0, 0.0, 300.0))] for k in range(40)
    ]
    last = [found[0].score for found in told(seen, targets=[Target("red", robot(), TEAM)])[20:]]
    assert min(last) > 0.85 if whole else (min(last) > 0.45 and max(last) < 0.6)


def test_missing_is_evidence_and_hiding_is_none():
    there = Existence.of(np.array([0.9, 0.9]))
    seen, hidden = there.missed(np.array([1.0, 0.0]), CONFIG).probability
    assert seen < 0.7 and hidden == pytest.approx(0.9)
    found = there.found(np.array([0.1, 0.9]), np.array([0.0, 1.0]), np.full(2, 0.03), CONFIG)
    for state in (there.after(0.1, CONFIG), there.missed(np.ones(2), CONFIG), found):
        assert ((state.seen >= 0) & (state.hidden >= 0) & (state.probability <= 1)).all()


def test_two_short_times_are_about_a_long_one():
    there = Existence(np.array([0.6]), np.array([0.2]))
    once, twice = there.after(0.1, CONFIG), there.after(0.05, CONFIG).after(0.05, CONFIG)
    assert once.probability == pytest.approx(twice.probability)
    assert once.seen == pytest.approx(twice.seen, rel=0.02)


def test_newcomers_are_as_likely_as_alone_where_nothing_goes_on():
    scores = np.array([0.1, 0.5, 0.95])
    np.testing.assert_allclose(newcomers(scores, 0.0, 0.03, CONFIG), scores)
    np.testing.assert_allclose(newcomers(scores, 1.0, 10.0, CONFIG), scores)
    assert (np.diff([newcomers(scores, c, 0.03, CONFIG) for c in (0.0, 0.5, 1.0)], axis=0) < 0).all()


def test_continuity_is_learned_from_frames():
    known = Continuity.expected(CONFIG)
    for _ in range(50):
        known = known.after(0.0, CONFIG)
    assert known.share < 0.1
    for _ in range(50):
        known = known.after(1.0, CONFIG)
    assert known.share > 0.9


# predictions


def hidden_for(frames, predict):
    """One that moves, beside another, and is not seen for so many frames."""
    steps = [[at(0.0), at(0.3 + 0.01 * k)] for k in range(30)]
    return told([*steps, *[[at(0.0)]] * frames], TrackingConfig(predict=predict))


def test_nothing_is_predicted_unless_it_is_asked_for():
    assert all(not d.predicted for found in hidden_for(5, 0.0) for d in found)
    assert len(hidden_for(5, 0.0)[-1]) == 1


def test_what_is_hidden_is_told_where_it_is_expected_for_so_long():
    detections = hidden_for(12, 0.2)
    expected = [next((d for d in found if d.predicted), None) for found in detections[30:]]
    assert [d is not None for d in expected] == [True] * 6 + [False] * 6
    before = detections[29][1]
    first = expected[0]
    assert (first.object, first.id, first.components) == (before.object, before.id, ())
    assert first.pose.position[0] == pytest.approx(0.3 + 0.01 * 30, abs=0.004)
    spread = [np.trace(d.pose_covariance) for d in expected[:6]]
    assert (np.diff(spread) > 0).all() and (np.diff([d.score for d in expected[:6]]) < 0).all()


@pytest.mark.parametrize("x", [0.0, 0.3])
def test_who_may_be_what_is_seen_in_its_place_is_not_predicted_beside_it(x):
    """Two targets that look alike are told in turn: else the one would be sure beside the other, at a half."""
    steps = [replace(at(0.0), object=name, as_told=0.5) for name in ("red", "blue")] * 12
    targets = [Target(name, robot(), TEAM) for name in ("red", "blue")]
    rivals = {"red": "blue", "blue": "red"}
    frames = [[replace(d, other_object=OtherObject(rivals[d.object], 0.5))] for d in steps]
    last = replace(at(x), object="red", other_object=OtherObject("blue", 0.5), as_told=0.5)
    found = told([*frames, [last]], TrackingConfig(predict=0.5), targets=targets)
    assert all(len(detections) == 1 for detections in found[:-1])
    assert [d.predicted for d in found[-1] if d.object == "blue"] == ([True] if x else [])


@pytest.mark.parametrize("make", [at, lambda x: flat(300 + 500 * x)])
def test_a_prediction_is_as_probable_as_it_lies_on_what_it_predicts(make):
    """Where it may be is soon wider than a small object; a large one is still there."""

    def scores(size_m):
        model = robot()
        larger = size_m / np.ptp(model.required.markers[0].outline, axis=0).max()
        marker = replace(model.required.markers[0], outline=larger * model.required.markers[0].outline)
        components = (replace(model.components[0], markers=(marker,)), *model.components[1:])
        target = Target("red", replace(model, components=components), TEAM)
        walk = np.random.default_rng(6).normal(0, 0.004, 30).cumsum()
        steps = [[make(0.0), make(0.3 + 0.01 * k + x)] for k, x in enumerate(walk.tolist())]
        steps = [[replace(d, score=0.99) for d in found] for found in [*steps, *[[make(0.0)]] * 6]]
        detections = told(steps, TrackingConfig(predict=1.0), targets=[target])
        return [next((d.score for d in found if d.predicted), 0.0) for found in detections[30:]]

    small, large = scores(0.02), scores(1.0)
    assert (np.array(small) < large).all() and min(large) > 0.4
    assert small[-1] == 0.0  # likelier elsewhere than there


def test_off_the_axis_a_prediction_is_as_probable():
    """How far off it is along the line of sight changes nothing of where it is seen."""

    def scores(angle):
        sight = np.array([np.sin(angle), 0.0, np.cos(angle)])
        covariance = np.eye(6) * 1e-4
        covariance[:3, :3] = 1e-6 * np.eye(3) + 0.08**2 * np.outer(sight, sight)
        model = robot()
        target = Target("red", model, TEAM)
        ranges = 1.0 + np.random.default_rng(1).normal(0, 0.08, 30)
        one = [at(float(r * sight[0]), z=float(r * sight[2])) for r in ranges]
        one = [replace(d, pose_covariance=covariance) for d in one]
        steps = [*[[at(-0.3), d] for d in one], *[[at(-0.3)]] * 4]
        detections = told(steps, TrackingConfig(predict=1.0), targets=[target])
        return [next((d.score for d in found if d.predicted), 0.0) for found in detections[30:]]

    np.testing.assert_allclose(scores(0.6), scores(0.0), atol=0.03)
    assert scores(0.0)[0] > 0.5


def test_in_the_image_a_prediction_goes_where_its_pose_does():
    """What was seen of it last was what the border left, whose middle runs the other way."""
    steps = [at(0.3 + 0.01 * k) for k in range(30)]
    steps[-1] = replace(steps[-1], image=replace(steps[-1].image, x=steps[-2].image.x - 30))
    config = TrackingConfig(predict=0.2)
    detections = told([*[[at(0.0), step] for step in steps], *[[at(0.0)]] * 3], config)
    expected = [next(d for d in found if d.predicted) for found in detections[30:]]
    focal_px = steps[-1].image.scale * steps[-1].pose.position[2]
    for d in expected:
        moved = d.pose.position[0] / d.pose.position[2] - steps[-1].pose.position[0] / steps[-1].pose.position[2]
        assert d.image.x == pytest.approx(steps[-1].image.x + focal_px * moved, abs=0.01) and moved > 0


def test_what_is_predicted_is_itself_when_it_comes_back():
    steps = [[at(0.0), at(0.3 + 0.01 * k)] * (k not in (10, 11, 12)) or [at(0.0)] for k in range(20)]
    detections = told(steps, TrackingConfig(predict=1.0))
    assert {tuple(sorted(d.id for d in found)) for found in detections} == {(0, 1)}
    assert [sum(d.predicted for d in found) for found in detections[9:14]] == [0, 1, 1, 1, 0]


def test_after_a_cut_nothing_is_predicted():
    before = [[at(x) for x in (-0.6, 0.0, 0.6)]] * 30
    after = [[at(x, y=0.4, z=2.0) for x in (-0.9, 0.3, 0.9)]] * 3
    config = TrackingConfig(predict=1.0)
    assert all(not d.predicted for found in told([*before, *after], config)[30:] for d in found)


def test_who_gave_the_id_away_is_not_predicted():
    steps = [[at(0.0)]] * 5 + [[at(0.9, z=2.0)]] * 3
    detections = told(steps, TrackingConfig(predict=1.0))
    assert [[(d.id, d.predicted) for d in found] for found in detections[4:]] == [[(0, False)]] * 4


def test_in_the_image_it_is_predicted_too():
    steps = [[flat(100), flat(300 + 3 * k)] for k in range(20)]
    steps = [[replace(d, score=0.99) for d in found] for found in [*steps, [flat(100)]]]
    detections = told(steps, TrackingConfig(predict=1.0))
    (expected,) = (d for d in detections[-1] if d.predicted)
    assert expected.pose is None and expected.image.x == pytest.approx(360, abs=2)


def test_what_was_put_together_in_the_image_plane_keeps_its_score_and_is_told():
    """Its score is that all of it is right, which may be little where it is surely there."""
    flat_one = replace(at(2.0, score=0.1), margin=0.5)
    frames = [[at(0.0)], [at(0.0), flat_one], [at(0.0)]]
    results = told(frames)
    assert [len(detections) for detections in results] == [1, 2, 1]
    assert min(d.score for d in results[1]) == 0.1
