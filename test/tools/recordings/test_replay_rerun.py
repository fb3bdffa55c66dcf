"""`artrec replay --rerun`: the recording is read back and held against what the replay found."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from rerun_recording import CAMERA, CONTOUR, COVARIANCE, FOUND, STAMPS, picture, placed

from artrec_ros.core.geometry.transforms import rotation_from_quaternion
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.io.messages.marker_messages import component_frames
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.results.journal import Recognised
from artrec_ros.io.results.results import read_results


def test_one_timeline_has_all_stamps(recording):
    assert recording.timelines == {"stamp"} and len(recording.blueprints) == 1
    usable = [STAMPS[i] for i in (0, 2, 3, 4)]
    assert recording.stamps("/camera/classes", "SegmentationImage:buffer") == usable
    assert recording.stamps("/plots/milliseconds/total", "Scalars:scalars") == usable


@pytest.mark.parametrize("number", [0, 4])
def test_images_and_classes_are_those_of_the_frames(recording, params, number):
    blob = bytes(np.array(recording.at("/camera/image", "EncodedImage:blob", number), np.uint8).reshape(-1))
    image = cv2.imdecode(np.frombuffer(blob, np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(image.astype(int) - picture(number)).mean() < 8, "JPEG"
    expected = np.zeros((24, 32), int)
    expected[4:8, 2 + number : 10 + number], expected[12:20, 16:30] = 3, 5
    classes = np.array(recording.at("/camera/classes", "SegmentationImage:buffer", number), np.uint8)
    assert (classes.reshape(24, 32) == expected).all()
    (told,) = recording.rows["/camera"]["AnnotationContext:context"][None]
    names = {entry["class_id"]: entry["class_description"]["info"]["label"] for entry in told}
    assert (names[3], names[5]) == ("red", "blue")


def test_pixels_are_counted_from_their_corners(recording):
    outline = recording.at("/camera/found/crane_0", "LineStrips2D:strips", 0)[0]
    assert np.allclose(outline, np.vstack([CONTOUR, CONTOUR[:1]]) + 0.5)
    K = recording.at("/camera", "Pinhole:image_from_camera", 0).reshape(3, 3, order="F")
    assert np.allclose(K, CAMERA.matrix + [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])


def test_markers_and_bodies_lie_where_pose_and_joints_put_them(recording, params):
    (target,) = load_parameters(params).targets
    frames = component_frames(Kinematics(target.model), FOUND.pose, FOUND.joints)
    seen = placed(recording, "/objects/crane_0", 0)
    for name in ("base", "boom"):
        path, component = f"/objects/crane_0/{name}", target.model.component(name)
        T = seen @ placed(recording, path, 0)
        marker = component.markers[0]
        outline = np.column_stack([marker.outline, np.zeros(4)])
        drawn = recording.at(f"{path}/markers", "LineStrips3D:strips", 0)[0]
        assert np.allclose(T.apply(drawn[:4]), frames[name].apply(marker.T_component_marker.apply(outline)), atol=1e-6)
    box = target.model.component("base").bodies[0]
    half, centre = (
        recording.at("/objects/crane_0/base/bodies", f"Boxes3D:{n}", 0)[0] for n in ("half_sizes", "centers")
    )
    assert np.allclose(2 * half, box.size) and np.allclose(centre, box.T_component_box.position)
    assert not any(path.startswith("/objects/crane_0/hook") for path in recording.rows), "its joint is not known"


def test_the_ellipsoid_holds_95_of_100_places(recording):
    half = recording.at("/uncertainty/crane_0", "Ellipsoids3D:half_sizes", 0)[0].astype(float)
    axes = rotation_from_quaternion(recording.at("/uncertainty/crane_0", "Ellipsoids3D:quaternions", 0)[0])
    assert np.allclose(axes @ np.diag(half**2) @ axes.T / 7.815, COVARIANCE[:3, :3], rtol=1e-4)
    centre = recording.at("/uncertainty/crane_0", "Ellipsoids3D:centers", 0)[0]
    draws = np.random.default_rng(1).multivariate_normal(FOUND.pose.position, COVARIANCE[:3, :3], 4000)
    inside = (((draws - centre) @ axes / half) ** 2).sum(axis=1) < 1
    assert abs(inside.mean() - 0.95) < 0.02


def test_joints_scores_and_what_was_turned_down(recording, tmp_path):
    assert recording.at("/plots/joints/crane_0/boom", "Scalars:scalars", 0) == pytest.approx([0.7])
    told = list(read_results(tmp_path / "seen" / "detections.jsonl"))
    for number in (0, 3):
        score = recording.at("/plots/scores/crane_0", "Scalars:scalars", number)
        assert score == pytest.approx([told[number].detections[0].score], abs=1e-4)
    assert np.allclose(recording.at("/camera/rejected", "Points2D:positions", 2), [[20.5, 10.5]])
    assert recording.at("/camera/rejected", "Points2D:labels", 2) == ["crane: its boom is not confirmed"]


@pytest.mark.parametrize("pose_from", ["fit", "plane"])
def test_an_object_that_is_expected_but_not_seen_is_shown_as_such(params, pose_from):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    from artrec_ros.tools.replaying.rerun_scene import Scene

    hidden = replace(
        FOUND, components=(), predicted=True, pose_from=pose_from, frame_id="field" * (pose_from == "plane")
    )
    entities = dict(
        ("/".join(path), content)
        for path, content in Scene(load_parameters(params).targets).entities(
            Recognised(0, "x", FrameResult((32, 24), (hidden,))), None
        )
    )
    root = "field/objects/crane_0" if pose_from == "plane" else "objects/crane_0"
    assert root in entities and "(crane_0)" in repr(entities[f"{root}/name"][0])
    assert (f"{root}/boom/markers" in entities) == (pose_from == "fit")


def test_what_is_gone_is_cleared(recording):
    for path in ("/objects/crane_0", "/objects/crane_0/base/bodies", "/uncertainty/crane_0", "/camera/found/crane_0"):
        assert STAMPS[1] in recording.rows[path]["Clear:is_recursive"], path
    assert STAMPS[4] in recording.rows["/camera/found/crane_0"]["Clear:is_recursive"]
    assert STAMPS[3] in recording.rows["/camera/rejected"]["Clear:is_recursive"]
    assert recording.stamps("/objects/crane_0", "Transform3D:translation") == [STAMPS[0]], "flat: no place in space"


def test_frames_that_failed_and_searches_cut_short_are_in_the_log(recording):
    (first,), (second,) = (recording.at("/log", "TextLog:text", i) for i in (1, 4))
    assert "too dark" in first and "recognizer.time_budget_ms" in second
    assert recording.stamps("/log", "TextLog:text") == [STAMPS[1], STAMPS[4]]
