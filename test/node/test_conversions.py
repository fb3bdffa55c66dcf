from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import array
import dataclasses
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from artrec_ros.core.base.errors import ConfigError, ImageError
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import ClassFit, Detection, ImagePose, Instance
from artrec_ros.io.bags.topics import camera_of, decode_message
from artrec_ros.io.messages import node_topics as topics
from artrec_ros.io.messages.node_topics import NodeTopic
from artrec_ros.io.messages.object_messages import OBJECT_MAKERS
from artrec_ros.node.conversions import header_of, image_to_msg, to_ros

HEADER = Header(frame_id="eye")


def detection(
    number: int, score: float, *, x: float = 0.5, posed: bool = True, sigma: float | None = None
) -> Detection:
    pose = Pose.from_xyz_rpy((x, -0.25, 2), (0.1, 0.2, 0.3)) if posed else None
    covariance = None if sigma is None else np.eye(6, dtype=np.float32) * sigma**2
    joints = {"arm": np.float32(0.25)} if posed else {}
    return Detection("red", number, score, ImagePose(1, 2, 3, 4), (), pose, joints, covariance)


def wire(msg: object) -> object:
    """As a subscriber gets it: wrong types would arrive as garbage."""
    return deserialize_message(serialize_message(msg), type(msg))


def said(topic: NodeTopic, found: list[Detection]) -> list[Any]:
    """The messages of a topic, as a subscriber gets them."""
    return [wire(to_ros(m)) for m in OBJECT_MAKERS[topic](found, HEADER.frame_id, header_of(HEADER))]


def test_pictures_pass_through_messages_unchanged() -> None:
    picture = np.random.default_rng(1).integers(0, 256, (7, 5, 3), np.uint8)
    np.testing.assert_array_equal(decode_message(wire(image_to_msg(picture, HEADER))), picture)
    np.testing.assert_array_equal(decode_message(image_to_msg(picture[:, ::-1], HEADER)), picture[:, ::-1])


def test_a_picture_of_other_form_is_refused() -> None:
    with pytest.raises(ImageError, match="float64"):
        image_to_msg(np.zeros((2, 2, 3)), HEADER)


def test_rows_with_padding_and_big_endian_are_read() -> None:
    msg = Image(height=2, width=2, step=6, encoding="mono16", is_bigendian=1)
    msg.data = array.array("B", [1, 0, 2, 0, 99, 99, 0, 3, 0, 4, 99, 99])
    np.testing.assert_array_equal(decode_message(msg), [[256, 512], [3, 4]])


def test_damaged_images_are_errors_of_one_line() -> None:
    for msg in (Image(), Image(height=9, width=9, step=9, encoding="mono8"), CompressedImage(format="png")):
        with pytest.raises(ImageError) as caught:
            decode_message(msg)
        assert "\n" not in str(caught.value)


def test_poses_robots_and_joints_agree() -> None:
    found = [detection(0, 0.9), detection(1, 0.8, posed=False), detection(2, 0.7, x=-1)]
    (poses,), (named,), (joints,) = (said(topic, found) for topic in (topics.POSES, topics.ROBOTS, topics.JOINTS))
    assert named.joint_names == ["red_0", "red_2"]
    for pose, transform, d in zip(poses.poses, named.transforms, (found[0], found[2]), strict=True):
        p, t, q = pose.position, transform.translation, transform.rotation
        np.testing.assert_allclose((p.x, p.y, p.z), d.pose.position)
        np.testing.assert_allclose((t.x, t.y, t.z), d.pose.position)
        np.testing.assert_allclose((q.x, q.y, q.z, q.w), d.pose.quaternion)
        assert pose.orientation == q
    assert joints.name == ["red_0/arm", "red_2/arm"]
    assert list(joints.position) == [0.25, 0.25]
    assert poses.header == named.header == joints.header == HEADER


def test_the_best_pose_is_of_those_with_a_covariance() -> None:
    assert said(topics.POSE, [detection(0, 0.9)]) == []
    found = [detection(0, 0.9), detection(1, 0.5, x=1, sigma=0.5), detection(2, 0.6, x=2, sigma=0.1)]
    (msg,) = said(topics.POSE, found)
    assert msg.pose.pose.position.x == 2
    np.testing.assert_allclose(np.reshape(msg.pose.covariance, (6, 6)), np.eye(6) * 0.01, rtol=1e-6)


