"""Many flat objects that face the camera: more than there are names, and such as touch one another."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from settings import settings
from squares import BACK, COLOURS, SIDE, TEAM, Placing, rendered, robot

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.facing_search import FacingSearch
from artrec_ros.core.facing_stage import FacingStage
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.range_limits import scale_limits
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.claims import silhouette
from artrec_ros.core.verdict.identity import NOT_FIRST
from artrec_ros.core.verdict.judge import Judge

SCALE, SIZE = 190.0, (220, 160)
LOST = (3, 0.2, 0.96), (16, 0.4, 1.0)  # rows of three of which the first look finds two


def recognizer(model, **options):
    return Recognizer(
        (Target("robot", model, TEAM),), settings(time_budget_ms=60000, **options), Segmenter(ImageConfig())
    )


def found_at(result, at):
    off = [np.hypot(d.image.x - at.x, d.image.y - at.y) for d in result.detections]
    return bool(off) and min(off) < 0.3 * SIDE * at.scale


PLACED = [
    Placing(30.2, 30.3, 0.4, 300.0, "gr"), Placing(80.4, 33.1, 2.0, 300.0, "gv"),
    Placing(130.3, 30.4, -1.0, 300.0, "rg"), Placing(40.1, 90.2, 3.0, 300.0, "vr"),
    Placing(100.1, 95.2, 0.1, 300.0, "gr"),
]  # fmt: skip


@pytest.mark.parametrize("camera", [None, Camera.facing(SIZE)])
def test_where_each_name_occurs_once_there_are_no_more_objects_than_names(camera):
    """In the image, and in space."""
    picture = rendered(*PLACED, size=SIZE)
    assert len(recognizer(robot(unique=False)).recognize(picture, camera).detections) == 5
    result = recognizer(robot()).recognize(picture, camera)
    assert len(result.detections) == 4
    assert {d.identity.name for d in result.detections} <= {"gr", "gv", "rg", "vr", None}
    reasons = [r for r in result.rejected if r.reason == NOT_FIRST]
    assert len(reasons) == 1 and 0 < reasons[0].score < 0.6  # beside who shows the same name
    assert min(d.as_told for d in result.detections) < 1 - 0.5 * reasons[0].score
    assert not found_at(result, Placing(reasons[0].x, reasons[0].y, 0.0, 300.0))


def test_the_one_that_goes_is_the_one_that_shows_no_name():
    """A fifth one has the team's patch and, in front, a blend of all classes' pixels."""
    placed = [*PLACED[:4], Placing(100.1, 95.2, 0.1, 300.0, "gr")]
    picture = rendered(*placed, size=SIZE)
    front, rng = np.isin(picture[75:120, 75:125], list(COLOURS.values())), np.random.default_rng(0)
    picture[75:120, 75:125][front] = rng.choice(list(COLOURS.values()), int(front.sum()))
    result = recognizer(robot()).recognize(picture)
    assert sorted(d.identity.name for d in result.detections) == ["gr", "gv", "rg", "vr"]
    assert all(found_at(result, at) for at in placed[:4]) and not found_at(result, placed[4])


def test_which_one_of_an_object_that_occurs_once_is_told_is_asked_of_all_pixels():
    """What one leaves is easily like another; the probabilities that are shared out do not decide."""
    once = replace(robot(alternatives=False), unique=True)
    picture, places = rendered(*PLACED[:2], size=SIZE), PLACED[:2]
    result = recognizer(once).recognize(picture)
    assert len(result.detections) == 1 and [r.reason for r in result.rejected] == [NOT_FIRST]

    config = settings(time_budget_ms=60000)
    stage = FacingStage([Target("robot", once, TEAM)], config)
    faced, blobs = ImageFrame(LabelField(picture)).faced(), find_blobs(picture, {TEAM}, config)
    accepted = stage.verdicts(faced, blobs, scale_limits(config, None)).accepted
    (describer,), asked = stage.describers, []

    class Alone(tuple):
        claims = SimpleNamespace(votes=np.ones(2))

    class Asked:
        def verdicts(self, finder, poses, frame):
            asked.append((len(poses), frame.field.unowned is frame.field))
            return Alone(("alone", i) for i in range(len(poses)))

    for best in (0, 1):
        probability = np.where(np.arange(2) == best, 0.8, 0.2)
        both = [replace(v, alone=p) for v, p in zip(accepted, probability, strict=True)]
        told, left, rivals = describer.without_surplus(both, faced, Asked())
        assert left == [("alone", 1 - best)]  # as they were compared
        assert told == [both[0] if best == 0 else ("alone", 1)]  # what was judged by what the other left
        ((rival,),) = rivals.values()
        assert [*rivals] == told and rival.verdict == left[0]
        assert rival.log_odds == pytest.approx(np.log(0.2 / 0.8) - np.log(0.8 / 0.2))
    assert asked == [(2, True)] * 2 and len(places) == len(accepted)


def chain(seed, bend=0.2, pitch=0.96):
    """Three robots with their team's patches side by side, turned a little: one blob of three."""
    rng = np.random.default_rng(seed)
    turn, bent = rng.uniform(-np.pi, np.pi), rng.uniform(-bend, bend, 2)
    side, out = pitch * np.array([-np.sin(turn), -np.cos(turn)]) * SIDE * SCALE, []
    for n, name in enumerate(("gr", "gv", "vr")):
        at = np.array([110.3, 80.2]) + (n - 1) * side
        out.append(Placing(*at, turn + (0.0, *bent)[n], SCALE, name))
    return out


