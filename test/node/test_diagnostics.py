from __future__ import annotations

import dataclasses

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import Header

from artrec_ros.core.model.found import Detection, ImagePose
from artrec_ros.core.model.frame_result import Rejection
from artrec_ros.node.diagnostics import Diagnostics, NodeState
from artrec_ros.node.pipeline import FrameReport

FINE = NodeState(topic="/image", publishers=1, incompatible="", dropped=0, calibration="")
TIME, NODES = "recognizer.time_budget_ms", "expert.grouping.search_nodes"
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@pytest.fixture
def diagnostics() -> Diagnostics:
    return Diagnostics("/artrec_node", now_s=100.0)


def frame(latency_ms: float, n_objects: int, *, ended_by: tuple[str, ...] = (), problem: str = "") -> FrameReport:
    return FrameReport(n_objects, latency_ms, latency_ms - 1, ended_by, problem)


def report(diagnostics: Diagnostics, now_s: float, **state: object) -> dict[str, DiagnosticStatus]:
    message = diagnostics.report(dataclasses.replace(FINE, **state), 2.0, now_s, Header())
    return {s.name.rpartition(": ")[2]: s for s in message.status}


def values(status: DiagnosticStatus) -> dict[str, str]:
    return {v.key: v.value for v in status.values}


def test_each_trouble_has_a_text_of_its_own(diagnostics: Diagnostics) -> None:
    silent = [
        report(diagnostics, 102.1, publishers=0)["input"],
        report(diagnostics, 102.5)["input"],
        report(diagnostics, 103, incompatible="reliability differs")["input"],
    ]
    diagnostics.image_failed(104, "encoding 'x'")
    silent.append(report(diagnostics, 104)["input"])
    diagnostics.image_processed(105, frame(5.0, 0))
    nothing = report(diagnostics, 105, calibration="not calibrated")
    assert [s.level for s in silent] == [WARN, WARN, ERROR, ERROR]
    assert nothing["input"].level == OK and nothing["calibration"].level == WARN
    texts = [s.message for s in (*silent, nothing["calibration"], nothing["recognition"])]
    assert len(set(texts)) == len(texts)
    for text, part in zip(texts, ("nobody", "send none", "QoS", "encoding 'x'", "calibrated", "nothing"), strict=True):
        assert part in text


@pytest.mark.parametrize(
    ("reason", "level"), [("scene.region leaves no pixel of the image", WARN), ("3 blobs of its classes", OK)]
)
def test_why_there_was_nothing_to_look_at_is_told(diagnostics: Diagnostics, reason: str, level: bytes) -> None:
    blobless = (Rejection("red", reason),)
    diagnostics.image_processed(101, dataclasses.replace(frame(5.0, 0), blobless=blobless))
    status = report(diagnostics, 102)["recognition"]
    assert (status.level, status.message) == (level, f"nothing found in 1 image(s): red: {reason}")


def test_rates_and_latencies_are_of_the_last_period(diagnostics: Diagnostics) -> None:
    for i in range(30):
        diagnostics.image_processed(100 + i / 15, frame(float(i), 2))
    first = report(diagnostics, 102)
    assert values(first["input"])["rate_hz"] == "15.00"
    assert values(first["recognition"])["latency_median_ms"] == "14.50"
    assert values(first["recognition"])["added_median_ms"] == "1.00"
    assert "60 object(s)" in first["recognition"].message
    second = report(diagnostics, 103)
    assert values(second["input"])["rate_hz"] == "0.00"
    assert "latency_median_ms" not in values(second["recognition"])
    assert values(second["input"])["processed"] == "30"


def test_silence_is_told_after_its_time_only(diagnostics: Diagnostics) -> None:
    diagnostics.image_processed(100.5, frame(1.0, 1))
    assert report(diagnostics, 101)["input"].level == OK
    assert report(diagnostics, 102.4)["input"].level == OK
    assert report(diagnostics, 102.6)["input"].level == WARN


