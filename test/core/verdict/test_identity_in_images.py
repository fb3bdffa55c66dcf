"""What images tell of which one of several like objects each is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import LEFT_SIDE, RED, RIGHT_SIDE, camera_of, marker, pose, rectangle, render, truck
from squares import COLOURS, ROBOT, TEAM, Placing, rendered, robot

from artrec_ros.core.image.codes import LABELS, UNKNOWN, Codes
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.found import SURE
from artrec_ros.core.model.objects import Component, Identity, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.alternatives import Alternatives
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.other_layouts import Layouts
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.verdict.acceptance import _of_several, verdicts_of
from artrec_ros.core.verdict.claims import claims_of
from artrec_ros.core.verdict.identity import Identifier, doubted
from artrec_ros.core.verdict.judge import Judge


def test_what_may_be_of_several_classes_is_borne_out_by_less():
    """By chance as many times as easily as a component has classes, in the mean, the required one's as well."""
    confirmed = np.array([[1, 0, 0], [1, 1, 0], [1, 1, 1], [0, 0, 1]], bool)
    surface = SpatialModel(robot(), TEAM, DEFAULTS.votes)
    np.testing.assert_allclose(_of_several(confirmed, surface), [1.0, 3 ** (1 / 2), 3 ** (2 / 3), 3.0])
    plain = SpatialModel(ROBOT["plain"], TEAM, DEFAULTS.votes)
    np.testing.assert_allclose(_of_several(confirmed[2:3], plain), 1.0)
    team, *others = robot(identities=()).components
    of_three = replace(robot(identities=()), components=(replace(team, classes=dict(COLOURS)), *others))
    surface = SpatialModel(of_three, TEAM, DEFAULTS.votes)
    np.testing.assert_allclose(_of_several(confirmed, surface), 3.0)


def frame_of(*placed, codes=None, meaning=LABELS):
    labels = rendered(*placed)
    return ImageFrame(LabelField(labels if codes is None else codes(labels), None, meaning)).faced()


def poses_of(frame, *placed):
    return Poses.concatenate([p.pose(frame.camera) for p in placed])


def finder_of(model, meaning=LABELS):
    return WholeObjectFinder(Target("robot", model, TEAM), DEFAULTS, meaning, facing=True)


def identifier_of(model, meaning=LABELS):
    return Identifier(finder_of(model, meaning))


def read_in(frame, at, model, meaning=LABELS):
    return Layouts.around(finder_of(model, meaning), frame, poses_of(frame, at)).evidence()


ONE = Placing(60.0, 50.0, 0.4, 300.0, "gr")


@pytest.mark.parametrize("name", ["gr", "gv", "rg", "vr"])
def test_the_classes_that_are_shown_win(name):
    at = Placing(60.0, 50.0, 0.4, 300.0, name)
    frame = frame_of(at)
    identifier = identifier_of(robot())
    evidence = read_in(frame, at, robot())
    assert evidence.shape == (1, 4) and (evidence <= 0).all()
    assert identifier.identities[int(evidence.argmax())].name == name
    (fit,) = identifier.identify(frame, poses_of(frame, at), [{0, 1, 2}])
    assert fit.name == name and fit.probability > 0.95 and fit.least == DEFAULTS.min_identity_probability


def test_evidence_grows_with_what_is_seen():
    """By the pixels on the components: twice as large tells four times as much."""
    gaps = []
    for scale in (200.0, 400.0):
        at = Placing(75.0, 60.0, 0.0, scale, "gr")
        frame = frame_of(at)
        evidence = np.sort(read_in(frame, at, robot())[0])
        gaps.append(evidence[-1] - evidence[0])
    assert gaps[1] / gaps[0] == pytest.approx(4, rel=0.15)


def test_what_shows_none_of_the_classes_tells_no_name():
    frame = frame_of()
    identifier = identifier_of(robot())
    (fit,) = identifier.identify(frame, poses_of(frame, ONE), [{0, 1, 2}])
    assert fit.name is None and fit.probability == pytest.approx(0.5, abs=1e-6)


def test_who_shows_no_component_that_tells_identities_has_no_name_and_takes_none_from_others():
    """What lies where they would be is something else: a ball that is taken for a robot lies beside one."""
    frame = frame_of(ONE)
    identifier = identifier_of(robot())
    poses = poses_of(frame, ONE, ONE)
    bare, whole = identifier.identify(frame, poses, [{0}, {0, 1}])
    assert bare.name is None and bare.probability == 0.0
    assert whole.name == "gr" and whole.probability > 0.95
    five = poses_of(frame, *[ONE] * 5)
    surplus, _ = identifier.surplus(frame, five, [{0}, *[{0, 1, 2}] * 4], np.full(5, 0.9), np.ones(5))
    assert surplus.sum() == 1


