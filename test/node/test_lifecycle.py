"""The node's states, and several nodes in one process."""

from __future__ import annotations

import sys
import time
import types
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import numpy as np
import rclpy
import toy
from geometry_msgs.msg import PoseArray, TransformStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from peer import NodeProcess, Peer, label_image, ros, wait_until
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import TransitionCallbackReturn
from visualization_msgs.msg import Marker, MarkerArray

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.node.node import RecognizerNode

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


@pytest.fixture
def make(parameter_file: Path) -> Iterator[Callable[..., RecognizerNode]]:
    """Nodes in this process, in a context of their own."""
    context = rclpy.Context()
    context.init()
    made: list[RecognizerNode] = []

    def node(*more: str, file: Path = parameter_file) -> RecognizerNode:
        arguments = ros(file, *more)
        made.append(RecognizerNode(arguments, cli_args=arguments, context=context))
        return made[-1]

    yield node
    for each in made:
        each.destroy_node()
    context.try_shutdown()


def topics(node: RecognizerNode) -> set[str]:
    return {s.topic_name for s in node.subscriptions} & {"/image", "/camera_info"}


def test_it_subscribes_while_active_only(make: Callable[..., RecognizerNode], picture: np.ndarray) -> None:
    node = make("-p", "autostart:=false")
    node.autostart()
    assert not topics(node)
    node.take_image(label_image(picture), time.time_ns())
    assert node.counters.processed == 0, "an unconfigured node does nothing"
    assert node.trigger_configure() == SUCCESS and not topics(node)
    assert node.trigger_activate() == SUCCESS and topics(node) == {"/image", "/camera_info"}
    assert wait_until(lambda: node.is_ready)
    node.take_image(label_image(picture), time.time_ns())
    assert node.counters.objects == 1
    assert node.trigger_deactivate() == SUCCESS and not topics(node)
    assert node.trigger_cleanup() == SUCCESS
    assert "markers" not in [p.topic_name.strip("/") for p in node.publishers]
    assert node.trigger_configure() == node.trigger_activate() == SUCCESS and wait_until(lambda: node.is_ready)
    node.take_image(label_image(picture), time.time_ns())
    assert node.counters.objects == 2
    assert node.trigger_shutdown() == SUCCESS and not topics(node)


def test_a_destroyed_node_is_gone_from_the_graph(make: Callable[..., RecognizerNode]) -> None:
    """Whoever still holds it: in a process of several nodes the others go on."""
    node = make()
    node.autostart()
    with Peer("unused") as peer:
        assert peer.spin_until(lambda: ("artrec_node", "/") in peer.node.get_node_names_and_namespaces())
        node.destroy_node()
        assert peer.spin_until(lambda: ("artrec_node", "/") not in peer.node.get_node_names_and_namespaces())


def test_configuring_reads_the_files_anew_and_may_fail(make: Callable[..., RecognizerNode], tmp_path: Path) -> None:
    file = toy.write_files(tmp_path / "config")
    node = make("-p", "autostart:=false", file=file)
    content = (tmp_path / "config/objects/toy.yaml").read_text()
    (tmp_path / "config/objects/toy.yaml").write_text(content.replace("required: true", "required: maybe"))
    assert node.trigger_configure() == FAILURE
    (tmp_path / "config/objects/toy.yaml").write_text(content)
    assert node.trigger_configure() == SUCCESS


def test_what_cannot_start_says_why(make: Callable[..., RecognizerNode], tmp_path: Path) -> None:
    file = toy.write_files(tmp_path / "config")
    node = make(file=file)
    (tmp_path / "config/objects/toy.yaml").unlink()
    with pytest.raises(ConfigError, match="there is no file.*toy.yaml"):
        node.autostart()