@pytest.mark.parametrize("look_again", [True, False])
def test_what_those_that_touch_leave_is_looked_at_again(monkeypatch, look_again):
    """One of three in a row has lost its place to a hypothesis that lies across two."""
    if not look_again:
        monkeypatch.setattr(FacingSearch, "roomy", lambda *args: [])
    engine = recognizer(robot(), min_scale=140.0, max_scale=260.0)
    found = [len(engine.recognize(rendered(*chain(*row), size=SIZE)).detections) for row in LOST]
    assert found == [3, 3] if look_again else sum(found) < 6


@pytest.mark.parametrize("seed", range(4))
def test_what_those_that_touch_leave_of_their_blob_is_another_blob(seed):
    """Of three that make one blob those are found that are given: what they leave is the others' patches."""
    placed, config = chain(seed), settings()
    finder = WholeObjectFinder(Target("robot", robot(), TEAM), config, facing=True)
    search, labels = FacingSearch(finder, config), rendered(*placed, size=SIZE)
    frame, (blob,) = ImageFrame(LabelField(labels)).faced(), find_blobs(labels, {TEAM}, config)
    for known in ([0], [2], [0, 2], [0, 1, 2]):
        found = Poses.concatenate([placed[i].pose(frame.camera) for i in known])
        solids = [silhouette(finder.surface, frame.camera, found[[i]]) for i in range(len(found))]
        rest = frame.without([hull for hulls in solids for hull in hulls])
        roomy = search.roomy(frame, [blob], found)
        assert bool(roomy) == (len(known) < 3)
        if roomy:
            (left,) = search.pieces(rest, roomy, found)
            missed = [p for i, p in enumerate(placed) if i not in known]
            middle = np.mean([p.at([BACK.mean(axis=0)])[0] for p in missed], axis=0)
            assert np.linalg.norm(left.contour.mean(axis=0) - middle) < 3.0
            assert 0.7 < left.area_px / (len(missed) * finder.target.model.required.markers[0].area * SCALE**2) < 1.3


def test_what_is_left_around_one_that_is_found_is_nothing():
    at, config = Placing(110.3, 80.2, 0.7, SCALE, "gr"), settings()
    finder = WholeObjectFinder(Target("robot", robot(), TEAM), config, facing=True)
    labels = rendered(at, size=SIZE)
    frame, (blob,) = ImageFrame(LabelField(labels)).faced(), find_blobs(labels, {TEAM}, config)
    assert not FacingSearch(finder, config).roomy(frame, [blob], at.pose(frame.camera))


def test_fits_keep_to_the_limits_of_the_scale_where_they_are():
    """One that grows over several that touch would take the place of right ones, and be turned down in the end."""
    config = settings(min_scale=160.0, max_scale=220.0)
    finder = WholeObjectFinder(Target("robot", robot(), TEAM), config, facing=True)
    frame = ImageFrame(LabelField(rendered(size=SIZE))).faced()
    placed = [Placing(110.3, 80.2, 0.7, scale) for scale in (90.0, 190.0, 350.0)]
    poses = Poses.concatenate([at.pose(frame.camera) for at in placed])
    kept = finder.climber.within_limits(frame.camera, poses)
    np.testing.assert_allclose(frame.camera.focal_px / kept.t[:, 2], (160.0, 190.0, 220.0))
    np.testing.assert_allclose(project(frame.camera, kept.t), project(frame.camera, poses.t))


@pytest.mark.parametrize(("owned", "told"), [(0.5, True), (0.8, False)])
def test_what_others_leave_of_their_rims_is_no_object(owned, told):
    """Of a candidate of which others own almost all, whatever the rest looks like."""
    finder = WholeObjectFinder(Target("robot", robot(), TEAM), settings(), facing=True)
    at, judge = Placing(110.3, 80.2, 0.7, SCALE, "gr"), replace(Judge.of(settings()), min_votes=1.0)
    frame = ImageFrame(LabelField(rendered(at, size=SIZE))).faced()
    poses = at.pose(frame.camera)
    middles = [(hull, hull.mean(axis=0)) for hull in silhouette(finder.surface, frame.camera, poses)]
    rest = frame.without([np.float32(middle + np.sqrt(owned) * (hull - middle)) for hull, middle in middles])
    verdicts = judge.verdicts(finder, poses, rest)
    assert judge.accepts(verdicts).tolist() == [told]
    assert judge.reason(verdicts[0]) == (None if told else "almost all of it lies where others are found")


def test_one_within_a_border_of_its_class_does_not_stand_in_it():
    at, config = Placing(110.3, 80.2, 0.7, SCALE, "gr"), settings()
    finder = WholeObjectFinder(Target("robot", robot(), TEAM), config, facing=True)
    labels = rendered(at, size=SIZE)
    labels[4:-4, 4:9] = labels[4:-4, -9:-4] = labels[4:9, 4:-4] = labels[-9:-4, 4:-4] = TEAM
    frame, blobs = ImageFrame(LabelField(labels)).faced(), find_blobs(labels, {TEAM}, config)
    assert len(blobs) == 2 and not FacingSearch(finder, config).roomy(frame, blobs, at.pose(frame.camera))
