from __future__ import annotations

import dataclasses

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import Header

from artrec_ros.node.diagnostics import Diagnostics, InputState

FINE = InputState(topic="/image", publishers=1, incompatible="", dropped=0, calibration="")
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@pytest.fixture
def diagnostics() -> Diagnostics:
    return Diagnostics("/artrec_node", no_image_after_s=2.0, now_s=100.0)


def report(diagnostics: Diagnostics, now_s: float, **state: object) -> dict[str, DiagnosticStatus]:
    message = diagnostics.report(dataclasses.replace(FINE, **state), now_s, Header())
    return {s.name.rpartition(": ")[2]: s for s in message.status}


def values(status: DiagnosticStatus) -> dict[str, str]:
    return {v.key: v.value for v in status.values}


def test_each_trouble_has_a_text_of_its_own(diagnostics: Diagnostics) -> None:
    silent = [
        report(diagnostics, 101, publishers=0)["input"],
        report(diagnostics, 102)["input"],
        report(diagnostics, 103, incompatible="reliability differs")["input"],
    ]
    diagnostics.image_failed(104, "encoding 'x'")
    silent.append(report(diagnostics, 104)["input"])
    diagnostics.image_processed(105, 5.0, 0)
    nothing = report(diagnostics, 105, calibration="not calibrated")
    assert [s.level for s in silent] == [WARN, WARN, ERROR, ERROR]
    assert nothing["input"].level == OK and nothing["calibration"].level == WARN
    texts = [s.message for s in (*silent, nothing["calibration"], nothing["recognition"])]
    assert len(set(texts)) == len(texts)
    for text, part in zip(texts, ("nobody", "send none", "QoS", "encoding 'x'", "calibrated", "nothing"), strict=True):
        assert part in text


def test_rates_and_latencies_are_of_the_last_period(diagnostics: Diagnostics) -> None:
    for i in range(30):
        diagnostics.image_processed(100 + i / 15, float(i), 2)
    first = report(diagnostics, 102)
    assert values(first["input"])["rate_hz"] == "15.00"
    assert values(first["recognition"])["latency_median_ms"] == "14.5"
    assert "60 object(s)" in first["recognition"].message
    second = report(diagnostics, 103)
    assert values(second["input"])["rate_hz"] == "0.00"
    assert "latency_median_ms" not in values(second["recognition"])
    assert values(second["input"])["processed"] == "30"


def test_silence_is_told_after_its_time_only(diagnostics: Diagnostics) -> None:
    diagnostics.image_processed(100.5, 1.0, 1)
    assert report(diagnostics, 101)["input"].level == OK
    assert report(diagnostics, 102.4)["input"].level == OK
    assert report(diagnostics, 102.6)["input"].level == WARN


def test_an_old_mismatch_is_no_error_while_images_come(diagnostics: Diagnostics) -> None:
    diagnostics.image_processed(101, 1.0, 1)
    assert report(diagnostics, 101, incompatible="reliability differs")["input"].level == OK
