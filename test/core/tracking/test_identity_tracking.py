"""Which one of several like objects a track is: evidence over frames, and names that keep tracks apart."""

from dataclasses import replace

import numpy as np
import pytest
from test_tracking import PERIOD, START, flat, frame

from artrec_ros.core.base.config import RecognizerConfig, SightingsConfig, TrackingConfig
from artrec_ros.core.tracking.names import same_by_name
from artrec_ros.core.tracking.tracker import Tracker
from artrec_ros.core.verdict.identity import named

NAMES = ("gr", "gv", "vr")


def seen(*detections, unique=True, least=0.8):
    """A frame of (x, evidence of each name) each, named as the recogniser does: all of it together."""
    evidence = np.array([e for _, e in detections], float)
    fits = named(evidence, NAMES, unique, least)
    return frame(*(replace(flat(x), identity=fit) for (x, _), fit in zip(detections, fits, strict=True)))


def followed(frames, config=None):
    tracker = Tracker(config or TrackingConfig())
    return [tracker.update(START + k * PERIOD, result).detections for k, result in enumerate(frames)]


def names(detections):
    return [d.identity.name for d in detections]


DOUBT = (0, -1, -9)


def test_evidence_over_frames_decides_a_doubtful_one():
    """Each frame alone says gr at odds of e: too little, until some have been seen."""
    one = seen((100, DOUBT))
    assert names(one.detections) == [None]
    told = [d for (d,) in followed([one] * 8)]
    assert told[0].identity.name is None and told[-1].identity.name == "gr"
    sure = [d.identity.probability for d in told]
    assert (np.diff(sure) > 0).all()
    memory = SightingsConfig().identity_memory
    for k, p in enumerate(sure):  # odds grow as what is remembered adds up
        assert np.log(p / (1 - p)) == pytest.approx((1 - memory ** (k + 1)) / (1 - memory))


def test_what_is_none_of_the_declared_ones_gets_no_name_in_a_sequence_and_a_glare_takes_none():
    (shown,) = seen((100, (0, -9, -9))).detections
    as_told = [frame(replace(flat(100), identity=replace(shown.identity, listed=odds))) for odds in (6.0, -6.0)]
    usual, against = as_told
    assert names([d for (d,) in followed([usual] * 5 + [against] + [usual] * 3)]) == ["gr"] * 9
    assert names([d for (d,) in followed([against] * 6)]) == [None] * 6


def test_a_slip_of_one_frame_changes_no_name_and_a_lasting_change_does():
    slip, usual = seen((100, (-1, 0, -9))), seen((100, (0, -3, -9)))
    told = [names(d)[0] for d in followed([usual] * 6 + [slip] + [usual] * 3 + [slip] * 20)]
    assert set(told[:10]) == {"gr"}
    assert told[-1] == "gv"


def test_without_memory_each_frame_tells_for_itself():
    config = TrackingConfig(sightings=SightingsConfig(identity_memory=0.0))
    told = followed([seen((100, DOUBT))] * 5, config)
    assert [names(d) for d in told] == [[None]] * 5


def test_of_frames_that_are_judged_each_by_itself_none_names_what_another_shows():
    """Pictures that have nothing to do with each other: who lies where another one did is not that one."""
    one, other = seen((100, (0, -9, -9)), (300, (-9, 0, -9))), seen((102, (-9, -9, 0)), (298, (0, -9, -9)))
    tracker = Tracker(TrackingConfig(), recognizer=RecognizerConfig(memory=False))
    told = [tracker.update(START + k * PERIOD, f).detections for k, f in enumerate([*[one] * 6, other, one])]
    assert [names(d) for d in told[5:]] == [["gr", "gv"], ["vr", "gr"], ["gr", "gv"]]


def test_all_of_a_frame_are_named_together_by_what_was_seen_before():
    """The second is known as gv of old; a frame in which both look like gr leaves it that."""
    clear, both = seen((100, (0, -9, -9)), (300, (-9, 0, -9))), seen((100, (0, -2, -9)), (300, (0, -0.5, -9)))
    told = followed([clear] * 3 + [both] * 3)
    assert {tuple(names(d)) for d in told} == {("gr", "gv")}
    assert [d.name for d in told[-1]] == ["red_gr", "red_gv"]


