"""Verdicts on claims whose scores are given by hand."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import RED, camera_of, pose, render, sign, truck

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import PatchScores, Poses
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.acceptance_curves import CURVES, LIKELY, SURE
from artrec_ros.core.verdict.claims import Claims, Seen, claims_of
from artrec_ros.core.verdict.colour_curves import ADDED
from artrec_ros.core.verdict.evidence import Evidence
from artrec_ros.core.verdict.judge import Judge

CONFIG = DEFAULTS
JUDGE = Judge.of(CONFIG)
STRICT = replace(JUDGE, min_probability=1.0)
MODELS = {m.name: m for m in (truck(), sign())}
FINDERS = {name: WholeObjectFinder(Target(name, m, RED), DEFAULTS) for name, m in MODELS.items()}
CAMERA = camera_of()
# where nobody owns anything, and outlines are as they are
FRAMES = {name: ImageFrame(LabelField(render(CAMERA, [(m, pose(model=m), RED)])), CAMERA) for name, m in MODELS.items()}


def claim(seen, votes=800.0, name="truck", body=0.5, agree=0.9, against=-50.0, per_px=4.5):
    """A claim on which the labels say what `seen` tells: (component, marker) -> pixels that support it."""
    finder = FINDERS[name]
    surface = finder.surface
    n = len(surface.patches)
    scores = PatchScores(np.zeros((1, n)), np.zeros((1, n)), np.zeros((1, n)))
    names = [c.name for c in surface.model.components]
    for i, patch in enumerate(surface.patches):
        if patch.marker is None:
            scores.area_px[0, i], scores.votes[0, i] = 100.0, 100.0 * body
        elif (px := seen.get((names[patch.component], patch.marker.name))) is not None:
            scores.area_px[0, i], scores.votes[0, i], scores.agree[0, i] = px, per_px * px, agree
        elif patch.marker.name in ("right", "outer_right"):  # it should be seen and is not
            scores.area_px[0, i], scores.votes[0, i] = 30.0, against
    at, one = pose(model=surface.model), np.ones(1)
    seen, place = Seen(scores.area_px, 0 * one), (np.nan * one, np.nan * one, 4 * one, [None])
    return Claims(finder, at, votes * one, scores, seen, FRAMES[name], *place)


def verdict_of(one):
    (verdict,) = verdicts_of(one)
    return verdict


TORSO, FORE, HIND, FACE = ("torso", "right"), ("fore", "outer_right"), ("hind", "outer_right"), ("plate", "face")
WHOLE = {TORSO: 300.0, FORE: 60.0, HIND: 60.0}


def shown(verdict):
    surface = verdict.claim.finder.surface
    return [surface.patches[i].marker.name if i >= 0 else None for i in verdict.shown]


def test_a_whole_object_is_accepted():
    verdict = verdict_of(claim(WHOLE))
    assert shown(verdict) == ["right", "outer_right", "outer_right"]
    assert verdict.others == [1, 2]
    assert 0.5 < verdict.probability <= 1
    assert JUDGE.reason(verdict) is None
    np.testing.assert_allclose(verdict.marker_votes, [1350, 270, 270])


def test_each_component_is_shown_by_its_largest_supported_marker():
    verdict = verdict_of(claim({TORSO: 100.0, ("torso", "front"): 300.0, ("fore", "outer_left"): 60.0}))
    assert shown(verdict) == ["front", "outer_left", None]
    assert verdict.others == [1]


@pytest.mark.parametrize("change", [{"agree": 0.1}, {}])
def test_a_marker_that_the_labels_do_not_bear_out_shows_nothing(change):
    seen = {TORSO: 300.0, FORE: 60.0 if change else 3.0}
    verdict = verdict_of(claim(seen, **change))
    assert verdict.others == []
    assert shown(verdict)[0] == "right"  # the required component is always named


def test_more_evidence_never_lowers_the_probability():
    ladder = [
        claim({TORSO: 300.0}),
        claim({TORSO: 300.0, FORE: 30.0}),
        claim({TORSO: 300.0, FORE: 60.0}),
        claim({TORSO: 300.0, FORE: 60.0, HIND: 30.0}),
        claim(WHOLE),
        claim(WHOLE, votes=1600.0),
        claim(WHOLE, votes=1600.0, body=0.7),
    ]
    probability = [verdict_of(c).probability for c in ladder]
    assert probability == sorted(probability)
    assert probability[0] < probability[-1] > 0.95
    assert all(0 <= p <= 1 for p in probability)


@pytest.mark.parametrize("case", CURVES)
def test_no_curve_falls(case):
    """Evidence is stated so that more of it speaks for an object."""
    _, curves = CURVES[case]
    assert set(curves) <= set(Evidence._fields)
    for xs, ys in curves.values():
        assert len(xs) == len(ys) >= 2
        assert (np.diff(xs) > 0).all() and (np.diff(ys) >= 0).all()


@pytest.mark.parametrize(
    "case, seen, name",
    [
        ("borne out", WHOLE, "truck"),
        ("deserted", {TORSO: 300.0}, "truck"),
        ("alone", {FACE: 500.0}, "sign"),
    ],
)
def test_each_case_adds_up_its_own_curves(case, seen, name):
    verdict = verdict_of(claim(seen, name=name))
    assert verdict.case == case
    bias, curves = CURVES[case]
    logit = bias - np.log(verdict.among.times[verdict.row])
    logit += sum(np.interp(getattr(verdict.evidence, n), *curve) for n, curve in curves.items())
    assert verdict.probability == pytest.approx(1 / (1 + np.exp(-logit)))


def coloured(one):
    """The same claim in an image with colours."""
    height, width = one.frame.field.codes.shape
    return replace(one, frame=replace(one.frame, image=np.zeros((height, width, 3), np.uint8)))


@pytest.mark.parametrize("agree, per_px", [(0.9, 4.5), (0.5, 1.7)])
def test_in_images_with_colours_curves_of_soft_codes_add_to_those_of_labels(agree, per_px):
    one = claim({FACE: 500.0}, votes=500 * per_px, name="sign", agree=agree, per_px=per_px)
    plain, soft = verdict_of(one), verdict_of(coloured(one))
    assert (plain.case, soft.case) == ("alone", "alone in colour")
    assert soft.evidence == plain.evidence and soft.evidence.faint == -soft.evidence.colour
    bias, curves = ADDED["alone"]
    more = bias + sum(np.interp(getattr(soft.evidence, n), *curve) for n, curve in curves.items())
    logits = [np.log(v.probability / (1 - v.probability)) for v in (plain, soft)]
    assert logits[1] - logits[0] == pytest.approx(more)


def test_soft_codes_have_the_more_added():
    def added(per_px):
        one = claim({FACE: 500.0}, votes=500 * per_px, name="sign", agree=per_px / 5, per_px=per_px)
        plain, soft = verdict_of(one).probability, verdict_of(coloured(one)).probability
        return np.log(soft / (1 - soft)) - np.log(plain / (1 - plain))

    assert 0 < added(4.2) < added(1.7)


def test_with_other_components_to_see_colours_are_judged_as_labels_are():
    for seen in (WHOLE, {TORSO: 300.0}):
        plain, soft = verdict_of(claim(seen)), verdict_of(coloured(claim(seen)))
        assert (soft.case, soft.probability) == (plain.case, plain.probability)


@pytest.mark.parametrize("case", ADDED)
def test_no_added_curve_falls(case):
    assert case in CURVES
    for name, (xs, ys) in ADDED[case][1].items():
        assert name in Evidence._fields and name not in CURVES[case][1]
        assert (np.diff(xs) > 0).all() and (np.diff(ys) >= 0).all()


def test_evidence_is_what_the_labels_say():
    evidence = verdict_of(claim({TORSO: 300.0, FORE: 60.0})).evidence
    assert evidence.size == pytest.approx(np.log(800))
    assert evidence.bare == 0 and evidence.body == pytest.approx(0.5) == evidence.faces
    assert evidence.shown == 1
    assert evidence.others == pytest.approx((4.5 * 60 - 50) / 90)  # of the hind leg 30 px should be seen
    assert evidence.colour == pytest.approx((4.5 * 360 - 50) / 390)
    assert evidence.missing == pytest.approx(-np.log1p(30))
    assert evidence.lacking == pytest.approx(-30 / 390)
    bare = verdict_of(claim({FACE: 500.0}, name="sign")).evidence
    assert bare.bare == 1 and bare.body == bare.faces == CONFIG.votes.body[2]


def outlines(labels):
    """What the evidence says of the outlines of the truck where it stands."""
    frame = ImageFrame(LabelField(labels), CAMERA)
    evidence = verdicts_of(claims_of(FINDERS["truck"], pose(model=MODELS["truck"]), frame))[0].evidence
    return evidence.rim, evidence.parted, evidence.parts


def test_outlines_are_parted_from_their_class_or_amid_it():
    labels = render(CAMERA, [(MODELS["truck"], pose(model=MODELS["truck"]), RED)])
    rim, parted, parts = outlines(labels)
    assert rim > 0.8 and parted > 0.98 and parts > 0.9
    (middle,), _ = FINDERS["truck"].required.discs(CAMERA, pose(model=MODELS["truck"]))
    right = np.arange(labels.shape[1]) > middle[0]
    half = np.where(right, np.uint8(RED), labels)
    half_rim, half_parted, _ = outlines(half)
    assert half_rim < rim and 0.2 < half_parted < 0.9
    amid_rim, amid_parted, amid_parts = outlines(np.full_like(labels, RED))
    assert amid_rim < 0 and amid_parted < 0.05 > amid_parts


def test_thresholds_of_the_search_are_in_order():
    assert CONFIG.min_probability < LIKELY <= SURE < 1
    assert (CONFIG.search.sure, CONFIG.search.likely) == (SURE, LIKELY)  # what the fit wrote is what is used


def test_a_body_that_is_not_there_speaks_against_an_object():
    good, bad = (verdict_of(claim(WHOLE, body=b)).probability for b in (0.6, -1.5))
    assert bad < good


def test_too_few_votes_are_named_with_what_is_wanted():
    reason = Judge(123.0, CONFIG.min_probability).reason(verdict_of(claim(WHOLE, votes=40.0)))
    assert "40 votes" in reason and "123" in reason and "\n" not in reason


def test_without_its_required_component_there_is_no_object():
    """However plain the others are: what stands for it may be merged with something, but must be there."""
    verdict = verdict_of(claim({FORE: 200.0, HIND: 200.0}, votes=3000.0))
    assert Judge(0.0, 0.0).trust(verdict) == 0
    assert JUDGE.reason(verdict) == "where it would be, its required component torso is not confirmed"
    whole = verdict_of(claim(WHOLE, votes=3000.0))
    assert JUDGE.trust(whole) == whole.probability > CONFIG.min_probability


def test_of_an_object_of_one_marker_it_is_told_how_much_of_that_shows():
    reason = JUDGE.reason(verdict_of(claim({FACE: 50.0}, name="sign", agree=0.29)))
    assert reason == "too little of its marker shows: 50 pixels in the image, 29% of its class"


@pytest.mark.parametrize("wanted, confirmed", [(0, 1), (1, 1), (2, 2), (3, 3), (9, 3)])
def test_so_many_components_must_be_confirmed_the_required_one_included_and_no_more_than_there_are(wanted, confirmed):
    judge = Judge(0.0, 0.0, min_components=wanted)
    seen = [{TORSO: 300.0}, {TORSO: 300.0, FORE: 60.0}, WHOLE]
    reasons = [judge.reason(verdict_of(claim(s))) for s in seen]
    assert [r is None for r in reasons] == [n >= confirmed for n in (1, 2, 3)]
    for n, reason in enumerate(reasons[: confirmed - 1], 1):
        assert reason == f"{n} of its components confirmed, {confirmed} are wanted"


@pytest.mark.parametrize(
    "limits, reason",
    [
        ({"max_range_m": 2.5}, "its required component is 2.9 m away, beyond max_range_m 2.5"),
        ({"min_range_m": 3.0}, "its required component is 2.9 m away, nearer than min_range_m 3"),
        ({"min_scale": 120.0}, "100 px/m, below min_scale 120"),
        ({"max_scale": 80.0}, "100 px/m, above max_scale 80"),
        ({"min_range_m": 2.0, "max_range_m": 3.0, "min_scale": 90.0, "max_scale": 110.0}, None),
        ({}, None),
    ],
)
def test_what_is_out_of_reach_is_no_object_and_says_by_how_much(limits, reason):
    there = replace(claim(WHOLE), depth_m=np.array([2.9]), scale=np.array([100.0]))
    judge, verdict = Judge.of(settings(**limits)), verdict_of(there)
    assert judge.reason(verdict) == reason
    assert judge.trust(verdict) == (0.0 if reason else verdict.probability)


def test_a_low_probability_is_named_with_what_was_confirmed_and_what_came_nearest():
    verdict = verdict_of(claim({TORSO: 300.0, HIND: 60.0}))
    reason = STRICT.reason(verdict)
    assert "hind" in reason and "fore" in reason and "\n" not in reason
    assert reason.index("hind") < reason.index("fore")
    alone = STRICT.reason(verdict_of(claim({TORSO: 300.0})))
    assert "no other component" in alone and ("fore" in alone or "hind" in alone)
    assert "nearest" not in STRICT.reason(verdict_of(claim(WHOLE)))


@pytest.mark.parametrize("against, said", [(-50.0, "nearest to it fore with -50 votes"), (5.0, "with its class on 0%")])
def test_of_what_comes_nearest_it_is_told_what_speaks_against_it(against, said):
    reason = STRICT.reason(verdict_of(claim({TORSO: 300.0, HIND: 60.0}, against=against)))
    assert said in reason


def test_what_is_out_of_view_is_not_said_to_be_near():
    one = claim({TORSO: 300.0, HIND: 60.0})
    fore = [n for n, p in enumerate(one.finder.surface.patches) if p.component == 1]
    one.scores.area_px[0, fore] = 0.0
    assert "nearest" not in STRICT.reason(verdict_of(one))


def test_what_is_out_of_sight_owns_its_pixels_and_is_told_where_that_is_asked_for():
    one = claim({FORE: 600.0, HIND: 600.0}, votes=5000.0)
    root = [n for n, p in enumerate(one.finder.surface.patches) if p.component == 0 and p.marker is not None]
    one.scores.area_px[0, root] = one.scores.votes[0, root] = 0.0
    verdict = verdict_of(one)
    strict, visible = Judge(0.0, 0.0), Judge(0.0, 0.0, unseen=True)
    assert verdict.case == "unseen"
    assert strict.worth(verdict.among)[0] == visible.worth(verdict.among)[0] > 0
    assert strict.reason(verdict) == "where it would be, its required component torso is out of sight"
    assert visible.reason(verdict) is None and visible.shows_required(verdict) and not strict.shows_required(verdict)


def test_an_object_of_one_component_needs_no_other():
    verdict = verdict_of(claim({FACE: 500.0}, votes=2250.0, name="sign"))
    assert JUDGE.reason(verdict) is None
    # inside right, outline wrong
    blurred = verdict_of(claim({FACE: 500.0}, votes=1500.0, name="sign", per_px=3.0))
    assert "outline" in (JUDGE.reason(blurred) or "")
    assert "plate" not in (STRICT.reason(verdict) or "")


@pytest.mark.parametrize("votes", [-1e6, 0.0, 1e12])
def test_any_votes_give_a_probability(votes):
    assert 0 <= verdict_of(claim(WHOLE, votes=votes)).probability <= 1


@pytest.mark.parametrize(
    "limits",
    [{}, {"min_probability": 0.9}, {"min_components": 3}, {"max_range_m": 2.5}, {"min_scale": 120}, {"max_scale": 80}],
    ids=str,
)
def test_what_is_accepted_has_no_reason_against_it(limits):
    """All claims at once, and each for itself with its reason."""
    seen = [WHOLE, {TORSO: 300.0, FORE: 60.0}, {TORSO: 300.0}, {FORE: 200.0, HIND: 200.0}]
    several = [claim(s, votes=v) for s in seen for v in (40.0, 800.0, 3000.0)]
    n, judge = len(several), Judge.of(settings(**limits))
    scores = PatchScores(*map(np.concatenate, zip(*(c.scores.arrays for c in several), strict=True)))
    poses = Poses.concatenate([c.poses for c in several])
    votes = np.concatenate([c.votes for c in several])
    misplaced = [None if i % 5 else "behind the wall" for i in range(n)]
    depth = np.where(np.arange(n) % 2, 2.9, np.nan)
    finder = several[0].finder
    place = depth, 290 / depth, np.full(n, 4.0), misplaced
    seen, frame = Seen(scores.area_px, np.zeros(n)), FRAMES["truck"]
    verdicts = verdicts_of(Claims(finder, poses, votes, scores, seen, frame, *place))
    reasons = [judge.reason(v) for v in verdicts]
    assert judge.accepts(verdicts).tolist() == [r is None for r in reasons]
    trusted = [judge.trust(v) * v.claim.votes if v.claim.votes > judge.min_votes else -np.inf for v in verdicts]
    np.testing.assert_allclose(judge.worth(verdicts), trusted)
    alone = [verdict_of(c) for c in several]
    assert [v.probability for v in alone] == [v.probability for v in verdicts]
