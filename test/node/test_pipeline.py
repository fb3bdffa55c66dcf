"""One image after the other, whoever brings it."""

from __future__ import annotations

import time
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import numpy as np
import toy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseArray
from lone_node import gate, getting_ready, start, statuses
from peer import WAIT_S, Peer, label_image, wait_until
from rclpy.lifecycle import TransitionCallbackReturn
from sensor_msgs.msg import CameraInfo
from visualization_msgs.msg import MarkerArray

from artrec_ros.core.recognizer import Recognizer
from artrec_ros.node import pipeline, publishers, worker
from artrec_ros.node.conversions import to_ros
from artrec_ros.node.inputs import Inputs
from artrec_ros.node.node import RecognizerNode


def test_a_frame_that_outlives_deactivation_is_not_published_and_shares_nothing(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker, "_PATIENCE_S", 0.01)
    recognition = gate(monkeypatch, Recognizer, "follow")
    first = start(node, picture)
    assert recognition.begun.wait(WAIT_S)
    waiting = start(node, picture)  # as the worker of an activation that is over as well
    assert node.trigger_deactivate() == node.trigger_activate() == TransitionCallbackReturn.SUCCESS
    last = start(node, picture)
    time.sleep(0.2)  # for the last to come in, if it could
    recognition.go_on.set()
    for thread in (first, waiting, last):
        thread.join(WAIT_S)
        assert not thread.is_alive()
    assert recognition.most_inside == 1, "two threads in one pipeline"
    assert node.counters.processed == 1 and node.counters.failed == 0, "only what came after the activation"


def test_an_image_that_waits_for_the_recognizer_is_let_go_where_nobody_asks_any_more(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    building = getting_ready(node, monkeypatch)
    thread = start(node, picture)
    assert wait_until(lambda: list(node._pipeline._news._waiters))
    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    thread.join(WAIT_S)
    assert not thread.is_alive()
    building.go_on.set()
    assert wait_until(lambda: node.is_ready) and node.counters.processed == node._pipeline.dropped == 0


def test_no_further_image_is_taken_before_what_is_under_way_is_withdrawn(
    node: RecognizerNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else it would wait for the recogniser after that, and be published by a node that is not active."""
    order: list[str] = []
    for of, name in ((Inputs, "end"), (pipeline.Pipeline, "withdraw")):
        old = getattr(of, name)
        monkeypatch.setattr(of, name, lambda self, old=old, name=name: (order.append(name), old(self))[1])
    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    assert order == ["end", "withdraw"]


def test_pictures_are_made_for_those_who_look(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    for name in ("draw_result", "class_picture"):
        monkeypatch.setattr(pipeline, name, lambda *_, name=name: made.append(name))
    node.take_image(label_image(picture), time.time_ns())
    assert node.counters.processed == 1 and made == []


def test_a_calibration_of_another_camera_is_used_and_told(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    info = CameraInfo(width=toy.SIZE[0], height=toy.SIZE[1], k=toy.CAMERA.matrix.ravel())
    image = label_image(picture)
    info.header.frame_id, image.header.frame_id = "right", "left"
    node.take_camera_info(info)
    node.take_image(image, time.time_ns())
    found = statuses(node, monkeypatch)["calibration"]
    assert node.counters.objects == 1 and found.level == DiagnosticStatus.WARN
    assert "'right'" in found.message and "'left'" in found.message


def test_messages_are_made_for_those_who_listen(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    monkeypatch.setattr(publishers, "to_ros", lambda message: made.append(message.type) or to_ros(message))
    monkeypatch.setattr(publishers.MarkerScene, "update", lambda *_: made.append("markers") or MarkerArray())
    node.take_image(label_image(picture), time.time_ns())
    assert node.counters.objects == 1 and made == []
    heard: list[PoseArray] = []
    with Peer(namespace="/alone") as peer:
        peer.node.create_subscription(PoseArray, "toy/image_poses", heard.append, 10)

        def is_made() -> bool:
            node.take_image(label_image(picture), time.time_ns())
            return bool(made)

        assert wait_until(is_made) and peer.spin_until(lambda: heard)
    assert set(made) == {"geometry_msgs/msg/PoseArray"} and len(heard[0].poses) == 1


@pytest.mark.parametrize("is_late", [False, True])
def test_the_recognizer_is_told_whether_a_newer_image_waits(
    node: RecognizerNode, picture: np.ndarray, is_late: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[bool] = []
    original = Recognizer.follow

    def follow(self: Recognizer, *arguments: Any) -> Any:
        told.append(arguments[-1].is_late)
        return original(self, *arguments)

    monkeypatch.setattr(Inputs, "is_late", property(lambda self: is_late))
    monkeypatch.setattr(Recognizer, "follow", follow)
    node.take_image(label_image(picture), time.time_ns())
    assert told == [is_late]


def test_an_image_that_was_looked_at_while_it_waited_is_not_looked_at_again(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    image, looks = label_image(picture), list[np.ndarray]()
    ahead = node._pipeline.look(image)
    assert ahead is not None and len(ahead.look.blobs)
    original = Recognizer.look

    def look(self: Recognizer, pixels: np.ndarray) -> Any:
        looks.append(pixels)
        return original(self, pixels)

    monkeypatch.setattr(Recognizer, "look", look)
    node.take_image(image, time.time_ns(), ahead)
    assert node.counters.objects == 1 and not looks
    node.take_image(image, time.time_ns(), ahead._replace(recognizer=None))  # the parameters were changed meanwhile
    assert node.counters.objects == 2 and len(looks) == 1