def test_told_names_keep_tracks_apart():
    """Two robots that jump to each other's place between two frames: names, not places, tell who is who."""
    before = seen((100, (0, -30, -30)), (108, (-30, 0, -30)))
    after = seen((100, (-30, 0, -30)), (108, (0, -30, -30)))
    told = followed([before] * 5 + [after])
    assert [d.id for d in told[-2]] == [0, 1] and [d.id for d in told[-1]] == [1, 0]
    assert names(told[-1]) == ["gv", "gr"]


@pytest.mark.parametrize("wrong", [(-3, 0, -9), (-30, 0, -30)])
def test_a_wrong_name_in_one_frame_begins_nobody_new(wrong):
    """Told at 0.95 and more; the one that bears that name is elsewhere, and stays who it is."""
    usual = seen((100, (0, -9, -9)), (300, (-9, 0, -9)))
    told = followed([usual] * 6 + [seen((101, wrong), (300, (-9, -9, 0)))] + [usual] * 3)
    assert {tuple(d.id for d in detections) for detections in told} == {(0, 1)}


@pytest.mark.parametrize(("score", "name"), [(0.6, None), (0.9999, "gv")])
def test_what_is_left_over_is_no_name_of_what_may_be_none(score, name):
    """Both show gr, the first more plainly: whether the other is gv depends on whether it is there at all."""
    told = followed([seen((100, (0, -100, -100)), (300, (0, -20, -60)))])
    (one, other) = told[0]
    again = frame(one, replace(other, score=score))
    assert names(followed([again])[0]) == ["gr", name]


def test_names_that_occur_more_than_once_keep_nobody_apart():
    before = seen((100, (0, -30, -30)), (300, (-30, 0, -30)), unique=False)
    after = seen((100, (-30, 0, -30)), (300, (0, -30, -30)), unique=False)
    told = followed([before] * 5 + [after])
    assert [d.id for d in told[-1]] == [0, 1]


def test_a_name_that_is_not_told_keeps_nobody_apart():
    told = followed([seen((100, (0, -9, -9)), (300, (-9, 0, -9)))] * 3 + [seen((102, (0, 0, 0)), (300, (-9, 0, -9)))])
    assert [d.id for d in told[-1]] == [0, 1] and names(told[-1]) == ["gr", "gv"]


def test_a_missed_frame_keeps_the_evidence():
    told = followed([seen((100, DOUBT))] * 6 + [frame()] * 2 + [seen((100, (0, 0, 0)))])
    assert names(told[-1]) == ["gr"]


def test_objects_without_identities_stay_as_they_are():
    mixed = replace(seen((100, DOUBT)), detections=(*seen((100, DOUBT)).detections, flat(300, name="blue")))
    told = followed([mixed] * 4)
    assert told[-1][1].identity is None and told[-1][0].identity.name == "gr"
    bare = replace(seen((100, DOUBT)).detections[0].identity, evidence={})  # as read from a file of results
    (last,) = followed([frame(replace(flat(100), identity=bare))] * 4)[-1]
    assert last.identity == bare


def test_switched_off_names_are_the_recognisers():
    told = followed([seen((100, DOUBT))] * 6, TrackingConfig(enabled=False))
    assert [names(d) for d in told] == [[None]] * 6


def bare(x):
    """One of which nothing is seen that tells a name, as the recogniser has it."""
    fit = named(np.zeros((1, len(NAMES))), NAMES, True, 0.8)[0]
    return replace(flat(x), identity=replace(fit, name=None, probability=0.0, runner_up=None, evidence={}))


def test_who_shows_nothing_that_tells_a_name_gets_none_that_is_left():
    """With the others named it would have the last one for sure."""
    others = [
        replace(d, identity=f.identity)
        for d, f in zip(
            (flat(100), flat(300)), seen((100, (0, -30, -30)), (300, (-30, 0, -30))).detections, strict=True
        )
    ]
    told = followed([frame(*others, bare(600))] * 4)
    assert names(told[-1]) == ["gr", "gv", None]
    assert told[-1][2].identity.probability == 0.0


def test_who_showed_one_before_keeps_it_while_its_patches_are_hidden():
    told = followed([seen((100, (-30, -30, 0)))] * 4 + [frame(bare(100))] * 2)
    assert names(told[-1]) == ["vr"]


