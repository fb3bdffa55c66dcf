"""Recognisers that are built, at first and where parameters change, while images come."""

from __future__ import annotations

import time
import types
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from lone_node import alone, gate, getting_ready, statuses
from peer import WAIT_S, label_image, wait_until
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter

from artrec_ros.core.base import kernel_cache
from artrec_ros.io.parameters.parameter_file import Setup
from artrec_ros.node.node import RecognizerNode


def test_a_change_is_answered_at_once_and_works_when_its_recognizer_is_built(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    name, whole = "image.blank", [0, 0, *picture.shape[::-1]]
    building = gate(monkeypatch, Setup, "build")
    told: list[str] = []
    monkeypatch.setattr(node._pipeline, "_on_use", told.append)
    (answer,) = node.set_parameters([Parameter(name, value=whole)])
    assert answer.successful and list(node.get_parameter(name).value) == whole
    assert building.begun.wait(WAIT_S)
    node.take_image(label_image(picture), time.time_ns())
    assert node.counters.objects == 1, "meanwhile the one that there was answers"
    (refused,) = node.set_parameters([Parameter("recognizer.profile", value="papr")])
    assert not refused.successful and "papr" in refused.reason
    assert node.get_parameter("recognizer.profile").value == "default"
    assert not told, "it does not hold yet"
    building.go_on.set()

    def nothing_found() -> bool:
        before = node.counters.objects
        node.take_image(label_image(picture), time.time_ns())
        return node.counters.objects == before

    assert wait_until(nothing_found)
    assert building.calls == 1 and told == [f"in use from now on: {name} {whole}"]
    statuses(node, monkeypatch)  # of the images before
    node.take_image(label_image(picture), time.time_ns())
    status = statuses(node, monkeypatch)["recognition"]
    assert status.level == DiagnosticStatus.WARN and "toy: image.blank leaves no pixel of the image" in status.message


def test_a_change_that_takes_a_class_its_colours_is_warned_of_and_many_numbers_are_cut_short(
    parameter_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    colour = parameter_file.with_name("colour.yaml")
    classes = "{kind: colour, classes: [red], red: {label: 7, rgb: [200, 10, 10]}"
    colour.write_text(parameter_file.read_text().replace("{kind: labels, blank: []", classes))
    logged: list[str] = []
    with alone(colour) as node:
        log = types.SimpleNamespace(info=logged.append, warning=logged.append, error=logged.append)
        monkeypatch.setattr(node, "get_logger", lambda: log)
        monkeypatch.setattr(node._pipeline, "_on_use", logged.append)
        for value, told in (
            ([], "no colour is given for red"),
            ([200, 10, 10] * 100, "200, 10, 10, ...] (300 of them)"),
        ):
            logged.clear()
            (answer,) = node.set_parameters([Parameter("image.red.rgb", Parameter.Type.INTEGER_ARRAY, value)])
            assert answer.successful
            assert wait_until(lambda: any("in use from now on" in line for line in logged))
            assert any(told in line for line in logged) and max(map(len, logged)) < 300, logged
            assert len(logged) == 1 + (not value)


def test_it_answers_reports_and_counts_while_it_gets_ready(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    building = getting_ready(node, monkeypatch)
    assert not node.is_ready
    inputs = node._inputs
    for _ in range(3):
        inputs._worker.offer((label_image(picture), time.time_ns()))
        assert wait_until(lambda: inputs.busy_s > 0)
    node._pipeline._told(0.4)  # as the compiler does
    status = statuses(node, monkeypatch)
    assert "getting ready, 40%" in status["recognition"].message
    assert "1 image(s) dropped" in status["input"].message
    assert {v.key: v.value for v in status["input"].values}["dropped"] == "1"
    building.go_on.set()
    assert wait_until(lambda: node.counters.processed == 2), "the first, which may be the only one, and the newest"
    assert node.is_ready and node.counters.objects == 2
    assert not [s for s in statuses(node, monkeypatch).values() if "getting ready" in s.message]


@pytest.mark.parametrize("is_off", [False, True])
def test_it_is_logged_at_once_and_once_that_each_start_compiles_or_none_does(
    node: RecognizerNode, monkeypatch: pytest.MonkeyPatch, is_off: bool
) -> None:
    logged: list[str] = []
    log = types.SimpleNamespace(**dict.fromkeys(("info", "warning"), lambda *_, **__: None), error=logged.append)
    monkeypatch.setattr(node, "get_logger", lambda: log)
    if is_off:
        monkeypatch.setattr("numba.config.DISABLE_JIT", 1)
    else:
        monkeypatch.setattr(kernel_cache, "writable", lambda: None)
    building = getting_ready(node, monkeypatch)
    if not is_off:
        assert not logged, "all may be kept from before"
        node._pipeline._told(0.1)
        node._pipeline._told(0.2)
        assert "getting ready, 20%: compiling, at every start" in statuses(node, monkeypatch)["recognition"].message
    (line,) = logged
    assert ("NUMBA_DISABLE_JIT" if is_off else "NUMBA_CACHE_DIR") in line
    building.go_on.set()
    assert wait_until(lambda: node.is_ready) and len(logged) == 1


def test_a_recognizer_that_cannot_be_built_is_told_of_refused_and_tried_anew(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert node.trigger_deactivate() == node.trigger_cleanup() == TransitionCallbackReturn.SUCCESS
    broken = MemoryError("no room\nfor views")
    logged: list[str] = []

    def fails(*_: Any, **__: Any) -> None:
        raise broken

    with monkeypatch.context() as patch:
        patch.setattr(Setup, "build", fails)
        logger = types.SimpleNamespace(**dict.fromkeys(("info", "warning"), lambda *_, **__: None), error=logged.append)
        patch.setattr(node, "get_logger", lambda: logger)
        assert node.trigger_configure() == TransitionCallbackReturn.SUCCESS
        assert wait_until(lambda: bool(logged)) and not node.is_ready
        status = statuses(node, monkeypatch)["recognition"]
        assert status.level == DiagnosticStatus.ERROR and status.message == logged[0]
        assert (
            "could not be built: internal error: MemoryError: no room for views" in status.message
            and "\n" not in status.message
        )
        assert node.trigger_activate() == TransitionCallbackReturn.FAILURE, "as the service answers"
        assert logged[0] == logged[-1] and len(logged) == 2
    assert node.trigger_cleanup() == node.trigger_configure() == TransitionCallbackReturn.SUCCESS
    assert node.trigger_activate() == TransitionCallbackReturn.SUCCESS and wait_until(lambda: node.is_ready)
    node.take_image(label_image(picture), time.time_ns())
    assert node.counters.objects == 1
    assert statuses(node, monkeypatch)["recognition"].level == DiagnosticStatus.OK


def test_a_node_that_runs_without_a_recognizer_says_so_and_heals_with_a_change(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert node.trigger_deactivate() == node.trigger_cleanup() == TransitionCallbackReturn.SUCCESS
    with monkeypatch.context() as patch:
        building = gate(patch, Setup, "build")
        building._function = lambda *_, **__: 1 / 0
        assert node.trigger_configure() == node.trigger_activate() == TransitionCallbackReturn.SUCCESS
        building.go_on.set()
        assert wait_until(lambda: bool(node._pipeline.problem))
        node.take_image(label_image(picture), time.time_ns())
        found = statuses(node, monkeypatch)
        assert found["input"].level == found["recognition"].level == DiagnosticStatus.ERROR
        assert "1 image(s) dropped: there is no recogniser" in found["input"].message
        assert "ZeroDivisionError" in found["recognition"].message
    assert node.set_parameters([Parameter("recognizer.min_match", value=0.5)])[0].successful
    assert wait_until(lambda: node.is_ready) and not node._pipeline.problem
    node.take_image(label_image(picture), time.time_ns())
    assert node.counters.objects == 1


def test_parameters_that_cannot_be_used_are_told_of_while_the_old_ones_work(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Setup, "build", lambda *_, **__: 1 / 0)
    assert node.set_parameters([Parameter("recognizer.min_match", value=0.5)])[0].successful
    assert wait_until(lambda: bool(node._pipeline.problem)) and node.is_ready
    node.take_image(label_image(picture), time.time_ns())
    status = statuses(node, monkeypatch)["recognition"]
    assert node.counters.objects == 1 and status.level == DiagnosticStatus.ERROR
    assert "the parameters are not in use: internal error: ZeroDivisionError" in status.message


def test_of_changes_that_come_faster_than_they_are_built_the_last_one_stays(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    building = gate(monkeypatch, Setup, "build")
    values = [0.5 + i / 100 for i in range(10)]
    for value in values:
        assert node.set_parameters([Parameter("recognizer.min_match", value=value)])[0].successful
        assert building.begun.wait(WAIT_S)
    building.go_on.set()
    assert wait_until(lambda: node._pipeline._current[0].recognizer.min_match == values[-1])
    assert building.calls == 2


def test_what_the_recognizer_has_no_part_in_builds_none(node: RecognizerNode, monkeypatch: pytest.MonkeyPatch) -> None:
    building = gate(monkeypatch, Setup, "build")
    assert node.set_parameters([Parameter("tracking.max_gap_s", value=0.25)])[0].successful
    assert wait_until(lambda: node._pipeline._current[0].tracking.max_gap_s == 0.25)
    assert building.calls == 0
