"""tf2_ros is not needed; where it is there, frames are sent to it. A stand-in takes its place here."""

from __future__ import annotations

import dataclasses
import sys
import types
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from geometry_msgs.msg import TransformStamped
from std_msgs.msg import Header

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import Detection, ImagePose
from artrec_ros.node.tf import transform_sender


class Broadcaster:
    def __init__(self, node: Any) -> None:
        self.sent: list[TransformStamped] = []
        node.broadcaster = self

    def sendTransform(self, transforms: list[TransformStamped]) -> None:  # noqa: N802 (tf2_ros' name)
        self.sent += transforms


class FakeNode:
    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self.warnings: list[str] = []

    def get_namespace(self) -> str:
        return self._namespace

    def get_logger(self) -> Any:
        return types.SimpleNamespace(warning=self.warnings.append)


@pytest.fixture
def tf2_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    module = types.ModuleType("tf2_ros")
    module.TransformBroadcaster = Broadcaster  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "tf2_ros", module)


def detection(number: int, *, posed: bool = True) -> Detection:
    pose = Pose.from_xyz_rpy((0.5, -0.25, 2), (0, 0, 0)) if posed else None
    return Detection("red", number, 0.9, ImagePose(1, 2, 3, 4), (), pose)


@pytest.mark.parametrize(("namespace", "child"), [("/", "red_1"), ("/left/eye", "left/eye/red_1")])
def test_each_posed_object_is_a_frame_under_the_images(tf2_ros: None, namespace: str, child: str) -> None:
    node = FakeNode(namespace)
    sender = transform_sender(node)
    header = Header(frame_id="eye")
    header.stamp.sec = 7
    sender.send([detection(0, posed=False), detection(1)], header)
    (sent,) = node.broadcaster.sent
    assert (sent.header.frame_id, sent.header.stamp.sec, sent.child_frame_id) == ("eye", 7, child)
    assert (sent.transform.translation.x, sent.transform.translation.z, sent.transform.rotation.w) == (0.5, 2.0, 1.0)


def test_nothing_is_sent_without_a_parent(tf2_ros: None) -> None:
    node = FakeNode("/")
    transform_sender(node).send([detection(1)], Header())
    assert node.broadcaster.sent == []


def test_a_pose_in_another_frame_is_sent_as_that_frames_child(tf2_ros: None) -> None:
    node = FakeNode("/")
    transform_sender(node).send(
        [dataclasses.replace(detection(1), frame_id="field"), detection(2)], Header(frame_id="eye")
    )
    assert [(t.header.frame_id, t.child_frame_id) for t in node.broadcaster.sent] == [
        ("field", "red_1"), ("eye", "red_2"),
    ]  # fmt: skip


def test_without_tf2_ros_a_warning_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tf2_ros", None)
    node = FakeNode("/")
    assert transform_sender(node) is None
    assert len(node.warnings) == 1 and "tf2_ros" in node.warnings[0]