SURE = {"gr": (0, -30, -30), "gv": (-30, 0, -30)}


def test_who_turns_up_elsewhere_under_a_name_that_occurs_once_is_the_same():
    """It bounces, and is nowhere near where it should be: its track, which nobody sees, must not keep its name."""
    moves = [100 + 12 * k for k in range(10)] + [150 - 40 * k for k in range(4)]
    told = followed([seen((x, SURE["gr"]), (300, SURE["gv"])) for x in moves])
    assert {tuple(names(d)) for d in told} == {("gr", "gv")}
    assert {tuple(x.id for x in d) for d in told} == {(0, 1)}


@pytest.mark.parametrize(
    ("evidence", "same"),
    [((0, -1, -9), True), ((0, -1, 0), False), ((-9, -1, 0), False), ((-5, 0, -9), True)],
    ids=["likely", "as likely another one", "another one", "likely of those that are left"],
)
def test_a_newcomer_is_who_is_lost_where_that_is_likely(evidence, same):
    """The second, gv, is seen all the time."""
    frames = [seen((100, SURE["gr"]), (200, SURE["gv"]))] * 5 + [seen((400, evidence), (200, SURE["gv"]))]
    told = {d.image.x: d.id for d in followed(frames)[-1]}
    assert (told[400] == 0) == same and told[200] == 1


def test_names_that_occur_more_than_once_are_not_handed_on():
    frames = [
        seen(*((x, e) for x, e in zip(at, SURE.values(), strict=True)), unique=False)
        for at in [(100, 200)] * 5 + [(400, 200)]
    ]
    assert {d.image.x: d.id for d in followed(frames)[-1]} == {400: 2, 200: 1}


@pytest.mark.parametrize("predict", [0.0, 1.0])
def test_who_is_in_doubt_takes_nobodys_number(predict):
    """Clutter that looks like the one that is hidden for a moment."""
    both = seen((100, SURE["gr"]), (200, SURE["gv"]))
    clutter = seen((400, SURE["gr"]), (200, SURE["gv"]))
    doubtful = replace(clutter.detections[0], score=0.05)
    hidden = replace(clutter, detections=(doubtful, clutter.detections[1]))
    told = followed([both] * 5 + [hidden] + [both] * 2, TrackingConfig(predict=predict))
    assert {d.image.x: d.id for d in told[-1]} == {100: 0, 200: 1}
    assert {d.id for d in told[5]} == ({0, 1} if predict else {1})


def test_who_has_been_found_again_leaves_nothing_behind():
    """Whoever comes to where it was is somebody new."""
    away = [(400, SURE["gr"]), (200, SURE["gv"])]
    before, after = [(100, SURE["gr"]), (200, SURE["gv"])], [*away, (100, (-30, -30, 0))]
    tracker = Tracker(TrackingConfig())
    for k, those in enumerate([before] * 5 + [away]):
        tracker.update(START + k * PERIOD, seen(*those))
    told = tracker.update(START + 6 * PERIOD, seen(*after)).detections
    assert len(tracker._tracks) == 3
    assert {d.image.x: d.id for d in told if d.image.x != 100} == {400: 0, 200: 1}


def test_of_several_that_are_lost_and_found_the_likely_pair_is_one():
    """The other newcomer is in doubt between two names, and is somebody new."""
    before = [(100, (0, -3, -9)), (150, (-9, 0, -4))]
    told = followed([seen(*before)] * 5 + [seen((400, (-0.7, -0.7, 0)), (500, (0, -4, -30)))])[-1]
    assert {d.image.x: d.id for d in told} == {400: 2, 500: 0}


def test_the_probability_to_be_the_same_is_that_of_one_name():
    fits = named(np.log(np.array([(0.6, 0.3, 0.1), (0.2, 0.7, 0.1)])), NAMES, True, 0.8)
    there, objects = np.array([0.5, 1.0]), ["red", "red"]
    assert same_by_name(objects, fits, there, [0], [1]) == pytest.approx(0.5 * (0.6 * 0.2 + 0.3 * 0.7 + 0.1 * 0.1))
    assert same_by_name(["red", "blue"], fits, there, [0], [1]) == 0