def test_two_nodes_share_a_process_and_keep_apart(make: Callable[..., RecognizerNode], picture: np.ndarray) -> None:
    """Deactivating one deletes its markers, and leaves the other alone."""
    left, right = (make("-r", f"__ns:=/{side}") for side in ("left", "right"))
    executor = SingleThreadedExecutor(context=left.context)
    for node in (left, right):
        node.autostart()
        executor.add_node(node)
    with Peer("unused") as peer:
        for side in ("left", "right"):
            peer.listen(f"/{side}/markers", MarkerArray)
        heard = {side: peer.heard[f"/{side}/markers"] for side in ("left", "right")}
        assert peer.spin_until(lambda: all(peer.node.count_publishers(t) for t in peer.heard))
        message, calibration = label_image(picture), toy.camera_info()
        message.header.frame_id = "eye"

        def shown() -> bool:
            for node in (left, right):
                node.take_camera_info(calibration)
                node.take_image(message, time.time_ns())
            return all(heard.values())

        assert peer.spin_until(shown)
        peer.forget()
        assert left.trigger_deactivate() == SUCCESS
        deleted = {Marker.DELETE}
        assert peer.spin_until(lambda: heard["left"] and {m.action for m in heard["left"][-1].markers} == deleted)
        assert topics(left) == set() and len(list(right.subscriptions)) == 2
    executor.shutdown()


@pytest.mark.parametrize("installed", [True, False])
def test_tf_gets_the_objects_where_it_is_installed(
    installed: bool, make: Callable[..., RecognizerNode], picture: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[TransformStamped] = []
    broadcaster = types.SimpleNamespace(sendTransform=sent.extend)
    stand_in = types.SimpleNamespace(TransformBroadcaster=lambda node: broadcaster)
    monkeypatch.setitem(sys.modules, "tf2_ros", stand_in if installed else None)
    node = make("-p", "publish_tf:=true", "-r", "__ns:=/left")
    node.autostart()
    assert wait_until(lambda: node.is_ready)
    node.take_camera_info(toy.camera_info())
    message = label_image(picture)
    message.header.frame_id = "eye"
    node.take_image(message, time.time_ns())
    assert node.counters.objects == 1 and not node.counters.failed
    found = [(t.header.frame_id, t.child_frame_id.rpartition("_")[0]) for t in sent]
    assert found == ([("eye", "left/toy")] if installed else [])


def test_a_lifecycle_manager_starts_and_stops_it(parameter_file: Path, picture: np.ndarray, tmp_path: Path) -> None:
    """Over the wire, with the services that such managers use."""
    arguments = ros(parameter_file, "-p", "autostart:=false")
    with NodeProcess(*arguments, log=tmp_path / "log") as process, Peer() as peer:
        process.wait_for_output("waiting for a lifecycle manager")
        assert "not active" in peer.diagnose("input", "not active").message

        def change(transition: int) -> bool:
            request = ChangeState.Request(transition=Transition(id=transition))
            return bool(peer.call(ChangeState, "change_state", request).success)

        assert not change(Transition.TRANSITION_ACTIVATE), "configure comes first"
        assert "(3) refused: the node is unconfigured; possible: configure, shutdown" in process.output
        assert change(Transition.TRANSITION_CONFIGURE) and change(Transition.TRANSITION_ACTIVATE)
        peer.listen("toy/poses", PoseArray)
        peer.connect(label_image(picture))
        assert change(Transition.TRANSITION_DEACTIVATE)
        assert peer.diagnose("input", "not active")
        assert process.running and "Traceback" not in process.output


def test_what_cannot_be_found_for_want_of_constraints_is_warned_of(
    make: Callable[..., RecognizerNode], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = toy.write_files(tmp_path / "config")  # of its own: the others share theirs
    file.write_text(file.read_text().replace("constraint_file: constraints/toy.yaml, ", ""))
    model = file.parent / "objects" / "toy.yaml"
    model.write_text(model.read_text().replace("lever: {pose: {xyz: [0.02, 0, 0]}}", "lever: {}"))
    node, warned = make("-p", "autostart:=false", file=file), []
    logger = types.SimpleNamespace(info=lambda _: None, error=lambda _: None, warning=warned.append)
    monkeypatch.setattr(node, "get_logger", lambda: logger)
    assert node.trigger_configure() == SUCCESS
    (line,) = warned
    assert line.startswith("toy: will not be found: it has no constraint_file") and "toy.constraint_file" in line