def test_an_image_that_could_not_be_used_is_told_until_another_one_comes(diagnostics: Diagnostics) -> None:
    diagnostics.image_failed(100.5, "damaged")
    for now_s in (101, 102):  # the second report is of a time in which none came
        status = report(diagnostics, now_s)["input"]
        assert status.level == ERROR and "damaged" in status.message
    assert "of those that came: damaged" in report(diagnostics, 103)["input"].message
    diagnostics.image_processed(103.5, frame(1.0, 1))
    for now_s in (104, 105):
        assert report(diagnostics, now_s)["input"].level == OK


def test_silence_counts_from_the_start_and_from_each_activation(diagnostics: Diagnostics) -> None:
    assert report(diagnostics, 101.5)["input"].level == OK
    report(diagnostics, 110, active=False)
    assert report(diagnostics, 111.5)["input"].level == OK
    assert report(diagnostics, 112.5)["input"].message.endswith("send none")
    diagnostics.image_failed(113, "encoding 'x'")
    assert report(diagnostics, 116)["input"].message.endswith("send none any more; of those that came: encoding 'x'")
    diagnostics.image_processed(117, frame(1.0, 1))
    assert report(diagnostics, 120)["input"].message.endswith("send none any more")


def test_an_old_mismatch_is_no_error_while_images_come(diagnostics: Diagnostics) -> None:
    diagnostics.image_processed(101, frame(1.0, 1))
    assert report(diagnostics, 101, incompatible="reliability differs")["input"].level == OK


def test_losses_cut_off_searches_and_poor_headers_are_told(diagnostics: Diagnostics) -> None:
    for limit in (TIME, NODES) * 4:
        diagnostics.image_processed(101, frame(5.0, 1, ended_by=(limit,), problem="images bear no frame_id"))
    told = report(diagnostics, 101, dropped=3, lost=4)
    assert (values(told["input"])["dropped"], values(told["input"])["lost"]) == ("3", "4")
    assert told["input"].level == WARN and "frame_id" in told["input"].message
    assert told["recognition"].level == WARN and values(told["recognition"])["incomplete"] == "8"
    for limit in (TIME, NODES):
        assert f"{limit} ended the search in 4" in told["recognition"].message


def test_those_who_hear_nothing_are_named(diagnostics: Diagnostics) -> None:
    assert report(diagnostics, 101)["output"].level == OK
    status = report(diagnostics, 102, unheard=("QoS mismatch on /red/poses: rviz hears nothing",))["output"]
    assert status.level == WARN and "QoS mismatch on /red/poses: rviz" in status.message


def test_a_topic_of_another_type_is_told_while_no_images_come(diagnostics: Diagnostics) -> None:
    wrong = "/image is sensor_msgs/msg/CompressedImage: set image_transport: compressed"
    status = report(diagnostics, 103, wrong_type=wrong)["input"]
    assert status.level == ERROR and wrong in status.message
    diagnostics.image_processed(104, frame(1.0, 1))
    assert report(diagnostics, 104, wrong_type=wrong)["input"].level == OK


def test_an_inactive_node_complains_of_nothing(diagnostics: Diagnostics) -> None:
    status = report(diagnostics, 200, active=False, publishers=0)["input"]
    assert status.level == OK and "not active" in status.message


def test_a_long_look_at_one_image_is_no_silence(diagnostics: Diagnostics) -> None:
    diagnostics.image_processed(101, frame(1.0, 1))
    report(diagnostics, 101)
    status = report(diagnostics, 109, busy_s=7.5)["input"]
    assert status.level == OK and "7.5 s" in status.message
    assert report(diagnostics, 110)["input"].level == WARN


def test_most_images_dropped_or_lost_are_worth_a_warning(diagnostics: Diagnostics) -> None:
    for _ in range(10):
        diagnostics.image_processed(101, frame(1.0, 1))
    half = report(diagnostics, 101, dropped=10)["input"]
    assert half.level == OK, half.message
    for _ in range(10):
        diagnostics.image_processed(102, frame(1.0, 1))
    most = report(diagnostics, 102, dropped=30)["input"]
    assert most.level == WARN and "20 of 30 images dropped" in most.message
    diagnostics.image_processed(103, frame(1.0, 1))
    away = report(diagnostics, 103, dropped=30, lost=9)["input"]
    assert away.level == WARN and "9 of 10 images lost" in away.message
    diagnostics.image_processed(104, frame(1.0, 1))
    again = report(diagnostics, 104, dropped=0, lost=0)["input"]  # activated anew: counted anew
    assert again.level == OK
    waiting = report(diagnostics, 105, dropped=30, busy_s=1.2)["input"]
    assert waiting.level == WARN and "30 of 30" in waiting.message


