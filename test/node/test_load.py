"""More than it can do, publishers that come back changed, and time that jumps: the node goes on."""

from __future__ import annotations

import array
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseArray
from peer import STARTED, NodeProcess, Peer, label_image, ros
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image

EMPTY = np.zeros((240, 320), np.uint8)


@pytest.fixture
def node(parameter_file: Path, tmp_path: Path) -> Iterator[NodeProcess]:
    with NodeProcess(*ros(parameter_file, "-p", "use_sim_time:=true"), log=tmp_path / "log") as process:
        process.wait_for_output(STARTED)
        yield process
        assert process.running and "Traceback" not in process.output


def numbers(status: DiagnosticStatus) -> dict[str, int]:
    return {v.key: int(v.value) for v in status.values if v.key in ("processed", "failed", "dropped", "lost")}


def test_a_burst_is_not_queued_and_every_image_is_accounted_for(node: NodeProcess, picture: np.ndarray) -> None:
    """While somebody who subscribes to the overlay never takes it."""
    with Peer() as peer, Peer("unused") as slow:
        slow.listen("debug/image", Image)
        peer.listen("toy/poses", PoseArray)
        peer.connect(label_image(picture))
        before = sum(numbers(peer.diagnose("input", "images/s", sending=label_image(EMPTY))).values())
        sent_before = peer.sent
        for _ in range(150):
            peer.send(label_image(picture))
        last = peer.send(label_image(EMPTY))
        assert peer.answer("toy/poses", last).poses == [], "the newest is never the one that is dropped"
        counted: dict[str, int] = {}

        def all_told() -> bool:
            counted.update(numbers(peer.diagnose("input", "")))
            return sum(counted.values()) - before >= peer.sent - sent_before

        assert peer.spin_until(all_told), counted
        assert counted["dropped"] + counted["lost"] > 0 and counted["failed"] == 0
        assert len(peer.heard["toy/poses"]) < 150


def test_a_publisher_that_restarts_with_another_size_and_encoding(node: NodeProcess, picture: np.ndarray) -> None:
    deep = picture[20:220, 40:300].astype("<u2")
    height, width = deep.shape
    msg = Image(height=height, width=width, step=2 * width, encoding="mono16", data=array.array("B", deep.tobytes()))
    for image, reliable in ((label_image(picture), True), (msg, False), (label_image(picture), True)):
        with Peer(reliable=reliable) as peer:
            peer.listen("toy/poses", PoseArray)
            peer.connect(image)
            assert peer.diagnose("recognition", "object(s) in", sending=image)
            assert numbers(peer.diagnose("input", "", sending=image))["failed"] == 0


def test_time_that_jumps(node: NodeProcess, picture: np.ndarray) -> None:
    """Simulated time stands still, starts anew, and images bear stamps of before."""
    with Peer() as peer:
        peer.listen("toy/poses", PoseArray)
        clock = peer.node.create_publisher(Clock, "/clock", 10)
        peer.connect(label_image(picture))
        for now_s in (1_700_000_000, 1_700_000_010, 5, 0, 1_700_000_000):
            msg = Clock()
            msg.clock.sec = now_s
            clock.publish(msg)
            for stamp_s in (now_s, now_s + 1, max(0, now_s - 1)):
                peer.heard["toy/poses"].clear()
                assert peer.answer("toy/poses", peer.send(label_image(picture), stamp_s))
        assert peer.diagnose("recognition", "object(s) in", sending=label_image(picture))
