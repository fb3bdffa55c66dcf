"""Results survive the way through detections.jsonl and keep the promised names."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.base.errors import SourceError
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import (
    ClassFit,
    Detection,
    Filtered,
    IdentityFit,
    ImagePose,
    Instance,
    Missing,
    Motion,
    OtherObject,
    OtherPlace,
    OtherTurn,
)
from artrec_ros.core.model.frame_result import ConstraintFailure, FrameResult, Rejection
from artrec_ros.io.results.results import FrameRecord, read_results

DETECTION = Detection(
    object="arm",
    id=1,
    score=0.93,
    image=ImagePose(103.25, 61.0, 0.05, 212.4),
    components=(Instance("base", "front", 0.96, 103.25, 61.0, 0.05, 212.4, contour=np.zeros((4, 2))),),
    pose=Pose.from_xyz_rpy([0.1, 0.0, 0.9], [0.3, -0.2, 2.0]),
    joints={"elbow": np.float64(0.31)},
)
RESULT = FrameResult(
    (208, 160),
    (DETECTION,),
    (Rejection("arm", "too small", 0.2, 5, 6),),
    {"total": 1.6},
    ended_by=("expert.grouping.search_nodes",),
)


def test_a_record_comes_back():
    record = FrameRecord.of(1700000000000000001, "/cam", RESULT, "optical")
    back = FrameRecord.from_json(record.to_json())
    assert (back.stamp_ns, back.frame, back.size, back.frame_id) == (1700000000000000001, "/cam", (208, 160), "optical")
    assert back.timing_ms == {"total": 1.6} and back.ended_by == RESULT.ended_by and back.error is None
    assert back.rejected == RESULT.rejected
    (d,) = back.detections
    assert (d.object, d.id, d.score, d.image, d.joints) == ("arm", 1, 0.93, DETECTION.image, {"elbow": 0.31})
    assert d.components == DETECTION.components
    assert np.allclose(d.pose.rotation, DETECTION.pose.rotation, atol=1e-8)
    assert np.allclose(d.pose.position, DETECTION.pose.position)


def test_the_promised_names_are_there():
    line = json.loads(FrameRecord.of(7, "/cam", RESULT, "optical").to_json())
    assert {"stamp_ns", "frame", "size", "objects", "rejected", "timing_ms"} <= set(line)
    assert (line["complete"], line["ended_by"]) == (False, list(RESULT.ended_by))
    (o,) = line["objects"]
    assert set(o) == {"object", "id", "score", "image", "pose", "joints", "components"}
    assert set(o["pose"]) == {"frame_id", "position", "orientation"}
    assert set(o["components"][0]) == {"name", "marker", "score", "x", "y", "theta", "scale"}
    assert {"object", "reason"} <= set(line["rejected"][0])


def test_why_components_are_not_told_comes_back():
    missing = (
        Missing("hand", "hidden", 3.0, 4.5, by="itself"),
        Missing("rod", "in doubt", 7.0, 8.0, score=0.25),
        Missing("base", "in doubt", 1.0, 2.0),
    )
    line = FrameRecord.of(7, "/cam", replace(RESULT, detections=(replace(DETECTION, missing=missing),))).to_json()
    assert json.loads(line)["objects"][0]["missing"] == [
        {"name": "hand", "state": "hidden", "x": 3.0, "y": 4.5, "by": "itself"},
        {"name": "rod", "state": "in doubt", "x": 7.0, "y": 8.0, "score": 0.25},
        {"name": "base", "state": "in doubt", "x": 1.0, "y": 2.0},
    ]
    assert FrameRecord.from_json(line).detections[0].missing == missing


def test_the_class_that_a_component_shows_comes_back():
    (part,) = DETECTION.components
    line = FrameRecord.of(
        7, "/cam", replace(RESULT, detections=(replace(DETECTION, components=(replace(part, shows="g"),)),))
    ).to_json()
    assert json.loads(line)["objects"][0]["components"][0]["shows"] == "g"
    assert FrameRecord.from_json(line).detections[0].components[0].shows == "g"


def test_another_turn_comes_back():
    other = OtherTurn(Pose.from_xyz_rpy([0.1, 0.0, 1.0], [0.0, 0.4, 0.0]), 0.35, {"arm": 0.25})
    line = FrameRecord.of(7, "/cam", replace(RESULT, detections=(replace(DETECTION, other_turn=other),))).to_json()
    told = json.loads(line)["objects"][0]["other_turn"]
    assert set(told) == {"probability", "position", "orientation", "joints"}
    back = FrameRecord.from_json(line).detections[0].other_turn
    assert (back.probability, back.joints) == (0.35, {"arm": 0.25}) and np.allclose(
        back.pose.rotation, other.pose.rotation, atol=1e-8
    )


def test_how_probable_a_pose_is_comes_back():
    doubted = replace(DETECTION, score=0.4, as_told=0.5)
    line = FrameRecord.of(7, "/cam", replace(RESULT, detections=(doubted,))).to_json()
    assert json.loads(line)["objects"][0]["as_told"] == 0.5
    back = FrameRecord.from_json(line).detections[0]
    assert back.as_told == 0.5 and back.there == pytest.approx(0.8)
    assert "as_told" not in FrameRecord.of(7, "/cam", RESULT).to_json()


def test_another_place_comes_back():
    other = OtherPlace(ImagePose(12.5, 80.25, -2.5, 310.0), 0.35)
    line = FrameRecord.of(7, "/cam", replace(RESULT, detections=(replace(DETECTION, other_place=other),))).to_json()
    told = json.loads(line)["objects"][0]["other_place"]
    assert told == {"probability": 0.35, "x": 12.5, "y": 80.25, "theta": -2.5, "scale": 310.0}
    assert FrameRecord.from_json(line).detections[0].other_place == other


def test_another_target_and_the_size_on_the_plane_come_back():
    told = replace(DETECTION, other_object=OtherObject("other", 0.35), plane_scale=1.2)
    line = FrameRecord.of(7, "/cam", replace(RESULT, detections=(told,))).to_json()
    back = FrameRecord.from_json(line).detections[0]
    assert back.other_object == told.other_object and back.plane_scale == 1.2
    for right, wrong in (('"probability": 0.35', '"probability": 7'), ('"plane_scale": 1.2', '"plane_scale": -1')):
        with pytest.raises(ValueError, match="must be"):
            FrameRecord.from_json(line.replace(right, wrong))


def test_an_unusable_frame_has_its_error_and_no_objects():
    line = FrameRecord(7, "a.png", error="damaged").to_json()
    assert json.loads(line)["error"] == "damaged" and json.loads(line)["objects"] == []
    assert FrameRecord.from_json(line).error == "damaged"


def test_without_calibration_the_pose_is_null():
    detection = Detection("arm", 0, 0.5, DETECTION.image, DETECTION.components)
    line = FrameRecord.of(7, "a.png", FrameResult((8, 6), (detection,))).to_json()
    assert json.loads(line)["objects"][0]["pose"] is None
    assert FrameRecord.from_json(line).detections[0].pose is None


def test_how_a_pose_is_known_and_its_own_frame_come_back():
    by_size = replace(DETECTION, pose_from="size")
    on_field = replace(DETECTION, id=2, frame_id="field")
    line = FrameRecord.of(7, "a.png", FrameResult((8, 6), (DETECTION, by_size, on_field)), "optical").to_json()
    told = json.loads(line)["objects"]
    assert [o.get("pose_from") for o in told] == [None, "size", None]  # a fit needs no word
    assert [o["pose"]["frame_id"] for o in told] == ["optical", "optical", "field"]
    back = FrameRecord.from_json(line)
    assert [(d.pose_from, d.frame_id) for d in back.detections] == [("fit", ""), ("size", ""), ("fit", "field")]
    assert back.to_json() == line


def test_a_broken_line_is_named(tmp_path):
    path = tmp_path / "d.jsonl"
    path.write_text(FrameRecord(7, "a", error="x").to_json() + "\n" + '{"stamp_ns": 8, "fra')
    records = read_results(path)
    assert next(records).stamp_ns == 7
    with pytest.raises(SourceError, match="line 2"):
        next(records)
    with pytest.raises(SourceError, match="no such file"):
        next(read_results(tmp_path / "nothing"))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('{"stamp_ns": 8, "fra', "no valid JSON at column 17: Unterminated string"),
        ('{"frame": "a", "objects": []}', "stamp_ns: this key is missing"),
        ("[" * 100_000, "it is nested too deeply"),
        ("[]", "must be a mapping {key: value}, not []"),
        ('{"stamp_ns": 1%s, "frame": "a", "objects": []}' % ("0" * 5000), "a number in it is too long"),
    ],
)
def test_what_is_wrong_with_a_line_is_told_in_words(tmp_path, line, said):
    path = tmp_path / "d.jsonl"
    path.write_text(line + "\n")
    with pytest.raises(SourceError) as caught:
        list(read_results(path))
    assert f"d.jsonl: line 1: {said}" in str(caught.value)


@pytest.mark.parametrize("fit", [ClassFit("wave", 0.93, "rest", 0.05), ClassFit(None, 0.8, "rest", 0.1, "too far")])
def test_a_class_a_margin_and_a_failed_constraint_come_back(fit):
    detection = replace(DETECTION, class_fit=fit, margin=0.25)
    failed = ConstraintFailure("base/front", "arm/side", "turn_rad", 1.5, -0.5, 0.5, 0.9)
    result = FrameResult((8, 6), (detection,), (Rejection("arm", "no", 0.1, 1, 2, failed),))
    line = FrameRecord.of(7, "a.png", result).to_json()
    told = json.loads(line)["objects"][0]
    assert told["class"]["name"] == fit.name and told["class"]["runner_up"] == "rest"
    assert ("reason" in told["class"]) == (fit.name is None)
    assert told["margin"] == 0.25
    back = FrameRecord.from_json(line)
    assert (back.detections[0].class_fit, back.detections[0].margin) == (fit, 0.25)
    assert back.rejected[0].failed == failed


@pytest.mark.parametrize(
    "fit",
    [IdentityFit("gr", 0.97, "gv", True), IdentityFit(None, 0.6, "gr", False), IdentityFit("gr", 1.0, None, True)],
)
def test_an_identity_comes_back(fit):
    """What it was told by stays with the recogniser."""
    given = replace(fit, evidence={"gr": -1.5, "gv": -3.25}, least=0.8)
    line = FrameRecord.of(7, "a.png", FrameResult((8, 6), (replace(DETECTION, identity=given),))).to_json()
    told = json.loads(line)["objects"][0]
    names = ("identity", "identity_probability", "identity_runner_up", "identity_unique")
    assert tuple(told[name] for name in names) == (fit.name, fit.probability, fit.runner_up, fit.unique)
    (back,) = FrameRecord.from_json(line).detections
    assert back.identity == fit and not back.identity.evidence
    assert back.name == replace(DETECTION, identity=fit).name
    assert not {*names} & set(json.loads(FrameRecord.of(7, "a.png", RESULT).to_json())["objects"][0])


def test_results_that_are_no_text_are_told(tmp_path):
    (tmp_path / "detections.jsonl").write_bytes(b'{"stamp_ns": 1\xff}\n')
    with pytest.raises(SourceError, match="no text file"):
        list(read_results(tmp_path / "detections.jsonl"))


@pytest.mark.parametrize(
    ("keys", "value", "said"),
    [
        (["stamp_ns"], 1.5, "stamp_ns: must be a whole number, not 1.5"),
        (["objects"], {}, "objects: must be a list, not {}"),
        (["timing_ms", "total"], "x", "timing_ms.total: must be a finite number, not 'x'"),
        (["rejected", 0], "x", "rejected[0]: must be a mapping {key: value}, not 'x'"),
        (["rejected", 0, "x"], float("nan"), "rejected[0].x: must be a finite number, not nan"),
        (["objects", 0, "object"], True, "objects[0].object: must be text, not True"),
        (["objects", 0, "score"], None, "objects[0].score: must be a finite number, not nothing"),
        (["objects", 0, "score"], 5, "objects[0].score: must be at least 0 and at most 1, not 5"),
        (["objects", 0, "components", 0, "x"], "x", "objects[0].components[0].x: must be a finite number, not 'x'"),
        (["objects", 0, "image", "theta"], [], "objects[0].image.theta: must be a finite number, not []"),
        (["objects", 0, "pose", "position"], [0, 0], "objects[0].pose.position: must be a list of 3, not [0, 0]"),
        (["objects", 0, "pose_from"], "magic", "objects[0].pose_from: must be one of 'fit', 'size', 'plane'"),
    ],
)
def test_wrong_values_of_results_are_told_by_their_keys(tmp_path, keys, value, said):
    line = json.loads(FrameRecord.of(7, "/cam", RESULT, "optical").to_json())
    place = line
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    path = tmp_path / "detections.jsonl"
    path.write_text(json.dumps(line) + "\n")
    with pytest.raises(SourceError) as caught:
        list(read_results(path))
    assert str(caught.value).startswith(f"{path}: line 1: {said}")


def test_a_byte_order_mark_before_results_is_passed_over(tmp_path):
    line = FrameRecord.of(7, "/cam", RESULT, "optical").to_json()
    (tmp_path / "d.jsonl").write_text(line + "\n", encoding="utf-8-sig")
    assert [r.to_json() for r in read_results(tmp_path / "d.jsonl")] == [line]


def test_an_orientation_without_length_is_refused(tmp_path):
    found = {"object": "red", "id": 0, "score": 1, "image": {"x": 0, "y": 0, "theta": 0, "scale": 1}, "joints": {}}
    pose = {"frame_id": "cam", "position": [0, 0, 1], "orientation": [0, 0, 0, 0]}
    line = {"stamp_ns": 1, "frame": "f", "objects": [{**found, "components": [], "pose": pose}]}
    (tmp_path / "detections.jsonl").write_text(json.dumps(line) + "\n")
    with pytest.raises(SourceError, match="has no length"):
        list(read_results(tmp_path / "detections.jsonl"))


def test_poses_on_a_plane_keep_their_frame() -> None:
    """Alone in a record, and beside one of the camera's: what is on a field is never taken for the camera's."""
    on_plane = replace(DETECTION, frame_id="field", pose_from="plane")
    for detections in ((on_plane,), (on_plane, DETECTION), (DETECTION, on_plane)):
        record = FrameRecord.of(7, "/cam", replace(RESULT, detections=detections), "optical")
        back = FrameRecord.from_json(record.to_json())
        assert [(d.frame_id, d.pose_from) for d in back.detections] == [(d.frame_id, d.pose_from) for d in detections]
        assert back.to_json() == record.to_json()


def test_what_is_carried_on_comes_back() -> None:
    pose, covariance = Pose.from_xyz_rpy([0.11, 0.0, 0.9], [0.3, -0.2, 2.0]), np.diag([1e-4] * 3 + [1e-2] * 3)
    filtered = Filtered(pose, covariance, {"elbow": 0.3}, {"elbow": 0.02})
    motion = Motion(np.arange(6) / 10, {"elbow": -1.5})
    seen = replace(DETECTION, filtered=filtered, motion=motion)
    expected = replace(DETECTION, predicted=True, components=())
    line = FrameRecord.of(7, "camera", FrameResult((208, 160), (seen, expected)), "optical").to_json()
    first, second = json.loads(line)["objects"]
    assert first["filtered"]["twist"] == [0.0, 0.1, 0.2, 0.3, 0.4, 0.5] and "predicted" not in first
    assert second["predicted"] is True and "filtered" not in second
    back, gone = FrameRecord.from_json(line).detections
    np.testing.assert_allclose(back.filtered.pose.position, pose.position)
    np.testing.assert_allclose(back.filtered.pose.rotation, pose.rotation, atol=1e-8)
    np.testing.assert_allclose(back.filtered.covariance, covariance)
    assert (back.filtered.joints, back.filtered.joint_deviations) == ({"elbow": 0.3}, {"elbow": 0.02})
    np.testing.assert_allclose(back.motion.twist, motion.twist)
    assert back.motion.joints == motion.joints and gone.predicted and gone.motion is None and gone.filtered is None
