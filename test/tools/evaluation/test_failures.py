"""Each failed frame tells what failed, and why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import IdentityFit, ImagePose, Instance
from artrec_ros.core.model.frame_result import Rejection
from artrec_ros.io.results.results import FrameRecord
from artrec_ros.tools.evaluate import evaluate
from artrec_ros.tools.evaluation.failures import failed_frames
from artrec_ros.tools.evaluation.outcomes import FrameOutcome, Outcome
from artrec_ros.tools.evaluation.scoring import ScoredFrame

from .makers import FACING, found_thing, pixel, record, true_thing, write_run, write_truth


def failures(tmp_path, objects, *records):
    """(kind, reason) of all failures, with truth of one frame at stamp 1 and a later one that is fine."""
    truth = write_truth(tmp_path / "t.jsonl", {1: objects, 2: []})
    ((result,), _) = evaluate([write_run(tmp_path / "r", [*records, record(2)])], truth)
    return [(f.kind, f.reason) for frame in failed_frames(result.evaluation) for f in frame.failures]


def test_a_perfect_frame_has_none(tmp_path):
    assert failures(tmp_path, [true_thing()], record(1, found_thing())) == []


@pytest.mark.parametrize(
    ("frame", "reason"),
    [
        ([], "the replay has no result for this frame"),
        ([FrameRecord(1, "/c", error="damaged image")], "the frame could not be used: damaged image"),
        ([record(1)], "no candidate near it"),
        ([record(1, rejected=(Rejection("thing", "too few", 0.2, 82, 60), Rejection("thing", "too far", 0.9, 10, 10)))],
         "turned down: too few"),
        ([record(1, rejected=(Rejection("other", "too few", 0.2, 82, 60),))], "no candidate near it"),
    ],
)  # fmt: skip
def test_a_missed_object(tmp_path, frame, reason):
    assert failures(tmp_path, [true_thing()], *frame) == [("missed", reason)]


@pytest.mark.parametrize("limit", ["recognizer.time_budget_ms", "expert.grouping.search_nodes"])
def test_a_search_that_a_limit_ended(tmp_path, limit):
    cut = FrameRecord(1, "/c", (160, 120), ended_by=(limit,))
    assert failures(tmp_path, [true_thing()], cut)[0][1] == f"no candidate near it; {limit} ended the search"


def test_an_object_that_is_out_of_view_is_no_failure(tmp_path):
    assert failures(tmp_path, [true_thing(components={})], record(1)) == []


def test_wrong_components(tmp_path):
    missing = record(1, found_thing(arm=False))
    assert failures(tmp_path, [true_thing()], missing) == [("not right", "arm was missed")]


@pytest.mark.parametrize(("dx", "reason"), [(0, "arm lies on base"), (60, "arm lies on none of its markers")])
def test_a_component_elsewhere(tmp_path, dx, reason):
    u = pixel(0)
    parts = (Instance("base", "plate", 1, u, 59.5, 0, 200), Instance("arm", "stripe", 1, u + dx, 59.5, 0, 200))
    found = failures(tmp_path, [true_thing()], record(1, found_thing(components=parts)))
    assert found == [("not right", reason)]


@pytest.mark.parametrize(("name", "reason"), [("b", "told as thing_b with 90%"), (None, "told by no name")])
def test_another_name(tmp_path, name, reason):
    found = found_thing(identity=IdentityFit(name, 0.9))
    truth = write_truth(tmp_path / "t.jsonl", {1: [true_thing()]})
    ((result,), _) = evaluate([write_run(tmp_path / "r", [record(1, found)])], truth)
    outcome = Outcome(true_thing(name="thing_a"), counted=True, detection=found, right=True)
    frame = ScoredFrame(1, 0, None, {"thing": FrameOutcome((outcome,))})
    ((failure,),) = (f.failures for f in failed_frames(replace(result.evaluation, frames=(frame,))))
    assert (failure.kind, failure.reason) == ("wrong name", f"it is thing_a, and {reason}")


def test_a_required_component_elsewhere(tmp_path):
    parts = (Instance("base", "plate", 1, 5, 5, 0, 200), Instance("arm", "stripe", 1, pixel(0) + 20, 59.5, 0, 200))
    found = failures(tmp_path, [true_thing()], record(1, found_thing(components=parts)))
    assert found == [("not right", "base lies elsewhere")]


def test_false_detections(tmp_path):
    again = found_thing(image=ImagePose(pixel(0) + 6, 59.5, 0, 200), score=0.7)
    found = failures(tmp_path, [true_thing()], record(1, found_thing(), again, found_thing(0.35, score=0.61)))
    assert found == [
        ("false", "score 0.70: 6 px from an object 'thing'; another detection lies there, too"),
        ("false", "score 0.61: no object there"),
    ]


def test_a_false_one_beside_an_object_tells_how_near_it_would_be_right(tmp_path):
    """A thing's largest marker has 640 px: half of its size is 12.6 px."""
    beside = found_thing(image=ImagePose(pixel(0) + 15, 59.5, 0, 200))
    said = "score 0.90: 15 px from an object 'thing', which it would be up to 12.6 px, half of its size"
    assert ("false", said) in failures(tmp_path, [true_thing()], record(1, beside))


def far_off(tmp_path, *poses):
    """What is said of the frames whose things are found in these poses, among five that are found where they are."""
    all_poses = dict(enumerate((*poses, *[Pose(FACING, [0, 0, 1])] * 5), start=1))
    frames = {t: [true_thing()] for t in all_poses}
    found = [record(t, found_thing(pose=pose)) for t, pose in all_poses.items()]
    ((result,), _) = evaluate([write_run(tmp_path / "r", found)], write_truth(tmp_path / "t.jsonl", frames))
    return [(f.kind, f.reason) for frame in failed_frames(result.evaluation) for f in frame.failures]


@pytest.mark.parametrize(("m", "turn_deg", "said"), [(0.06, 2, "6.0% of the range off, its turn 2"), (0.001, 20, "20")])
def test_what_is_right_but_far_off_is_shown(tmp_path, m, turn_deg, said):
    turned = Pose(Pose.from_xyz_rpy([0, 0, 0], [0, 0, np.radians(turn_deg)]).rotation @ FACING, [0, 0, 1 + m])
    ((kind, reason),) = far_off(tmp_path, turned)
    assert kind == "far off" and said in reason


def test_what_all_are_is_not_far(tmp_path):
    assert far_off(tmp_path, *[Pose(FACING, [0, 0, 1.03])] * 9) == []
