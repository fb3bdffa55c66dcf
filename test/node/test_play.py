"""`artrec play`, and that a bag through the node and through `artrec replay` gives the same answers."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import numpy as np
import toy
from geometry_msgs.msg import PoseArray
from peer import ROOT, STARTED, WAIT_S, NodeProcess, Peer, label_image, ros
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, JointState, MultiDOFJointState

from artrec_ros.io.bags.reader import Bag, Topic
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.parameters.parameter_file import Setup
from artrec_ros.io.results.results import FrameRecord, read_results
from artrec_ros.node.conversions import message_class
from artrec_ros.node.play import _messages
from artrec_ros.node.player import Player
from artrec_ros.tools.main import main as artrec

PLACES = ((0.05, 0.02, 0.6, 0.2), (0.04, 0.0, 0.5, -0.3), None, (-0.05, 0.03, 0.7, 0.5), (0.0, 0.0, 0.45, 0.0))
FIRST_NS, STEP_NS = 1_700_000_000_123_456_789, 100_000_000


@pytest.fixture(scope="module")
def bag(setup: Setup, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Images of a toy that moves, one of them without it; the calibration comes after the first."""
    path = tmp_path_factory.mktemp("played") / "bag"
    with BagWriter(path) as writer:
        for i, place in enumerate(PLACES):
            image = toy.draw(setup.targets[0].model, *place) if place else np.zeros(toy.SIZE[::-1], np.uint8)
            writer.write_image("/eye/labels", FIRST_NS + i * STEP_NS, "eye", image)
            writer.write_image("/other/labels", FIRST_NS + i * STEP_NS + 500, "other", image)
            writer.write_camera("/eye/camera_info", FIRST_NS + i * STEP_NS + 1000, toy.CAMERA)
    return path


@pytest.fixture(scope="module")
def replayed(bag: Path, parameter_file: Path) -> list[FrameRecord]:
    folder = bag.parent / "replay"
    arguments = ["--params-file", str(parameter_file), "-o", str(folder), "--images", "none", "--no-video"]
    assert artrec(["replay", str(bag), "--topic", "/eye/labels", *arguments]) == 0
    return list(read_results(folder / "detections.jsonl"))


def play(bag: Path, *arguments: str, listening: Peer | None = None) -> subprocess.CompletedProcess[str]:
    """`artrec play` as a process, and somebody who listens meanwhile."""
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-m", "artrec_ros.tools.main", "play", str(bag), *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, env={**os.environ, "PYTHONPATH": path}, **pipes) as process:
        if listening is not None and not listening.spin_until(lambda: process.poll() is not None):
            process.kill()
        out, errors = process.communicate(timeout=WAIT_S)
    return subprocess.CompletedProcess(command, process.returncode, out, errors)


def stamp_ns(msg: Any) -> int:
    return int(msg.header.stamp.sec) * 10**9 + int(msg.header.stamp.nanosec)


def vector(pose: Any) -> list[float]:
    p, q = pose.position, pose.orientation
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w]


def test_the_node_answers_as_the_replay_does(
    bag: Path, replayed: list[FrameRecord], parameter_file: Path, tmp_path: Path
) -> None:
    remap = ["-r", "image:=/eye/labels", "-r", "camera_info:=/eye/camera_info"]
    topics = {"toy/poses": PoseArray, "toy/robots": MultiDOFJointState, "toy/joint_states": JointState}
    with NodeProcess(*ros(parameter_file, *remap), log=tmp_path / "log") as process, Peer("/eye/labels") as peer:
        process.wait_for_output(STARTED)
        for topic, kind in topics.items():
            peer.listen(topic, kind)
        peer.connect(label_image(np.zeros(toy.SIZE[::-1], np.uint8)), first_stamp_s=1_600_000_000)

        def answers(topic: str) -> list[Any]:
            return [msg for msg in peer.heard[topic] if stamp_ns(msg) >= FIRST_NS]

        peer.listen("/other/labels", Image)  # who listens to these images answers none
        done = play(bag, "--wait-for", "toy/poses", listening=peer)
        assert done.returncode == 0, done.stderr
        assert "/eye/labels: 5 messages sent" in done.stdout and "/other/labels: 5 messages sent" in done.stdout
        assert "waiting for the answer to each image of /eye/labels\n" in done.stderr
        assert peer.spin_until(lambda: all(len(answers(t)) == len(PLACES) for t in topics))
    assert sum(len(r.detections) for r in replayed) == 4, "each toy is found, and none where there is none"
    for i, record in enumerate(replayed):
        poses, named, joints = (answers(topic)[i] for topic in topics)
        assert stamp_ns(poses) == stamp_ns(named) == stamp_ns(joints) == record.stamp_ns
        assert named.joint_names == [f"toy_{d.id}" for d in record.detections]
        for pose, detection in zip(poses.poses, record.detections, strict=True):
            expected = [*detection.pose.position, *detection.pose.quaternion]
            assert vector(pose) == pytest.approx(expected, abs=1e-6)  # as detections.jsonl rounds
        told = {f"toy_{d.id}/{name}": q for d in record.detections for name, q in d.joints.items()}
        assert dict(zip(joints.name, joints.position, strict=True)) == pytest.approx(told, abs=1e-6)


