"""Messages of a bag are those of the node, field by field."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import Detection, Filtered, IdentityFit, ImagePose, Instance, Motion
from artrec_ros.core.model.target import Target
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.messages import detection_messages as messages
from artrec_ros.io.messages import node_topics as topics
from artrec_ros.io.messages.detection_messages import Message
from artrec_ros.io.messages.marker_messages import MarkerScene
from artrec_ros.io.messages.object_messages import OBJECT_MAKERS
from artrec_ros.io.objects.object_reader import load_object

STAMP = 1_700_000_000_123_456_789
TOY = """
format: artrec_object/1
name: toy
markers:
  hull: {outline: [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05]], axis: [[-0.1, 0], [0.1, 0]]}
components:
  body: {required: true, markers: {hull: {pose: {xyz: [0, 0, 0], rpy: [0, 0, 0]}}}}
"""


def detection(number: int, score: float, sigma: float | None = None) -> Detection:
    parts = (Instance("body", "hull", 1.0, 0, 0, 0, 1),)
    pose = Pose.from_xyz_rpy((0.25, -0.5, 2), (0.1, 0.2, 0.3))
    covariance = None if sigma is None else np.eye(6, dtype=np.float32) * sigma
    return Detection("toy", number, score, ImagePose(1, 2, 3, 4), parts, pose, {"arm": np.float32(0.25)}, covariance)


@pytest.fixture
def scene(tmp_path) -> MarkerScene:
    (tmp_path / "toy.yaml").write_text(TOY)
    return MarkerScene([Target("toy", load_object(tmp_path / "toy.yaml", {}), 3)])


def everything(scene: MarkerScene) -> list[Message]:
    """All that is said of two frames: the second one's markers delete the first one's."""
    found = [detection(0, 0.5, 0.5), detection(1, 0.75)]
    header_of = partial(messages.header, STAMP)
    said = [m for make in OBJECT_MAKERS.values() for m in make(found, "eye", header_of)]
    assert len(said) == len(OBJECT_MAKERS) == len(topics.OBJECT_OUTPUTS)
    return [*said, *(scene.update(d, "eye", header_of) for d in (found, found[:1]))]


def read(path) -> dict[str, object]:
    with AnyReader([path]) as reader:
        return {c.topic: reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages()}


def test_fields_come_back_and_the_others_are_ros_defaults(tmp_path, scene):
    with BagWriter(tmp_path / "bag") as bag:
        for i, message in enumerate(everything(scene)):
            bag.write(f"/t{i}", STAMP, message)
    _, robots, joints, best, _, image, named, parts, markers, later = read(tmp_path / "bag").values()
    assert robots.joint_names == ["toy_0", "toy_1"] and robots.transforms[1].translation.y == -0.5
    assert joints.name == ["toy_0/arm", "toy_1/arm"] and list(joints.position) == [0.25, 0.25]
    assert joints.velocity.size == 0
    assert best.pose.covariance[7] == 0.5 and best.header.stamp.nanosec == STAMP % 10**9
    assert image.header.frame_id == "eye_image" and [p.position.y for p in image.poses] == [2, 2]
    assert named.joint_names == ["toy_0", "toy_1"] and parts.joint_names == ["toy_0/body/hull", "toy_1/body/hull"]
    assert {m.ns for m in markers.markers} == {"toy/frame", "toy/name", "toy/outline"}
    gone = [m for m in later.markers if m.action == 2]
    assert len(gone) == 3 and all(m.id == 1 and m.pose.orientation.w == 1.0 for m in gone)


def test_a_pose_without_covariance_is_no_best_pose():
    assert messages.best_pose([detection(0, 0.9)], "eye", partial(messages.header, STAMP)) is None


def test_who_is_known_is_called_by_name(scene):
    """In all that bears names; who is not known is said to be unknown, with a number."""
    known = replace(detection(1, 0.75), identity=IdentityFit("gr", 0.9, "gv", True))
    doubt = replace(detection(0, 0.5), identity=IdentityFit(None, 0.6, "gv", True))
    header = messages.header(STAMP, "eye")
    assert messages.robots([known, doubt], header).fields["joint_names"] == ["toy_gr", "toy_unknown_0"]
    assert messages.joint_states([known, doubt], header).fields["name"] == ["toy_gr/arm", "toy_unknown_0/arm"]
    shown = scene.update([known, doubt], "eye", lambda frame: messages.header(STAMP, frame))
    assert {"toy_gr", "toy_unknown_0"} <= {text.split()[0] for text in _texts(shown) if text}


def _texts(message: Message) -> list[str]:
    return [m.fields["text"] for m in message.fields["markers"] if "text" in m.fields]


def test_the_node_sends_the_same(tmp_path, scene):
    serialization = pytest.importorskip("rclpy.serialization", reason="no ROS 2 (rclpy) here")
    from artrec_ros.node.conversions import to_ros

    with BagWriter(tmp_path / "bag") as bag:
        for i, message in enumerate(said := everything(scene)):
            bag.write(f"/t{i}", STAMP, message)
    with AnyReader([tmp_path / "bag"]) as reader:
        recorded = {c.topic: bytes(raw) for c, _, raw in reader.messages()}
    for message, data in zip(said, recorded.values(), strict=True):
        sent = to_ros(message)
        wire = serialization.serialize_message(sent)  # colours as float32
        as_sent = serialization.deserialize_message(wire, type(sent))
        assert serialization.deserialize_message(data, type(sent)) == as_sent


def test_poses_on_a_plane_go_out_in_its_frame(scene: MarkerScene) -> None:
    """Beside those in the camera's frame: a message of each topic for either; markers and tf name the frame, too."""
    on_plane = replace(detection(0, 0.9, 1e-4), frame_id="field", pose_from="plane")
    both, header_of = [on_plane, detection(1, 0.5, 1e-4)], partial(messages.header, STAMP)
    for topic in (topics.POSES, topics.ROBOTS):
        made = list(OBJECT_MAKERS[topic](both, "cam", header_of))
        assert [m.fields["header"].fields["frame_id"] for m in made] == ["field", "cam"]
    (best,) = OBJECT_MAKERS[topics.POSE](both, "cam", header_of)
    assert best.fields["header"].fields["frame_id"] == "field"
    transforms = messages.object_frames(both, "cam", header_of)
    assert [t.fields["header"].fields["frame_id"] for t in transforms] == ["field", "cam"]
    (poses,) = OBJECT_MAKERS[topics.POSES]([on_plane], "", header_of)  # the image needs no frame of its own
    assert poses.fields["header"].fields["frame_id"] == "field" and len(poses.fields["poses"]) == 1


