"""One image after the other, whoever brings it, and parameters that change meanwhile."""

from __future__ import annotations

import threading
import time
import types
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import numpy as np
import rclpy
import toy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseArray
from peer import WAIT_S, Peer, label_image, ros, wait_until
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo
from visualization_msgs.msg import MarkerArray

from artrec_ros.core.base import kernel_cache
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.parameters.parameter_file import Setup
from artrec_ros.node import pipeline, publishers, worker
from artrec_ros.node.conversions import to_ros
from artrec_ros.node.inputs import Inputs
from artrec_ros.node.node import RecognizerNode


@contextmanager
def alone(parameter_file: Path) -> Iterator[RecognizerNode]:
    """An active node in this process; nothing spins it, images are handed to it."""
    context = rclpy.Context()
    context.init()
    arguments = ros(parameter_file, "-r", "__ns:=/alone")
    node = RecognizerNode(arguments, cli_args=arguments, context=context)
    node.autostart()
    assert wait_until(lambda: node.is_ready)
    yield node
    node.destroy_node()
    context.try_shutdown()


@pytest.fixture
def node(parameter_file: Path) -> Iterator[RecognizerNode]:
    with alone(parameter_file) as node:
        yield node


class Gate:
    """Takes a function's place: tells that it is called, and holds it up until it may go on."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self._lock = threading.Lock()
        self.begun, self.go_on = threading.Event(), threading.Event()
        self.calls = self.inside = self.most_inside = 0

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        with self._lock:
            self.calls, self.inside = self.calls + 1, self.inside + 1
            self.most_inside = max(self.most_inside, self.inside)
        self.begun.set()
        assert self.go_on.wait(WAIT_S)
        try:
            return self._function(*arguments, **named)
        finally:
            with self._lock:
                self.inside -= 1


def gate(monkeypatch: pytest.MonkeyPatch, owner: type, name: str) -> Gate:
    made = Gate(getattr(owner, name))
    # a function, so that it is a method
    monkeypatch.setattr(owner, name, lambda *arguments, **named: made(*arguments, **named))
    return made


def getting_ready(node: RecognizerNode, monkeypatch: pytest.MonkeyPatch) -> Gate:
    """The node begins anew; its recogniser is there once the gate opens."""
    assert node.trigger_deactivate() == node.trigger_cleanup() == TransitionCallbackReturn.SUCCESS
    building = gate(monkeypatch, Setup, "build")
    assert node.trigger_configure() == node.trigger_activate() == TransitionCallbackReturn.SUCCESS
    assert building.begun.wait(WAIT_S)
    return building


def statuses(node: RecognizerNode, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the node reports now, by the part that it reports of."""
    said: list[Any] = []
    monkeypatch.setattr(node._diagnostics_out, "publish", said.append)
    node._report()
    return {s.name.rpartition(" ")[2]: s for s in said[-1].status}


def start(node: RecognizerNode, picture: np.ndarray) -> threading.Thread:
    thread = threading.Thread(target=node.take_image, args=(label_image(picture), time.time_ns()))
    thread.start()
    return thread


def test_a_frame_that_outlives_deactivation_is_not_published_and_shares_nothing(
    node: RecognizerNode, picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker, "_PATIENCE_S", 0.01)
    recognition = gate(monkeypatch, Recognizer, "recognize")
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