def test_classes_are_told_of_objects_that_have_them() -> None:
    fits = [ClassFit("wave", 0.9, "rest", 0.1), ClassFit(None, 0.7, "rest", 0.2, "far off"), None]
    found = [dataclasses.replace(detection(n, 0.5, posed=False), class_fit=fit) for n, fit in enumerate(fits)]
    (msg,) = said(topics.CLASSES, found)
    assert msg.header.frame_id == "eye"
    assert [(s.name, s.message) for s in msg.status] == [("red_0", "wave"), ("red_1", "")]
    values = [{v.key: v.value for v in s.values} for s in msg.status]
    assert float(values[0]["confidence"]) == 0.9 and values[0]["runner_up"] == "rest"
    assert values[1]["reason"] == "far off" and "reason" not in values[0]
    assert said(topics.CLASSES, [])[0].status == []


def seen(number: int, theta: float, *, posed: bool) -> Detection:
    parts = (
        Instance("torso", "frontal", 0.9, 12.0, 34.0, theta, 5.0),
        Instance("leg", "side", 0.8, 1.0, 2.0, 0.5, 5.0),
    )
    pose = Pose.from_xyz_rpy((0, 0, 1)) if posed else None
    return Detection("red", number, 0.9, ImagePose(12.0, 34.0, theta, 5.0), parts, pose)


def test_what_the_image_shows_is_told_in_pixels_of_every_object() -> None:
    thetas = (-3.0, 0.0, 1.2, np.pi)
    found = [seen(n, theta, posed=n == 1) for n, theta in enumerate(thetas)]
    (poses,), (named,) = said(topics.IMAGE_POSES, found), said(topics.IMAGE_ROBOTS, found)
    assert named.joint_names == ["red_0", "red_1", "red_2", "red_3"]
    for pose, transform, theta in zip(poses.poses, named.transforms, thetas, strict=True):
        p, t, q = pose.position, transform.translation, transform.rotation
        assert (p.x, p.y, p.z) == (t.x, t.y, t.z) == (12.0, 34.0, 0.0)
        assert pose.orientation == q and (q.x, q.y) == (0, 0)
        assert np.cos(2 * np.arctan2(q.z, q.w) - theta) == pytest.approx(1)  # yaw
    assert poses.header == named.header and poses.header.frame_id == "eye_image"
    (parts,) = said(topics.IMAGE_COMPONENTS, found[:2])
    assert parts.joint_names == ["red_0/torso/frontal", "red_0/leg/side", "red_1/torso/frontal", "red_1/leg/side"]
    assert [(t.translation.x, t.translation.y) for t in parts.transforms] == [(12, 34), (1, 2)] * 2
    assert parts.header.frame_id == "eye_image"


def test_nothing_found_is_told_too() -> None:
    for topic in topics.OBJECT_OUTPUTS:
        messages = said(topic, [])
        assert len(messages) == (0 if topic == topics.POSE else 1), topic
        assert all(m.header.stamp == HEADER.stamp and m.header.frame_id.startswith("eye") for m in messages)


def test_poses_that_tell_their_own_frame_are_sent_in_it() -> None:
    """As those on a plane of the scene; a message has one frame."""
    field = [dataclasses.replace(detection(n, 0.5 + n / 10, sigma=0.1), frame_id="field") for n in (0, 1)]
    for topic in (topics.POSES, topics.ROBOTS, topics.POSE):
        assert [m.header.frame_id for m in said(topic, field)] == ["field"]
        both = said(topic, [*field, detection(2, 0.55, x=7, sigma=0.1)])
        assert [m.header.frame_id for m in both] == (["field"] if topic == topics.POSE else ["field", "eye"])
    named = said(topics.ROBOTS, [detection(2, 0.5), *field])
    assert [m.joint_names for m in named] == [["red_2"], ["red_0", "red_1"]]
    assert said(topics.IMAGE_POSES, field)[0].header.frame_id == "eye_image"


def info(**changes: object) -> CameraInfo:
    msg = CameraInfo(width=640, height=480, distortion_model="plumb_bob", d=[0.1, 0.0, 0.0, 0.0, 0.0])
    msg.k = [500.0, 0.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0]
    for name, value in changes.items():
        setattr(msg, name, value)
    return msg


def test_a_calibration_in_the_images_own_pixels() -> None:
    camera = camera_of(info())
    assert camera.size == (640, 480) and camera.matrix[1, 1] == 510 and camera.distortion[0] == 0.1
    msg = info(binning_x=2, binning_y=2)
    msg.roi.x_offset, msg.roi.y_offset, msg.roi.width, msg.roi.height = 100, 40, 200, 100
    camera = camera_of(msg)
    assert camera.size == (100, 50)
    assert camera.matrix[0, 0] == 250


@pytest.mark.parametrize(
    "changes", [{"k": np.zeros(9)}, {"k": np.full(9, np.nan)}, {"distortion_model": "fisheye9"}, {"d": [0.1]}]
)
def test_a_calibration_that_is_none(changes: dict) -> None:
    with pytest.raises(ConfigError):
        camera_of(info(**changes))
