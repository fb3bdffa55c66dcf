"""Searching an image blob by blob: short looks before long ones, pixels taken at once, time kept."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, StubJudge, camera_of, marker, pose, rectangle, render, truck

from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.finds import Finds
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.spatial_looks import SpatialLooks
from artrec_ros.core.spatial_search import SpatialSearch
from artrec_ros.core.verdict.acceptance_curves import LIKELY, SURE
from artrec_ros.core.verdict.judge import Judge

CAMERA = camera_of()
TRUCK = truck()
LEFT = pose(-0.25, 0, 1.0, 0.3, model=TRUCK)
RIGHT = pose(0.25, 0.02, 1.1, -0.4, model=TRUCK, joints={"hind": 0.3})


@pytest.fixture(scope="module")
def finder():
    return WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)


@pytest.fixture
def looks(monkeypatch):
    """Areas of the blobs that a long look is taken at."""
    areas, guesses = [], WholeObjectFinder.guesses

    def counted(self, frame, blob, piece=0):
        if not piece:
            areas.append(blob.area_px)
        return guesses(self, frame, blob, piece)

    monkeypatch.setattr(WholeObjectFinder, "guesses", counted)
    return areas


def search(finder, trust, budget_s=float("inf")):
    """Candidates for two trucks side by side, and the number of blobs they make."""
    labels = render(CAMERA, [(TRUCK, LEFT, RED), (TRUCK, RIGHT, RED)])
    blobs = find_blobs(labels, {RED}, RecognizerConfig())
    frame = ImageFrame(LabelField(labels), CAMERA, Deadline(budget_s))
    return SpatialSearch(frame, StubJudge(given=lambda verdict: trust), DEFAULTS.search).run([finder], blobs), blobs


def nearest(poses, truth):
    return np.linalg.norm(poses.t - truth.t, axis=1).min()


def test_blobs_that_sure_objects_explain_get_no_long_look(finder, looks):
    ((_, poses),), blobs = search(finder, trust=1.0)
    assert len(blobs) > 2
    assert not looks
    assert len(poses) < 10 and nearest(poses, LEFT) < 0.02 and nearest(poses, RIGHT) < 0.02


def test_where_there_is_doubt_every_blob_gets_a_long_look(finder, looks):
    ((_, poses),), blobs = search(finder, trust=0.5)
    assert sorted(looks) == sorted(b.area_px for b in blobs)
    assert nearest(poses, LEFT) < 0.02 and nearest(poses, RIGHT) < 0.02


def test_other_blobs_of_likely_objects_get_no_long_look_either(finder, looks):
    ((_, poses),), blobs = search(finder, trust=(LIKELY + SURE) / 2)
    assert len(looks) == 2 < len(blobs)
    assert nearest(poses, LEFT) < 0.02 and nearest(poses, RIGHT) < 0.02


def test_where_there_is_no_hope_nothing_climbs(finder, monkeypatch):
    """No climb makes an object of what is all but impossible."""
    climbs, climbed = [], WholeObjectFinder.climbed

    def counted(self, frame, found, climb, **options):
        climbs.append(climb)
        return climbed(self, frame, found, climb, **options)

    monkeypatch.setattr(WholeObjectFinder, "climbed", counted)
    search(finder, trust=0.5)
    full = len(climbs)
    climbs.clear()
    verdicts = Judge.verdicts

    def probable(best):
        """The last of the candidates is so probable, the others less than would do."""

        def changed(self, *about, **options):
            found = verdicts(self, *about, **options)
            probability = np.full(len(found), DEFAULTS.search.hopeless / 2)
            probability[-1:] = best
            return replace(found, probability=probability)

        monkeypatch.setattr(Judge, "verdicts", changed)

    probable(DEFAULTS.search.hopeless / 2)
    search(finder, trust=0.5)
    assert full > 0 == len(climbs)
    probable(0.5)
    search(finder, trust=0.5)
    assert len(climbs) > 0


def test_a_blob_that_leads_to_no_pattern_is_not_looked_at_twice(looks):
    """Of an object alike throughout any other blob would."""
    squares = [
        Component(f"s{n}", (marker("m", rectangle(0.05, 0.05), np.eye(3), (0.07 * n, 0, 0)),), required=n == 1)
        for n in range(4)
    ]
    row = ObjectModel("row", tuple(squares))
    at = Poses(np.diag([1.0, -1.0, -1.0])[None], np.array([[-0.3, 0.1, 1.0]]), np.zeros((1, 0)))
    labels = render(CAMERA, [(row, at, RED)])
    rng = np.random.default_rng(1)
    for x, y in ((30, 30), (150, 40), (260, 200), (250, 60)):  # ragged patches
        angles = np.sort(rng.uniform(0, 2 * np.pi, 9))
        patch = (x, y) + rng.uniform(6, 25, (9, 1)) * np.column_stack([np.cos(angles), np.sin(angles)])
        cv2.fillPoly(labels, [np.rint(patch).astype(np.int32)], RED)
    finder = WholeObjectFinder(Target("row", row, RED), DEFAULTS)
    frame = ImageFrame(LabelField(labels), CAMERA)
    blobs = find_blobs(labels, {RED}, RecognizerConfig())
    ((_, poses),) = SpatialSearch(frame, Judge.of(DEFAULTS), DEFAULTS.search).run([finder], blobs)
    assert len(blobs) == 8 and len(looks) < 2
    assert nearest(poses, at) < 0.02


def test_without_time_nothing_is_looked_at(finder, looks):
    found, blobs = search(finder, trust=0.5, budget_s=0.0)
    assert blobs and not looks
    assert not found


def test_blobs_of_other_classes_are_not_asked(looks):
    other = WholeObjectFinder(Target("other", TRUCK, RED + 1), DEFAULTS)
    found, _ = search(other, trust=0.5)
    assert not found and not looks


class Certain:
    """A judge of poses by the depth at which they lie: a claim at 0.7 m has a trust of 0.7."""

    unseen = False

    def trust_in(self, finder, poses, frame):
        return float(poses.t[0, 2]) if len(poses) else 0.0

    def trust_and_place(self, finder, poses, frame):
        return self.trust_in(finder, poses, frame), True


class Pieces:
    """A finder of blobs that may be of several objects."""

    def __init__(self, several=True):
        self.several = several

    def may_be_several(self, blob):
        return self.several


def at(*depths):
    return Poses(
        np.tile(np.eye(3), (len(depths), 1, 1)), np.array([[0, 0, z] for z in depths]), np.zeros((len(depths), 0))
    )


@pytest.mark.parametrize(
    ("several", "trusts", "order"),
    [
        (True, (0.99, 0.5, 0.5), [0.99]),  # beyond doubt: no other size is looked for
        (True, (0.9, 0.95, 0.97), [0.97, 0.9, 0.95]),
        (True, (0.5, 0.6, 0.7), [0.5, 0.6, 0.7]),  # none is sure
        (True, (0.0, 0.99, 0.5), [0.99, 0.0]),
        (False, (0.9, 0.95, 0.97), [0.9]),
    ],
)
def test_a_blob_of_several_things_is_looked_at_in_all_sizes(monkeypatch, several, trusts, order):
    monkeypatch.setattr(SpatialLooks, "close", lambda self, frame, finder, blob, piece=0: at(trusts[piece]))
    looks = SpatialLooks(Certain(), DEFAULTS.search)
    frame = ImageFrame(LabelField(np.zeros((4, 4), np.uint8)), CAMERA)
    assert looks.thorough(frame, Pieces(several), None).t[:, 2].tolist() == order


@pytest.mark.parametrize(("trust", "sure"), [(0.99, True), (0.9, False)])
@pytest.mark.parametrize("late", [False, True])
def test_what_few_guesses_find_counts_where_it_is_beyond_doubt_or_there_is_no_time(
    finder, trust, sure, late, monkeypatch
):
    labels = np.zeros((240, 320), np.uint8)
    labels[100:140, 100:160] = RED
    frame = ImageFrame(LabelField(labels), CAMERA, Deadline(100.0))
    found = Poses(LEFT.R, LEFT.t * 0 + np.array([[0, 0, trust]]), LEFT.q)

    def plain(self, *args):
        if late:
            monkeypatch.setattr(Deadline, "expired", True)
        return found

    monkeypatch.setattr(SpatialLooks, "plain", plain)
    monkeypatch.setattr(SpatialLooks, "thorough", lambda *args: None)
    told = SpatialSearch(frame, Certain(), DEFAULTS.search).run([finder], find_blobs(labels, {RED}, DEFAULTS))
    assert sum(len(poses) for _, poses in told) == int(sure or late)


@pytest.mark.parametrize(("tilt", "sure"), [(0.0, True), (0.3, False)])
def test_whose_required_component_has_no_outline_takes_no_pixels(finder, tilt, sure):
    """It lies across something of its class that another hypothesis may explain."""
    frame = ImageFrame(LabelField(render(CAMERA, [(TRUCK, LEFT, RED)])), CAMERA)
    one = pose(-0.25, 0, 1.0, 0.3, tilt, model=TRUCK)
    judge = StubJudge(given=lambda verdict: 1.0)
    finds = Finds(frame, judge, DEFAULTS.search)
    assert judge.trust_in(finder, one, frame) == 1.0
    assert finds.take(finder, one) == sure
    assert (finds.frame is frame) == (not sure)


def test_what_sure_objects_leave_of_a_blob_that_they_share_is_looked_at():
    """A plate behind a larger one of its class, whose contour is most of that of both."""
    outline = np.array([(-0.1, -0.06), (0.1, -0.06), (0.1, 0.0), (0.04, 0.06), (-0.1, 0.06)])
    plate = ObjectModel("plate", (Component("plate", (marker("m", outline, np.eye(3), (0, 0, 0)),), required=True),))
    facing = np.diag([1.0, -1.0, -1.0])[None]
    near, far = (Poses(facing, np.array([t]), np.zeros((1, 0))) for t in ((-0.12, 0.0, 0.5), (0.02, -0.1, 1.0)))
    labels = render(CAMERA, [(plate, far, RED), (plate, near, RED)])
    blobs = find_blobs(labels, {RED}, RecognizerConfig())
    finder = WholeObjectFinder(Target("plate", plate, RED), DEFAULTS)
    frame = ImageFrame(LabelField(labels), CAMERA)
    ((_, poses),) = SpatialSearch(frame, Judge.of(DEFAULTS), DEFAULTS.search).run([finder], blobs)
    assert len(blobs) == 1
    assert nearest(poses, near) < 0.02 and nearest(poses, far) < 0.05