def test_of_like_rivals_the_one_that_explains_more_is_there():
    """Small things look like anything: there is the more of them."""
    lone = replace(robot(alternatives=False), unique=True)
    frame, identifier = frame_of(ONE), identifier_of(lone)
    two = poses_of(frame, ONE, ONE)
    surplus, odds = identifier.surplus(frame, two, [{0, 1, 2}] * 2, np.array([0.985, 0.98]), np.array([4e3, 8e4]))
    assert surplus.tolist() == [True, False] and -3 < odds[1, 0] < 0
    surplus, _ = identifier.surplus(frame, two, [{0, 1, 2}] * 2, np.array([0.95, 0.6]), np.array([1e3, 1.3e4]))
    assert surplus.tolist() == [False, True]  # large things are in doubt, too


def test_pixels_in_doubt_tell_as_much_as_they_know():
    """The left patch's pixels may be green or violet: gr and vr are told apart by the share alone."""
    green, red, violet = (COLOURS[c] for c in "grv")

    def meaning_of(share):
        table, label = np.eye(256), np.arange(256, dtype=np.uint8)
        table[green] = 0
        table[green, [green, violet]] = share, 1 - share
        return Codes(label, table)

    model = robot(identities=(("gr", "g", "r"), ("vr", "v", "r")))
    found = {}
    for share in (1.0, 0.7, 0.5, 0.2):
        meaning = meaning_of(share)
        frame = frame_of(ONE, meaning=meaning)
        gr, vr = read_in(frame, ONE, model, meaning)[0]
        found[share] = gr - vr
    assert found[1.0] > found[0.7] > found[0.5] > found[0.2]
    assert found[0.5] == pytest.approx(0) and found[0.2] < 0
    assert UNKNOWN not in (green, red, violet)


def test_without_identities_or_objects_nothing_is_told():
    frame = frame_of(ONE)
    plain = identifier_of(ROBOT["plain"])
    assert plain.identify(frame, poses_of(frame, ONE, ONE), [{0}, {0}]) == [None, None]
    whole = identifier_of(robot())
    assert whole.identify(frame, poses_of(frame, ONE)[:0], []) == []


def evidence_beside(label):
    frame = frame_of(ONE, codes=lambda labels: beside(labels, label))
    finder = WholeObjectFinder(Target("robot", robot(), TEAM), DEFAULTS, facing=True)
    return verdicts_of(claims_of(finder, poses_of(frame, ONE), frame))[0].evidence


def test_outlines_amid_the_class_that_is_shown_speak_against_a_component():
    """As of what may be of one class alone; amid another one that it may be of they say nothing."""
    other, shown, team = (evidence_beside(label) for label in (COLOURS["v"], COLOURS["r"], TEAM))
    assert other.parts == 1 == other.parted
    assert 0 < shown.parts < 0.95 and shown.parted == 1
    assert team.parts == 1 and 0 < team.parted < 0.95


def test_what_is_of_several_classes_is_a_marker_of_none():
    """A third of the right patch's pixels is of each of the three that it may be of."""

    def speckled(labels):
        third = np.array(list(COLOURS.values()), np.uint8)[np.indices(labels.shape).sum(axis=0) % 3]
        return np.where(labels == COLOURS["r"], third, labels)

    finder = WholeObjectFinder(Target("robot", robot(), TEAM), DEFAULTS, facing=True)
    for codes, seen in ((None, True), (speckled, False)):
        frame = frame_of(ONE, codes=codes)
        verdict = verdicts_of(claims_of(finder, poses_of(frame, ONE), frame))[0]
        assert verdict.confirmed == (True, True, seen)


def beside(labels, label):
    """A class on all that is unknown to the right of the object's middle."""
    right = np.arange(labels.shape[1]) > ONE.x
    return np.where(right & (labels == UNKNOWN), np.uint8(label), labels)