def test_on_a_plane_outlines_are_drawn_where_the_required_component_is_told(scene: MarkerScene) -> None:
    """Not of what is expected there, nor of what was found by its other components: these keep frame and name."""
    contour = np.array([[0.0, 0], [4, 0], [4, 2]])
    told = replace(detection(0, 0.9).components[0], contour=contour)
    found = replace(detection(0, 0.9), components=(told,), frame_id="field", pose_from="plane")
    expected = replace(found, id=1, components=(), predicted=True)
    markers = scene.update([found, expected], "cam", partial(messages.header, STAMP)).fields["markers"]
    drawn = [(m.fields["ns"], m.fields["id"]) for m in markers]
    assert [number for ns, number in drawn if ns == "toy/outline"] == [0]
    assert [number for ns, number in drawn if ns == "toy/name"] == [0, 1]


# what is carried on from frame to frame

MOTION = Motion(np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), {"arm": 1.5})
SMOOTH = Filtered(Pose.from_xyz_rpy((0.24, -0.5, 2.01)), np.eye(6) * 0.5, {"arm": 0.2}, {"arm": 0.01})


def made(*detections: Detection) -> dict[str, Message]:
    """By topic."""
    return {
        topic.of("toy"): message
        for topic, make in OBJECT_MAKERS.items()
        for message in make(detections, "cam", partial(messages.header, STAMP))
    }


def test_speeds_are_told_where_they_are_known() -> None:
    both = made(replace(detection(0, 0.9), motion=MOTION), detection(1, 0.8))
    known, unknown = both["toy/robots"].fields["twist"]
    assert known.fields["linear"].fields == {"x": 0.1, "y": 0.2, "z": 0.3}
    assert known.fields["angular"].fields == {"x": 0.4, "y": 0.5, "z": 0.6}
    assert np.isnan(list(unknown.fields["linear"].fields.values())).all()
    np.testing.assert_array_equal(both["toy/joint_states"].fields["velocity"], [1.5, np.nan])
    neither = made(detection(0, 0.9), detection(1, 0.8))
    assert "twist" not in neither["toy/robots"].fields and "velocity" not in neither["toy/joint_states"].fields


def test_poses_are_the_filters_where_they_are_asked_for() -> None:
    told = made(replace(detection(0, 0.9, 0.1), filtered=SMOOTH, motion=MOTION))
    (pose,), (transform,) = told["toy/poses"].fields["poses"], told["toy/robots"].fields["transforms"]
    best = told["toy/pose"].fields["pose"].fields
    for place in (pose.fields["position"], transform.fields["translation"], best["pose"].fields["position"]):
        assert list(place.fields.values()) == [0.24, -0.5, 2.01]
    np.testing.assert_array_equal(best["covariance"], SMOOTH.covariance.reshape(36))
    assert told["toy/joint_states"].fields["position"] == [0.2]


def test_what_is_expected_is_no_best_pose_and_shows_no_components(scene: MarkerScene) -> None:
    expected = replace(detection(0, 0.99, 0.1), components=(), predicted=True)
    told = made(expected, detection(1, 0.8, 0.2))
    assert told["toy/pose"].fields["pose"].fields["covariance"][0] == pytest.approx(0.2)
    assert len(told["toy/poses"].fields["poses"]) == 2
    assert told["toy/image_components"].fields["joint_names"] == ["toy_1/body/hull"]
    markers = scene.update([expected, detection(1, 0.8)], "cam", partial(messages.header, STAMP)).fields["markers"]
    opacity = {m.fields["ns"] + str(m.fields["id"]): m.fields["color"].fields["a"] for m in markers}
    assert opacity["toy/name0"] < 0.5 and opacity["toy/name1"] == 1.0
    assert "toy/outline0" not in opacity and "toy/outline1" in opacity


def test_speeds_go_through_a_bag(tmp_path) -> None:
    told = made(replace(detection(0, 0.9, 0.1), filtered=SMOOTH, motion=MOTION), detection(1, 0.8))
    with BagWriter(tmp_path / "bag", "mcap") as writer:
        for topic in ("toy/robots", "toy/joint_states"):
            writer.write(f"/{topic}", STAMP, told[topic])
    back = read(tmp_path / "bag")
    assert back["/toy/robots"].twist[0].angular.z == 0.6 and np.isnan(back["/toy/robots"].twist[1].linear.x)
    np.testing.assert_array_equal(back["/toy/joint_states"].velocity, [1.5, np.nan])
