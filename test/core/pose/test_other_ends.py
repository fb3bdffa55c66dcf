"""Long markers that something touches, or of which labels are wider or narrower: told as they likeliest are, no surer
than their other ends allow."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import rectangle
from squares import BODY, TEAM, Placing, patch, rendered, robot

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.likelier_ends import likelier_ends
from artrec_ros.core.pose.other_ends import AT_EDGE, BENEATH, BEYOND, GOES_ON
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.tracking.turns import _others_share

SIZE, SCALE = (420, 300), 400.0
LENGTH, WIDTH = 0.36, 0.03  # 144 x 12 px
BAR = Target(
    "bar", ObjectModel("bar", (Component("bar", (patch("bar", rectangle(LENGTH, WIDTH)),), required=True),)), TEAM
)
USED = np.ones((1, 1), bool)


@dataclass(frozen=True)
class Touched(Placing):
    """A bar that is wider by some pixels all around, and what lies at its end: a share of its length, its width;
    or the share of its length that is covered there by what no file knows."""

    wider_px: float = 0.0
    stray: float = 0.0
    stray_width: float = WIDTH
    covered: float = 0.0

    def patches(self):
        more, reach = 2 * self.wider_px / self.scale, self.stray * LENGTH
        out = [(self.at(rectangle(LENGTH + more, WIDTH + more)), TEAM)]
        if reach:
            out.append(
                (self.at(rectangle(reach + 0.01, self.stray_width, (LENGTH / 2 + reach / 2 - 0.005, 0.0))), TEAM)
            )
        if self.covered:
            out.append((self.at(rectangle(0.1, 0.1, (LENGTH * (0.5 - self.covered) + 0.05, 0.0))), BODY))
        return out


PLAIN = Touched(210.0, 150.0, 0.3, SCALE)


def told(placing, **values):
    config = settings(min_scale=200.0, max_scale=700.0, **values)
    recognizer = Recognizer([BAR], config, Segmenter(ImageConfig()), calibrated=False)
    (found,) = recognizer.recognize(rendered(placing, size=SIZE)).detections
    return found


def finder_and_frame(placing):
    frame = ImageFrame(LabelField(rendered(placing, size=SIZE))).faced()
    return WholeObjectFinder(BAR, replace(DEFAULTS, min_scale=200.0), facing=True), frame


def resized(poses, times):
    return Poses(poses.R, poses.t / times, poses.q)


@pytest.mark.parametrize("stray", [1 / 8, 1 / 6])
def test_what_goes_straight_on_at_one_end_is_told_in_doubt(stray):
    found = told(replace(PLAIN, stray=stray))
    either = [found.image, found.other_place.image]
    assert any(abs(image.scale / SCALE - 1) < 0.02 for image in either)
    assert found.score < 0.85 and found.other_place.probability > 0.05
    assert found.there > 0.95 * told(PLAIN).score and not found.may_be_elsewhere  # it is there all the same
    assert _others_share(found) is None  # it is no turn that frames before tell


def test_one_that_may_be_smaller_is_told_however_sure_one_must_be():
    found = told(replace(PLAIN, stray=1 / 8), min_probability=0.9)
    assert found.score < 0.9 < found.there


@pytest.mark.parametrize("stray", [1 / 8, 1 / 3])
def test_what_is_wider_at_one_end_is_none_of_it(stray):
    found = told(replace(PLAIN, stray=stray, stray_width=2 * WIDTH))
    assert found.image.scale == pytest.approx(SCALE, rel=0.02) and found.score > 0.6


@pytest.mark.parametrize("wider_px", [0.5, 0.75])
def test_wider_labels_make_no_bar_longer_than_they_are(wider_px):
    found = told(replace(PLAIN, wider_px=wider_px))
    assert found.image.scale == pytest.approx(SCALE, rel=0.03) and found.score > 0.7


@pytest.mark.parametrize("covered", [1 / 12, 1 / 10, 1 / 8])
def test_one_with_a_covered_end_is_not_surely_as_long_as_what_is_left_of_it(covered):
    found = told(replace(PLAIN, covered=covered))
    assert abs(found.image.scale / SCALE - 1) < 0.05 or found.score < 0.9


@pytest.mark.parametrize("covered", [1 / 10, 1 / 8, 1 / 6])
def test_one_that_another_class_covers_is_as_long_as_it_is_wide(covered):
    assert told(replace(PLAIN, covered=covered)).image.scale == pytest.approx(SCALE, rel=0.05)


def of_label(was, now):
    return lambda labels: np.where(labels == was, now, labels).astype(np.uint8)


@pytest.mark.parametrize("covered", [1 / 10, 1 / 8, 1 / 6])
def test_one_that_ends_short_in_the_open_is_not_surely_so(covered):
    image = of_label(BODY, 0)(rendered(replace(PLAIN, covered=covered), size=SIZE))
    config = settings(min_scale=200.0, max_scale=700.0)
    (found,) = Recognizer([BAR], config, Segmenter(ImageConfig()), calibrated=False).recognize(image).detections
    assert abs(found.image.scale / SCALE - 1) < 0.05 or found.score < 0.9


def state_and_evidence(placing, change=lambda labels: labels, owned=(), times=1.0):
    frame = ImageFrame(LabelField(change(rendered(placing, size=SIZE)))).faced().without(owned)
    finder = WholeObjectFinder(BAR, DEFAULTS, facing=True)
    seen = finder.other_ends.seen(frame, resized(PLAIN.pose(frame.camera), times), USED[0], np.arange(2))
    return sorted(seen.state[0].tolist()), seen.evidence[0]


def test_an_end_beneath_another_class_or_another_object_is_not_amiss_and_one_in_the_open_is():
    covered = replace(PLAIN, covered=1 / 4)
    state, evidence = state_and_evidence(covered)
    assert state == [AT_EDGE, BENEATH] and (evidence[:3] == 0).all()
    state, evidence = state_and_evidence(covered, of_label(BODY, 0))
    assert state == [AT_EDGE, BEYOND] and evidence[1] == -1
    hull = covered.at(rectangle(0.1, 0.1, (LENGTH / 4 + 0.05, 0.0))).astype(np.float32)
    state, evidence = state_and_evidence(PLAIN, owned=[hull])
    assert state == [AT_EDGE, BENEATH] and (evidence[:3] == 0).all()


def test_what_covers_a_bar_begins_just_at_its_end_by_chance_alone():
    beside = replace(PLAIN, covered=1e-9)
    assert state_and_evidence(PLAIN)[1][0] == 0
    state, evidence = state_and_evidence(beside)
    assert state == [AT_EDGE, AT_EDGE] and evidence[0] == -1
    found = told(beside)
    assert found.image.scale == pytest.approx(SCALE, rel=0.02)


def test_ground_that_has_a_class_covers_nothing():
    for times in (1.0, 1.15):
        state, evidence = state_and_evidence(PLAIN, of_label(0, BODY), times=times)
        same, without = state_and_evidence(PLAIN, times=times)
        assert state == same and BENEATH not in state
        np.testing.assert_array_equal(evidence[:3], without[:3])


def test_of_a_bar_as_it_should_be_nothing_is_in_doubt():
    found = told(PLAIN)
    assert found.other_place is None and found.as_told == 1 and found.score > 0.95


def test_each_reading_has_an_end_otherwise():
    finder, frame = finder_and_frame(replace(PLAIN, stray=1 / 4))
    spans = resized(PLAIN.pose(frame.camera), 1.25)
    along = spans.R[0] @ (LENGTH / 10, 0.0, 0.0)  # the middle of both
    spans = Poses(spans.R, spans.t + along, spans.q)
    others, odds = finder.other_ends.of(frame, spans, USED[0])
    seen = finder.other_ends.seen(frame, Poses.concatenate([spans, others]), USED[0], np.arange(2))
    assert sorted(map(tuple, seen.state.tolist())) == [(AT_EDGE, AT_EDGE), (AT_EDGE, GOES_ON), (GOES_ON, AT_EDGE)]
    scale = frame.camera.focal_px / others.t[:, 2]
    np.testing.assert_allclose(scale, SCALE, rtol=0.05)  # by its width
    assert odds[0] == pytest.approx(odds[1], abs=0.3)  # nothing tells which end is the true one


def test_beneath_what_covers_it_an_end_may_be_here_or_there():
    finder, frame = finder_and_frame(replace(PLAIN, covered=1 / 4))
    short = resized(PLAIN.pose(frame.camera), 0.88)
    along = short.R[0] @ (-0.06 * LENGTH / 0.88, 0.0, 0.0)  # the open end of both
    short = Poses(short.R, short.t + along, short.q)
    others, _ = finder.other_ends.of(frame, short, USED[0])
    seen = finder.other_ends.seen(frame, Poses.concatenate([short, others]), USED[0], np.arange(2))
    beneath = np.flatnonzero((np.sort(seen.state, axis=1) == (AT_EDGE, BENEATH)).all(axis=1))
    assert beneath[0] == 0 and len(beneath) > 1
    scale = frame.camera.focal_px / others.t[beneath[1:] - 1, 2]
    np.testing.assert_allclose(scale, SCALE, rtol=0.05)


@pytest.mark.parametrize("least", [200.0, 450.0])
def test_no_reading_leaves_the_scale_that_is_looked_for(least):
    _, frame = finder_and_frame(replace(PLAIN, stray=1 / 4))
    finder = WholeObjectFinder(BAR, replace(DEFAULTS, min_scale=least, max_scale=600.0), facing=True)
    others, _ = finder.other_ends.of(frame, resized(PLAIN.pose(frame.camera), 1.25), USED[0])
    scale = frame.camera.focal_px / others.t[:, 2]
    assert (scale >= least).all() and (scale < 450).any() == (least < 450)


def test_no_other_ends_are_sought_without_time_or_long_markers():
    finder, frame = finder_and_frame(replace(PLAIN, stray=1 / 4))
    pose = resized(PLAIN.pose(frame.camera), 1.25)
    late = replace(frame, deadline=Deadline(-1.0))
    for where, hopes in ((frame, True), (late, False)):
        same, ends, _ = likelier_ends(finder, where, pose, USED)
        assert (ends[0] is not None) == hopes and len(same) == 1
    plain = WholeObjectFinder(Target("robot", robot(alternatives=False), TEAM), DEFAULTS, facing=True)
    assert not plain.other_ends.may_be
    assert WholeObjectFinder(BAR, DEFAULTS).other_ends is None  # in space slants are told beside
