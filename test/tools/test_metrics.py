"""The scoring rules on scenes whose counts are known by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import Detection, IdentityFit, ImagePose, Instance
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.io.truth.records import Told, TrueComponent, TrueObject
from artrec_ros.tools.evaluation.completion import with_own_names
from artrec_ros.tools.evaluation.metrics import Counts, judge_frame, shows

POSE = Pose.from_xyz_rpy([0.0, 0.0, 2.0])


def true_object(x, torso=(400, 400), leg=(100, 100), **others) -> TrueObject:
    """A torso at (x, 50) and a leg at (x, 80), each with its full and visible area."""
    parts = {"torso_left": (*torso, (x, 50)), "leg@front": (*leg, (x, 80)), **others}
    components = {n: TrueComponent(full, seen, np.array(at, float)) for n, (full, seen, at) in parts.items()}
    return TrueObject(3, POSE, components, np.array([x, 55.0]))


def score_frame(objects, detections, root) -> Counts:
    outcome = judge_frame(objects, detections, root)
    return Counts.of(outcome.outcomes) + Counts(false=len(outcome.false))


def detection(x, leg_at=None, pose=POSE) -> Detection:
    """A torso at (x, 50) and, if given, a leg there."""
    places = {"torso": (x, 50.0)} | ({} if leg_at is None else {"leg": leg_at})
    parts = tuple(Instance(n, "m", 0.9, *at, 0.0, 100.0) for n, at in places.items())
    return Detection("red", 0, 0.9, ImagePose(x, 50, 0, 100), parts, pose)


def test_a_perfect_frame():
    counts = score_frame([true_object(100)], [detection(100, (100, 80))], "torso")
    assert (counts.objects, counts.recognised, counts.right, counts.false) == (1, 1, 1, 0)
    assert (counts.components_right, counts.components_wrong, counts.components_missed) == (1, 0, 0)
    assert counts.position_errors == (0.0,) and counts.rotation_errors_rad == (0.0,)


def test_pose_errors_have_their_known_size():
    pose = Pose.from_xyz_rpy([0.0, 0.03, 2.04], [0.0, 0.25, 0.0])
    counts = score_frame([true_object(100)], [detection(100, (100, 80), pose)], "torso")
    assert counts.position_errors == (pytest.approx(0.025),)
    assert counts.rotation_errors_rad == (pytest.approx(0.25),)


def test_one_whose_required_component_nobody_marked_excuses_who_lies_on_its_others():
    """As an annotator leaves out what is hidden: 40 px lie between the leg and the torso."""
    told = true_object(100)
    told = replace(told, components={"leg@front": told.components["leg@front"]}, centre_px=np.array([100.0, 90.0]))
    on_it, elsewhere = detection(100, (100, 80)), detection(160, (160, 80))
    counts = score_frame([told], [on_it, elsewhere], "torso")
    assert (counts.objects, counts.recognised, counts.false) == (0, 0, 1)
    assert judge_frame([told], [on_it, elsewhere], "torso").false == (elsewhere,)


def test_a_missed_component_makes_it_not_right():
    counts = score_frame([true_object(100)], [detection(100)], "torso")
    assert (counts.recognised, counts.right, counts.components_missed) == (1, 0, 1)


@pytest.mark.parametrize("leg", [(24, 24), (100, 69)])
def test_a_component_that_hardly_shows_may_be_missed(leg):
    counts = score_frame([true_object(100, leg=leg)], [detection(100)], "torso")
    assert (counts.right, counts.components_missed) == (1, 0)


def test_a_component_with_two_markers_is_missed_once():
    both = true_object(100, **{"leg@side": (100, 100, (104, 80))})
    assert score_frame([both], [detection(100)], "torso").components_missed == 1


@pytest.mark.parametrize(("offset", "right"), [(4.4, 1), (4.6, 0)])  # 0.35 * sqrt(100) + 1 = 4.5
def test_a_component_must_lie_on_its_own(offset, right):
    counts = score_frame([true_object(100)], [detection(100, (100 + offset, 80))], "torso")
    assert (counts.right, counts.components_right, counts.components_wrong) == (right, right, 1 - right)


@pytest.mark.parametrize(("offset", "hit"), [(9.9, 1), (10.1, 0)])  # 0.5 * sqrt(400) = 10
def test_an_object_is_recognised_near_its_required_component(offset, hit):
    far_below = replace(true_object(100), centre_px=np.array([100.0, 500.0]))
    counts = score_frame([far_below], [detection(100 + offset, (100, 80))], "torso")
    assert (counts.recognised, counts.false) == (hit, 1 - hit)


@pytest.mark.parametrize("torso", [(29, 29), (400, 199)])
def test_an_object_out_of_view_neither_counts_nor_makes_its_detection_false(torso):
    counts = score_frame([true_object(100, torso=torso, leg=(400, 400))], [detection(100, (100, 80))], "torso")
    assert (counts.objects, counts.recognised, counts.false) == (0, 0, 0)


def test_of_two_detections_on_one_object_one_is_false():
    counts = score_frame([true_object(100)], [detection(103, (100, 80)), detection(100, (100, 80))], "torso")
    assert (counts.recognised, counts.false) == (1, 1)


def test_crossed_neighbours_get_the_assignment_with_the_least_sum():
    objects = [true_object(100), true_object(108)]
    found = [detection(107, (108, 80)), detection(99, (100, 80))]
    counts = score_frame(objects, found, "torso")
    assert (counts.recognised, counts.right, counts.false) == (2, 2, 0)


def test_nothing_found_and_nothing_there():
    assert score_frame([], [], "torso") == Counts()
    assert score_frame([true_object(100)], [], "torso") == Counts(objects=1, judged=1)
    assert score_frame([], [detection(1)], "torso") == Counts(false=1)


def test_names_of_the_truth():
    assert shows("torso", "torso") and shows("torso_left", "torso") and shows("leg@front", "leg")
    assert not shows("torsos", "torso") and not shows("leg@front", "front")


def test_a_component_whose_name_begins_as_anothers_is_no_side_of_it():
    square = np.array([(0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1)])
    marker = Marker("square", square, square[0], square[1])
    model = ObjectModel("toy", (Component("torso", (marker,), required=True), Component("torso_left", (marker,))))
    truth = with_own_names(true_object(100), model)
    assert [name for name in truth.components if shows(name, "torso_left")] == ["torso_left@"]
    assert not any(shows(name, "torso") for name in truth.components)
    parts = {"torso": ((400, 400), (100.0, 50.0)), "torso_left": ((100, 100), (150.0, 50.0))}
    components = {n: TrueComponent(*px, np.array(at)) for n, (px, at) in parts.items()}
    truth = with_own_names(replace(true_object(100), components=components), model)
    assert score_frame([truth], [detection(100)], "torso").components_missed == 1


def test_counts_add_before_they_divide():
    one, two = Counts(frames=1, objects=1, recognised=1), Counts(frames=3, objects=9, recognised=0, false=6)
    rates = (one + two).rates()
    assert rates["recognition_rate"] == 0.1 and rates["false_per_frame"] == 1.5 and rates["precision"] == 1 / 7
    assert Counts().rates()["recognition_rate"] is None and Counts().rates()["position_error_median"] is None


def test_joint_errors_go_round_the_circle_and_sliding_ones_in_metres():
    truth = replace(true_object(100), joints={"leg": 3.1, "slide": 0.2, "unseen": 1.0})
    found = replace(detection(100, (100, 80)), joints={"leg": -3.1, "slide": 0.25})
    outcome = judge_frame([truth], [found], "torso").outcomes
    counts = Counts.of(outcome, sliding=["slide"])
    assert counts.joint_errors_rad == (pytest.approx(2 * np.pi - 6.2),)
    assert counts.joint_errors_m == (pytest.approx(0.05),)


def test_a_truth_of_poses_judges_no_components():
    torso = {"torso_left": TrueComponent(400, 400, np.array([100.0, 50.0]))}
    truth = replace(true_object(100), components=torso, told=Told.REQUIRED)
    counts = score_frame([truth], [detection(100, (300, 80))], "torso")
    assert (counts.recognised, counts.judged, counts.right, counts.components_wrong) == (1, 0, 0, 0)
    assert counts.rates()["right_rate"] is None


def test_a_truth_of_labels_judges_what_is_labelled():
    truth = replace(true_object(100), told=Told.LABELLED)
    wrong = score_frame([truth], [detection(100, (300, 80))], "torso")
    assert (wrong.judged, wrong.right, wrong.components_wrong) == (1, 0, 1)
    unlabelled = replace(truth, components={"torso_left": truth.components["torso_left"]})
    assert score_frame([unlabelled], [detection(100, (300, 80))], "torso").right == 1


@pytest.mark.parametrize(
    ("called", "told", "counted"),
    [("red_a", "a", (1, 1, 0)), ("red_a", "b", (1, 0, 1)), ("red_a", None, (1, 0, 0)), ("red", "b", (0, 0, 0))],
)
def test_names_are_scored_where_the_truth_says_which_one_it_is(called, told, counted):
    found = replace(detection(100, (100, 80)), identity=IdentityFit(told, 0.9, None, True))
    counts = score_frame([replace(true_object(100), name=called)], [found], "torso")
    assert (counts.named, counts.names_right, counts.names_wrong) == counted
    name, _, identity = called.partition("_")
    beside = replace(true_object(100), name=name, identity=identity or None)
    counts = score_frame([beside], [found], "torso")
    assert (counts.named, counts.names_right, counts.names_wrong) == counted
    counts = score_frame([replace(true_object(100), name=called)], [detection(100, (100, 80))], "torso")
    assert counts.named == 0  # an object without identities
