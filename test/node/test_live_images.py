"""The last images of a topic, by the node's own subscriptions and conversions."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")
import cv2
import toy
from peer import Peer, wait_until
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from artrec_ros.core.base.config import NodeConfig
from artrec_ros.core.base.errors import SourceError
from artrec_ros.node import conversions
from artrec_ros.node.graph import Graph
from artrec_ros.node.inputs import Inputs
from artrec_ros.node.live_images import LiveImages
from artrec_ros.node.publishers import Publishers

TOPIC = "/camera/image_raw"


@contextmanager
def listening(topic: str = TOPIC, kept: int = 5, info: str | None = None) -> Iterator[LiveImages]:
    live = LiveImages(topic, info, rectified=False, kept=kept)
    try:
        yield live
    finally:
        live.close()


def gradient(level: int) -> np.ndarray:
    """A colour picture that differs from all others."""
    picture = np.zeros((48, 64, 3), np.uint8)
    picture[:, :, 0], picture[:, :, 2] = np.arange(64), level
    return picture


def send_until(peer: Peer, live: LiveImages, msg: Any) -> None:
    """Sends an image again and again, with another stamp each, until one has come."""
    first = peer.send(msg)

    def come() -> bool:
        peer.send(msg)
        return any(m.header.stamp.sec >= first for m, *_ in live.held())

    assert wait_until(come, lambda: time.sleep(0.1)), live.state()


@pytest.mark.parametrize("reliable", [True, False])
def test_the_last_images_are_kept_with_their_stamps_and_pixels(reliable: bool) -> None:
    with Peer(TOPIC, reliable=reliable) as peer, listening() as live:
        send_until(peer, live, conversions.image_to_msg(gradient(0), Header()))
        first = live.held()[-1]
        for level in range(1, 12):
            send_until(peer, live, conversions.image_to_msg(gradient(level), Header()))
        held = live.held()
        assert len(held) == 5 and first not in held
        stamps = [live.frame(h).stamp_ns for h in held]
        assert stamps == sorted(set(stamps))
        newest = live.frame(held[-1])
        assert newest.image is not None and newest.camera is None
        np.testing.assert_array_equal(newest.image, gradient(11))
        assert newest.stamp_ns % 10**9 == 250 and newest.stamp_ns <= (1_700_000_000 + peer.sent) * 10**9 + 250
        assert "without calibration (no camera_info received: nobody publishes /camera/camera_info)" in live.state()


def test_compressed_images_come_too() -> None:
    data = cv2.imencode(".png", gradient(9))[1].tobytes()
    with Peer(f"{TOPIC}/compressed", image_type=CompressedImage) as peer, listening(f"{TOPIC}/compressed") as live:
        send_until(peer, live, CompressedImage(format="png", data=data))
        frame = live.frame(live.held()[-1])
        np.testing.assert_array_equal(frame.image, gradient(9))
        send_until(peer, live, CompressedImage(format="png", data=data[:100]))
        assert "PNG" in (live.frame(live.held()[-1]).error or "")


def test_the_calibration_beside_the_topic_holds() -> None:
    picture = np.zeros(toy.SIZE[::-1], np.uint8)
    with Peer("image_raw", namespace="camera") as peer, listening() as live:
        send_until(peer, live, _mono(picture))
        peer.send_camera(toy.CAMERA.matrix)
        assert wait_until(lambda: live.frame(live.held()[-1]).camera is not None)
        camera = live.frame(live.held()[-1]).camera
        assert camera is not None and camera.sees_as(toy.CAMERA) and live.frame(live.held()[-1]).image.ndim == 2
        send_until(peer, live, _mono(picture))
        assert live.state().endswith("calibrated")
    with Peer("image_raw", namespace="camera") as peer, listening(info="/other/camera_info") as live:
        assert wait_until(lambda: peer.node.count_subscribers("/other/camera_info"))
        assert peer.node.count_subscribers("/camera/camera_info") == 0


def test_doubts_about_the_calibration_are_told() -> None:
    image, of_right = _mono(np.zeros(toy.SIZE[::-1], np.uint8)), toy.camera_info()
    of_right.header.frame_id = "right"
    with Peer("image_raw", namespace="camera") as peer, listening() as live:
        send_until(peer, live, image)

        def is_used() -> bool:
            peer._infos.publish(of_right)
            return live.frame(live.held()[-1]).camera is not None

        assert wait_until(is_used, lambda: time.sleep(0.1))
        send_until(peer, live, image)
        assert "calibrated, in doubt: camera_info is of frame 'right', images are of 'eye'" in live.state()


def test_a_latched_calibration_is_heard_beside_a_publisher_that_is_not() -> None:
    with Peer("image_raw", namespace="camera") as peer:
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        peer.node.create_publisher(CameraInfo, "camera_info", latched).publish(toy.camera_info())
        with listening() as live:
            send_until(peer, live, _mono(np.zeros(toy.SIZE[::-1], np.uint8)))
            assert wait_until(lambda: live.frame(live.held()[-1]).camera is not None)
            peer.send(_mono(np.zeros(toy.SIZE[::-1], np.uint8)))
            assert len(live.held()) == len({m.header.stamp.sec for m, *_ in live.held()})


def test_where_no_calibration_comes_its_topic_is_told() -> None:
    with Peer(TOPIC) as peer, listening() as live:
        send_until(peer, live, conversions.image_to_msg(gradient(0), Header()))
        live.frame(live.held()[-1])
        named = peer.node.create_publisher(Header, "/camera/camera_info", 1)
        assert wait_until(lambda: "camera_info is std_msgs/msg/Header, not sensor_msgs/msg/CameraInfo" in live.state())
        peer.node.destroy_publisher(named)
        peer.node.create_publisher(CameraInfo, "/camera/camera_info", 1)
        assert wait_until(lambda: "1 publisher(s) of /camera/camera_info sent none" in live.state())


def _mono(picture: np.ndarray) -> Any:
    height, width = picture.shape
    return Image(height=height, width=width, encoding="mono8", step=width, data=picture.tobytes())


def test_images_without_a_stamp_are_told_apart_by_when_they_came() -> None:
    with Peer(TOPIC) as peer, listening() as live:
        peer.spin_until(lambda: peer.node.count_subscribers(TOPIC))
        before = time.time_ns()

        def come() -> bool:
            peer._images.publish(conversions.image_to_msg(gradient(1), Header()))
            return len(live.held()) >= 2

        assert wait_until(come, lambda: time.sleep(0.1))
        stamps = [live.frame(h).stamp_ns for h in live.held()]
        assert before < stamps[0] < stamps[1] < time.time_ns()


def test_where_no_image_comes_the_reason_is_told() -> None:
    with listening("/nothing") as live, Peer(TOPIC) as peer:
        assert wait_until(lambda: TOPIC in live.state(), lambda: time.sleep(0.1))
        with pytest.raises(
            SourceError, match=r"--topic /nothing: no image within 0.2 s: nobody publishes it; .*image_raw"
        ):
            live.wait(0.2)
        with listening() as silent:
            assert wait_until(lambda: "sends nothing" in silent.state(), lambda: time.sleep(0.1)), peer


PACKED, RAW = "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Image"


@pytest.mark.parametrize(
    ("topic", "sent", "other", "way"),
    [
        ("/eye/left", CompressedImage, PACKED, ": compressed, and remap image/compressed, not image, to /eye/left"),
        ("/eye/compressed", Image, RAW, "set image_transport: raw, and remap image to /eye/compressed"),
        ("/eye/odd", Header, "std_msgs/msg/Header", "take another topic"),
    ],
)
def test_a_topic_of_another_type_is_told_with_the_way_out(topic: str, sent: Any, other: str, way: str) -> None:
    with Peer(topic, image_type=sent), listening(topic) as live:
        assert wait_until(lambda: other in live.state(), lambda: time.sleep(0.1)), live.state()
        told = live._inputs.wrong_type
        assert told.startswith(f"{topic} is {other}, not ") and told.endswith(way)


def test_the_way_out_for_compressed_images_under_any_name_is_one() -> None:
    graph = Graph("remapped", ["image/compressed:=/eye/left"])
    inputs = Inputs(graph.node, NodeConfig(image_transport="compressed"), print, print)
    try:
        assert inputs.image._subscriptions[0].topic_name == inputs.image.topic == "/eye/left"
    finally:
        inputs.close()
        graph.close()


def test_subscribers_of_another_type_are_told() -> None:
    graph = Graph("published")
    outputs = Publishers(graph.node, [])
    try:
        with Peer() as peer:
            peer.listen("debug/image", CompressedImage)
            told = f"wrong type on /debug/image: peer hears nothing: it asks for {PACKED}, not {RAW}"
            assert wait_until(lambda: outputs.unheard() == [told], lambda: time.sleep(0.1))  # names come after topics
    finally:
        outputs.close()
        graph.close()


@pytest.mark.parametrize("topic", ["no topic", "a//b", "{camera}/image", "", "/compressed"])
def test_what_is_no_topic_is_refused_in_one_line(topic: str) -> None:
    with pytest.raises(SourceError, match=r"^--topic .* is no topic: .*$"):
        LiveImages(topic, None, rectified=False, kept=3)
