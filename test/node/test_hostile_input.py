"""Whatever is sent, the node lives, counts it, and says why in one line.

`pytest --hypothesis-profile=nightly test/node/test_hostile_input.py` tries 20,000 messages for each kind of
image.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")
pytest.importorskip("hypothesis")

import hostile
import numpy as np
import toy
from geometry_msgs.msg import PoseArray
from hypothesis import HealthCheck, given, settings
from lone_node import alone
from peer import STARTED, NodeProcess, Peer, label_image, ros
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from artrec_ros.node.conversions import image_to_msg
from artrec_ros.node.node import RecognizerNode

CLASS = "{kind: %s, classes: [toy], toy: {label: 7, %s}}"
KINDS = {  # image.kind -> the section `image` of the parameter file
    "labels": "image: {kind: labels}",
    "palette": "image: " + CLASS % ("palette", "rgb: [200, 20, 20]"),
    "colour": "image: " + CLASS % ("colour", "hue: [340.0, 20.0], saturation: [0.5, 1.0]"),
}
TRIES = settings(deadline=None, suppress_health_check=list(HealthCheck), database=None)


@pytest.fixture(scope="module", params=KINDS)
def node(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RecognizerNode]:
    """An active node in this process, for images of each kind; nothing spins it, messages are handed to it."""
    file = toy.write_files(tmp_path_factory.mktemp(request.param) / "config")
    file.write_text(file.read_text().replace("image: {kind: labels, blank: []}", KINDS[request.param]))
    with alone(file, "-p", "recognizer.time_budget_ms:=200.0") as made:
        yield made


@pytest.fixture
def good(node: RecognizerNode, picture: np.ndarray) -> Image:
    """An image with a toy, as the node reads it."""
    msg = label_image(picture)
    if node.get_parameter("image.kind").value == "labels":
        return msg
    colours = np.where(picture[:, :, None] > 0, np.uint8([20, 20, 200]), np.uint8([90, 90, 90]))
    return image_to_msg(np.ascontiguousarray(colours, np.uint8), msg.header)


@given(msg=hostile.any_message())
@TRIES
def test_every_message_is_survived_and_counted(node: RecognizerNode, good: Image, msg: object) -> None:
    counters = node.counters
    before = counters.processed, counters.failed
    msg = deserialize_message(serialize_message(msg), type(msg))  # as a subscriber gets it
    if isinstance(msg, CameraInfo):
        node.take_camera_info(msg)
        good.header = msg.header
        node.take_image(good, time.time_ns())
        assert (counters.processed, counters.failed) == (before[0] + 1, before[1]), counters.last_error
        return
    node.take_image(msg, time.time_ns())
    assert (counters.processed - before[0]) + (counters.failed - before[1]) == 1
    if counters.failed > before[1]:
        assert counters.last_error and "\n" not in counters.last_error and len(counters.last_error) < 400
        assert "internal" not in counters.last_error


def test_a_node_that_was_treated_so_still_works(node: RecognizerNode, good: Image) -> None:
    objects = node.counters.objects
    node.take_camera_info(CameraInfo())
    node.take_image(good, time.time_ns())
    assert node.counters.objects == objects + 1


@pytest.mark.parametrize("claim", hostile.CLAIMS)
def test_claims_of_gigapixels_are_refused_before_memory_is_spent(node: RecognizerNode, claim: bytes) -> None:
    began = time.thread_time()  # not the clock's: the machine may be busy with other work
    node.take_image(CompressedImage(format="png", data=list(claim)), time.time_ns())
    assert time.thread_time() - began < 1.0
    assert "implausible" in node.counters.last_error


def test_over_the_wire(parameter_file: Path, picture: np.ndarray, tmp_path: Path) -> None:
    """A process of its own, with damaged serialised messages too: it answers what is right among them."""
    good = label_image(picture)
    whole = serialize_message(good)
    damaged = [b"", b"\0\1\0\0", whole[:60], whole[:-99], whole + b"x" * 99, b"\xff" * 300]
    poor = [
        Image(height=2**31, width=2**31, step=7, encoding="mono8"),
        Image(height=1, width=1, step=1, encoding="\u2764"),
        Image(),
    ]
    with NodeProcess(*ros(parameter_file), log=tmp_path / "log") as process, Peer() as peer:
        process.wait_for_output(STARTED)
        peer.listen("toy/poses", PoseArray)
        peer.connect(good)
        for round_number in range(10):
            for data in damaged:
                peer.send_serialized(data)
            for msg in poor:
                peer.send(msg)
                time.sleep(0.03)  # else the next one, being newer, is mostly looked at in its place
            assert peer.answer("toy/poses", peer.send(good)), round_number
        failed = peer.diagnose("input", "could not be used", sending=poor[0])
        assert int({v.key: v.value for v in failed.values}["failed"]) > 0
        assert "Traceback" not in process.output
        assert all(np.diff(process.told_s("image skipped")) > 4.9), "not a line for each image"
