"""Starting, stopping and connecting the node: a process of its own for each test."""

from __future__ import annotations

import array
import signal
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import cv2
import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseArray
from peer import STARTED, NodeProcess, Peer, label_image, ros, wait_until
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CompressedImage, MultiDOFJointState

SLOW = """
import sys, time
from pathlib import Path
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.node.main import main
follow = Recognizer.follow
def slowly(*arguments):
    while Path({hold!r}).exists():
        time.sleep(0.05)
    return follow(*arguments)
Recognizer.follow = slowly
sys.exit(main())
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("busy", [False, True])
def test_signals_stop_it_cleanly(
    busy: bool, number: signal.Signals, parameter_file: Path, picture: np.ndarray, tmp_path: Path
) -> None:
    with NodeProcess(*ros(parameter_file), log=tmp_path / "log") as process, Peer() as peer:
        process.wait_for_output(STARTED)
        if busy:
            peer.listen("toy/poses", PoseArray)
            peer.connect(label_image(picture))
            for _ in range(20):
                peer.send(label_image(picture))
        assert process.stop(number) == 0
        assert "Traceback" not in process.output and "internal error" not in process.output


@pytest.mark.parametrize(
    ("arguments", "code", "reason"),
    [
        (["-p", "toy.object_file:=nowhere.yaml"], 1, "nowhere.yaml"),
        (["-p", "recognizer.min_match:=7.0"], 1, "recognizer.min_match"),
        (["--params-file", "nowhere.yaml"], 2, "nowhere.yaml: there is no such file"),
        (["--bogus"], 2, "--ros-args: ROS knows no ['--bogus']; it knows -r, -p, --params-file"),
    ],
)
def test_bad_parameters_are_one_line(
    arguments: list[str], code: int, reason: str, parameter_file: Path, tmp_path: Path
) -> None:
    with NodeProcess(*ros(parameter_file, *arguments), log=tmp_path / "log") as process:
        assert process.wait() == code
        assert reason in process.output
        assert len(process.output.splitlines()) == 1, process.output


def test_a_file_that_ros_would_read_for_minutes_is_refused_at_once(parameter_file: Path, tmp_path: Path) -> None:
    large = parameter_file.with_name("large.yaml")
    large.write_text(f"{parameter_file.read_text()}    scene: {{region: [{'1.0, ' * 500_000}1.0]}}\n")
    with NodeProcess(*ros(large), log=tmp_path / "log") as process:
        assert process.wait() == 2
        (line,) = process.output.splitlines()
        assert f"{large}: has 2" in line and "more than the 262144" in line


def test_without_parameters_the_way_to_give_them_is_told(tmp_path: Path) -> None:
    with NodeProcess(log=tmp_path / "log") as process:
        assert process.wait() == 1
        assert process.output.startswith(
            "artrec_node: no object to look for is named: give a parameter file (--ros-args --params"
        )


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("2000.0", "2000.0, time_budget_ms: 90.0", "the key 'time_budget_ms' is given twice; keep one"),
        ("objects:", "recognizer.time_budget_ms: 90.0\n    objects:", "is given twice, once of them as 'recognizer'"),
        ("/**:", "other_node:", "no section matches the node /artrec_node (there: other_node); use '/**:'"),
    ],
)
def test_what_ros_passes_over_in_a_parameter_file_is_one_line(
    old: str, new: str, reason: str, parameter_file: Path, tmp_path: Path
) -> None:
    text = parameter_file.read_text()
    assert old in text
    changed = parameter_file.with_name("changed.yaml")
    changed.write_text(text.replace(old, new, 1))
    with NodeProcess(*ros(changed), log=tmp_path / "log") as process:
        assert process.wait() == 1
        (line,) = process.output.splitlines()
        assert str(changed) in line and reason in line


def test_unknown_parameters_are_told_with_the_nearest_known_one(parameter_file: Path, tmp_path: Path) -> None:
    with NodeProcess(*ros(parameter_file, "-p", "recognizer.profil:=paper"), log=tmp_path / "log") as process:
        process.wait_for_output(STARTED)
        (line,) = [line for line in process.output.splitlines() if "WARN" in line]
        assert "recognizer.profil" in line and "did you mean 'recognizer.profile'?" in line


def test_compressed_images_beside_a_remapped_topic(parameter_file: Path, picture: np.ndarray, tmp_path: Path) -> None:
    arguments = ["-p", "image_transport:=compressed", "-r", "image:=/eye/labels", "-r", "__ns:=/left"]
    with (
        NodeProcess(*ros(parameter_file, *arguments), log=tmp_path / "log") as process,
        Peer("/eye/labels/compressed", "/left", image_type=CompressedImage) as peer,
    ):
        process.wait_for_output(STARTED)
        peer.listen("toy/poses", PoseArray)
        png = cv2.imencode(".png", picture)[1].tobytes()
        peer.connect(CompressedImage(format="mono8; png compressed", data=array.array("B", png)))
        assert peer.diagnose("recognition", "object(s) in")


@pytest.mark.parametrize("reliable", [True, False])
def test_reliability_follows_the_publisher(
    reliable: bool, parameter_file: Path, picture: np.ndarray, tmp_path: Path
) -> None:
    with NodeProcess(*ros(parameter_file), log=tmp_path / "log") as process, Peer(reliable=reliable) as peer:
        process.wait_for_output(STARTED)
        peer.listen("toy/poses", PoseArray)
        assert peer.connect(label_image(picture))


def test_a_mismatch_that_was_asked_for_is_told(parameter_file: Path, picture: np.ndarray, tmp_path: Path) -> None:
    arguments = ros(parameter_file, "-p", "qos_reliability:=reliable", "-p", "no_image_after_s:=0.1")
    with NodeProcess(*arguments, log=tmp_path / "log") as process, Peer("unused") as peer:
        process.wait_for_output(STARTED)
        with Peer(reliable=False):
            mismatch = peer.diagnose("input", "QoS mismatch")
            assert mismatch.level == DiagnosticStatus.ERROR
            assert "peer cannot be heard" in mismatch.message and "reliable" in mismatch.message
            assert peer.diagnose("calibration", "no camera_info").level == DiagnosticStatus.WARN
        assert peer.diagnose("input", "nobody publishes"), "a mismatch goes with its publisher"
        with Peer():
            assert peer.diagnose("input", "send none")


def test_nodes_that_share_names_are_told(parameter_file: Path, tmp_path: Path) -> None:
    """Of one name, and of two names in one namespace."""
    with Peer("unused") as peer, NodeProcess(*ros(parameter_file), log=tmp_path / "first") as first:
        first.wait_for_output(STARTED)
        assert peer.diagnose("output", "every subscriber can hear it")
        with NodeProcess(*ros(parameter_file), log=tmp_path / "second") as second:
            second.wait_for_output(STARTED)
            assert peer.diagnose("output", "another node is called /artrec_node too").level == DiagnosticStatus.WARN
            assert wait_until(lambda: "give each node a namespace of its own" in first.output)
            second.stop(signal.SIGINT)
        assert peer.diagnose("output", "every subscriber can hear it")
        other = ros(parameter_file, "-r", "__node:=other")
        with NodeProcess(*other, log=tmp_path / "third") as third:
            third.wait_for_output(STARTED)
            assert peer.diagnose("output", "/toy/poses: other publishes there too").level == DiagnosticStatus.WARN


def test_a_frame_that_takes_long_is_not_told_as_silence(
    parameter_file: Path, picture: np.ndarray, tmp_path: Path
) -> None:
    """The recogniser is held up by a file; the camera sends one image and waits."""
    hold = tmp_path / "hold"
    hold.touch()
    slow = SLOW.format(hold=str(hold))
    arguments = ros(parameter_file, "-p", "no_image_after_s:=0.5")
    with NodeProcess(*arguments, log=tmp_path / "log", program=slow) as process, Peer() as peer:
        process.wait_for_output(STARTED)
        peer.listen("toy/poses", PoseArray)
        dropped = peer.diagnose("input", "images dropped", sending=label_image(picture))
        assert dropped.level == DiagnosticStatus.WARN and dropped.hardware_id == "/image"
        peer.diagnose("input", "looked at for")
        for _ in range(2):
            assert "looked at for" in peer.diagnose("input", "").message
        hold.unlink()
        assert peer.spin_until(lambda: peer.heard["toy/poses"])
        assert peer.spin_until(lambda: peer.diagnose("input", "").hardware_id == "eye")  # counted once published


def test_a_subscriber_that_asks_for_more_than_is_offered_is_told(parameter_file: Path, tmp_path: Path) -> None:
    with NodeProcess(*ros(parameter_file), log=tmp_path / "log") as process, Peer() as peer:
        process.wait_for_output(STARTED)
        peer.listen("toy/robots", MultiDOFJointState)
        assert peer.diagnose("output", "every subscriber can hear it")
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        peer.node.create_subscription(PoseArray, "toy/poses", print, latched)
        status = peer.diagnose("output", "QoS mismatch")
        assert "/toy/poses" in status.message and "peer" in status.message and "transient local" in status.message
        assert "robots" not in status.message