def test_the_bags_time_and_stamps_are_kept(bag: Path) -> None:
    """In its own time, sped up, with the clock; under other names; and no more than was asked for."""
    with Peer("unused") as peer:
        peer.listen("/clock", Clock)
        peer.listen("/info", CameraInfo)
        done = play(bag, "-r", "2", "-m", "/eye/camera_info:=/info", "--topics", "/eye/camera_info", listening=peer)
        assert done.returncode == 0, done.stderr
        assert "/eye/labels" not in done.stdout
        assert peer.spin_until(lambda: len(peer.heard["/info"]) == len(PLACES))
    stamps = [stamp_ns(m) for m in peer.heard["/info"]]
    assert stamps == [FIRST_NS + i * STEP_NS + 1000 for i in range(len(PLACES))]
    times = [m.clock.sec * 10**9 + m.clock.nanosec for m in peer.heard["/clock"]]
    assert times == sorted(times) and times[-1] == stamps[-1]
    assert len(times) > len(stamps), "the clock goes on between messages"


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["--topics", "/nowhere"], 1, "no topic '/nowhere'; there are /eye/camera_info, /eye/labels, /other/labels"),
        (["--remap", "image"], 1, "OLD:=NEW"),
        (["--wait-for", "silence", "--timeout", "0.5"], 1, "nobody publishes /silence"),
        (["--rate", "0"], 2, "'0' is no positive number"),
        (["--start-offset", "1000", "--loop"], 1, "nothing to send: it lasts 0.40 s, --start-offset is 1000"),
        (["--wait-for", "bad-name!"], 1, "--wait-for: 'bad-name!' is no topic"),
        (["--remap", "/eye/labels:=bad-name!"], 1, "--remap: 'bad-name!' is no topic"),
    ],
)
def test_mistakes_are_told(bag: Path, arguments: list[str], code: int, said: str) -> None:
    done = play(bag, *arguments)
    assert done.returncode == code and said in done.stderr and "Traceback" not in done.stderr


def test_what_a_bag_lacks_is_told(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for n in range(40):
            writer.write_image("/eye/labels", n, "eye", np.full((90, 90), n, np.uint8))
    file = tmp_path / "bag/bag.mcap"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    done = play(tmp_path / "bag")
    assert "waiting for those who listen to connect, for 5 s at most" in done.stderr
    assert done.returncode == 0 and f"{file}: it ends in the middle" in done.stderr
    assert "messages were read, but metadata.yaml tells of 40" in done.stderr


def test_what_was_latched_is_offered_so() -> None:
    """Else a listener to transforms that stay hears nothing; one who can't hear anything is not waited for."""
    kind = "sensor_msgs/msg/Image"
    topics = [Topic("/tf_static", kind, 1), Topic("/kept", kind, 1, latched=True), Topic("/passing", kind, 1)]
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    with Peer("unused") as peer:
        player = Player(peer.node, topics)
        offered = [p.qos_profile.durability.name for p in player._publishers.values()]
        assert offered == ["TRANSIENT_LOCAL", "TRANSIENT_LOCAL", "VOLATILE"]
        for topic in topics:
            peer.node.create_subscription(message_class(topic.msgtype), topic.name, print, kept)
        heard = {name: lambda p=p: player._listeners(p) for name, p in player._publishers.items()}
        assert peer.spin_until(lambda: heard["/tf_static"]() and heard["/kept"]())
        assert peer.node.count_subscribers("/passing") == 1 and not heard["/passing"]()


def test_calibrations_that_tell_the_same_are_not_waited_for_again(bag: Path) -> None:
    """Of each the middleware tells only seconds later that it has arrived."""
    with Peer("unused") as peer, Bag(bag) as recorded:
        player = Player(peer.node, recorded.topics.values(), wait_for="answers")
        waited: list[float] = []
        for name, publisher in player._publishers.items():
            told = SimpleNamespace(publish=publisher.publish, wait_for_all_acked=lambda _: waited.append(1))
            player._publishers[name] = told
        info = list(recorded.messages(["/eye/camera_info"]))
        assert len(info) == len(PLACES)
        for message in info:
            player._send(message)
        assert len(waited) == 1
        other = info[0].data[:-8] + bytes(8 * [1])
        for message in (info[0]._replace(data=other), info[0]):
            player._send(message)
        assert len(waited) == 3


def test_what_is_answered_one_by_one_goes_behind_its_own_calibration(tmp_path: Path) -> None:
    """In its own time the order is that of recording: a node that is too slow for it is to be seen."""
    with BagWriter(tmp_path / "bag") as writer:
        for stamp_ns in (FIRST_NS, FIRST_NS + STEP_NS):
            writer.write_image("/eye/labels", stamp_ns, toy.CAMERA.frame_id, np.zeros((4, 4), np.uint8))
            writer.write_camera("/eye/camera_info", stamp_ns, toy.CAMERA)
    kinds = {}
    for wait_for in ("toy/poses", None):
        args = SimpleNamespace(start_offset=0.0, playback_duration=None, wait_for=wait_for)
        with Bag(tmp_path / "bag") as recorded:
            sent = _messages(recorded, list(recorded.topics.values()), args)
            kinds[wait_for] = ["info" if "info" in m.topic else "image" for m in sent]
    assert kinds == {"toy/poses": ["info", "info", "image", "info", "image"], None: ["image", "info"] * 2}


def test_an_image_that_is_not_answered_is_told_while_it_plays(bag: Path) -> None:
    """Somebody listens and publishes, but has no answers."""
    with Peer("unused") as peer:
        peer.listen("/eye/labels", Image)
        peer.node.create_publisher(PoseArray, "toy/poses", 1)
        arguments = ("--wait-for", "toy/poses", "--playback-duration", "0.05", "--timeout", "10")
        done = play(bag, "--topics", "/eye/labels", *arguments, listening=peer)
    assert done.returncode == 1
    assert f"/eye/labels: the image of {FIRST_NS} ns was not answered in 10 s" in done.stderr
    assert "1 images were not answered" in done.stderr