def test_images_that_were_dropped_while_the_node_got_ready_did_not_come_too_fast(diagnostics: Diagnostics) -> None:
    report(diagnostics, 101, getting_ready=0.9)
    after = report(diagnostics, 102, dropped=5)["input"]
    assert after.message == "5 of 5 images dropped: the node was getting ready"
    diagnostics.image_processed(103, frame(1.0, 1))
    later = report(diagnostics, 103, dropped=10)["input"]
    assert later.message == "5 of 6 images dropped: they come faster than they are recognised"


def test_the_cameras_frame_tells_the_hardware(diagnostics: Diagnostics) -> None:
    assert {s.hardware_id for s in report(diagnostics, 101).values()} == {"/image"}
    diagnostics.image_failed(102, "encoding 'x'", "left_eye")
    assert {s.hardware_id for s in report(diagnostics, 102).values()} == {"left_eye"}
    diagnostics.image_processed(103, FrameReport(1, 1.0, 1.0, (), "", "eye"))
    diagnostics.image_processed(103, frame(1.0, 1))
    assert {s.hardware_id for s in report(diagnostics, 103).values()} == {"eye"}


def test_others_that_publish_under_the_same_names_are_told(diagnostics: Diagnostics) -> None:
    status = report(diagnostics, 101, shared=("/red/poses: left publishes there too",))["output"]
    assert status.level == WARN and "/red/poses: left" in status.message


def test_poses_on_a_plane_miss_no_calibration(diagnostics: Diagnostics) -> None:
    status = report(diagnostics, 101, calibration="no camera_info", on_plane=True)["calibration"]
    assert status.level == OK and "no camera_info" in status.message and "scene.plane" in status.message


@pytest.mark.parametrize(("blobs", "dropped", "said"), [(25, 3, True), (25, 0, False), (0, 3, False)])
def test_that_blobs_wait_is_said_where_images_come_too_fast(
    diagnostics: Diagnostics, blobs: int, dropped: int, said: bool
) -> None:
    """Where none is dropped they wait because they were searched in vain before."""
    diagnostics.image_processed(101, FrameReport(0, 1.0, 1.0, (), "", waiting=blobs))
    recognition = report(diagnostics, 102, dropped=dropped)["recognition"]
    assert (f"{blobs} blob(s) wait for a close look" in recognition.message) == said
    assert values(recognition)["blobs_waiting"] == f"{blobs:.1f}"


def test_a_calibration_that_may_be_anothers_is_told_unless_there_is_none(diagnostics: Diagnostics) -> None:
    status = report(diagnostics, 101, doubt="camera_info is of frame 'b'")["calibration"]
    assert status.level == WARN and status.message == "calibrated, in doubt: camera_info is of frame 'b'"
    status = report(diagnostics, 102, doubt="camera_info is of frame 'b'", calibration="not calibrated")["calibration"]
    assert status.message.startswith("not calibrated") and "'b'" not in status.message


def test_a_plane_on_which_all_look_larger_is_told(diagnostics: Diagnostics) -> None:
    one = Detection("robot", 0, 0.9, ImagePose(1.0, 2.0, 0.0, 400.0), (), plane_scale=1.2)
    diagnostics.image_processed(101, FrameReport(20, 1.0, 1.0, (), "", on_plane=[one] * 20))
    status = report(diagnostics, 101, on_plane=True)["calibration"]
    assert status.level == WARN and "20 % larger than scene.plane" in status.message
    assert report(diagnostics, 102, on_plane=False)["calibration"].level == OK
    doubted = report(diagnostics, 103, on_plane=True, doubt="of another size")["calibration"]
    assert "20 % larger" in doubted.message and doubted.message.endswith("in doubt: of another size")
    diagnostics.image_processed(
        104, FrameReport(200, 1.0, 1.0, (), "", on_plane=[dataclasses.replace(one, plane_scale=1.0)] * 200)
    )
    assert report(diagnostics, 104, on_plane=True)["calibration"].level == OK  # another plane was given