def flags(at, name):
    """A truck with a flag on either side, each of one of two classes, and what its labels are where it shows `name`."""
    body, classes = truck().components[0], {"g": 6, "v": 7}
    strip = rectangle(0.08, 0.08, (0, -0.1))
    sides = {"right": (RIGHT_SIDE, -0.0605), "left": (LEFT_SIDE, 0.0605)}
    parts = [Component(n, (marker("flag", strip, R, (0, y, 0)),), classes=classes) for n, (R, y) in sides.items()]
    pairs = tuple(Identity(a + b, {"right": a, "left": b}) for a, b in (("g", "v"), ("v", "g")))
    shown = [replace(c, classes={}, label=classes[n]) for c, n in zip(parts, name, strict=True)]
    labels = render(camera_of(), [(ObjectModel("flags", (body, *shown)), at, RED)])
    model = ObjectModel("flags", (body, *parts), pairs)
    return SpatialModel(model, RED, DEFAULTS.votes), ImageFrame(LabelField(labels), camera_of())


@pytest.mark.parametrize("name", ["gv", "vg"])
@pytest.mark.parametrize("heading", [0.0, 0.4, -0.4])
def test_what_is_turned_away_says_nothing(name, heading):
    at = pose(0.02, 0.0, 0.6, heading, model=truck())
    at = replace(at, q=at.q[:, :0])
    surface, frame = flags(at, name)
    alternatives = Alternatives(surface, DEFAULTS.verdict)
    assert alternatives.contradicted(frame, at)[0] == pytest.approx(0.0, abs=1e-6)
    evidence = alternatives.read([frame], at).evidence[0]
    assert alternatives.identities[int(evidence.argmax())].name == name


@pytest.mark.parametrize(
    ("shown", "least", "most"),
    [
        ("gr", 0.98, 1.0),
        ("gg", 0.5, 0.7),  # a light on the right patch, or another's over it; or a robot that is not declared
        ("rv", 0.0, 0.2),  # neither patch is as any name says
    ],
)
def test_who_shows_a_combination_that_is_not_declared_has_hardly_a_name(shown, least, most):
    at = replace(ONE, name=shown)
    identifier = identifier_of(robot(identities=(("gr", "g", "r"), ("vr", "v", "r"))))
    frame = frame_of(at)
    (fit,) = identifier.identify(frame, poses_of(frame, at), [{0, 1, 2}])
    called = replace(fit, name="gr", probability=0.99)  # another one is vr: what is left
    (fit,) = doubted([called], [0.99], DEFAULTS.verdict.misread)
    assert least < fit.probability < most and fit.name == ("gr" if least > 0.8 else None)
    (sure,) = doubted([replace(called, listed=SURE)], [0.99], DEFAULTS.verdict.misread)
    assert sure.name == "gr"


def test_where_all_combinations_exist_nothing_speaks_against_a_name():
    identifier = identifier_of(robot(identities=()))
    at = replace(ONE, name="rv")
    frame = frame_of(at)
    (fit,) = identifier.identify(frame, poses_of(frame, at), [{0, 1, 2}])
    assert fit.name == "r_v" and fit.listed == SURE


def test_colours_that_no_identity_has_count_against_a_claim():
    """Both patches green: no robot has that, so it comes after one that exists, however it lies."""
    model, at = robot(), Placing(60.0, 50.0, 0.4, 300.0, "gg")
    frame, finder = frame_of(at), WholeObjectFinder(Target("robot", model, TEAM), DEFAULTS, facing=True)
    judge = Judge.of(DEFAULTS)
    wrong = judge.verdicts(finder, poses_of(frame, at), frame)
    there = replace(at, name="gr")
    right_frame = frame_of(there)
    right = judge.verdicts(finder, poses_of(right_frame, there), right_frame)
    against = [verdicts.claims.contradicted(np.array([0]))[0] for verdicts in (right, wrong)]
    assert against[0] == pytest.approx(0.0, abs=1e-6) and against[1] > 100
    assert 0 < judge.worth(wrong)[0] < judge.worth(right)[0]
    lost = replace(wrong.claims, votes=np.array([against[1] / 2]))
    assert judge.worth(replace(wrong, claims=lost))[0] > 0  # it comes last, but may be there
    assert judge.trust(wrong[0]) < wrong.probability[0]


def test_a_plain_blob_of_the_teams_colour_is_no_robot():
    """Of a robot that may bear patches of that colour, which none does."""
    plain = rendered(ONE)
    plain[plain > 0] = TEAM
    either = {**COLOURS, "t": TEAM}
    bearing = tuple(replace(c, classes=either if c.classes else {}) for c in robot().components)
    model = replace(robot(), components=bearing)
    finder = WholeObjectFinder(Target("robot", model, TEAM), DEFAULTS, facing=True)
    frame = ImageFrame(LabelField(plain), None).faced()
    (verdict,) = verdicts_of(claims_of(finder, poses_of(frame, ONE), frame))
    assert verdict.probability < DEFAULTS.min_probability
