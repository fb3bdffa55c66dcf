"""Setting what was tried in the studio on a node that runs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy")
from peer import STARTED, NodeProcess, Peer, ros, wait_until

from artrec_ros.core.base.errors import SourceError
from artrec_ros.io.parameters.parameter_file import Setup, load_parameters
from artrec_ros.node import remote_parameters
from artrec_ros.node.graph import Graph
from artrec_ros.node.remote_parameters import RemoteParameters
from artrec_ros.tools.studio_state.running_nodes import differences, set_on_node

NODE = "/left/finder"


@pytest.fixture(scope="module")
def node(
    ros_environment: None, compiled: None, parameter_file: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[NodeProcess]:
    """A node that has another name than usual."""
    arguments = ros(parameter_file, "-r", "__ns:=/left", "-r", "__node:=finder")
    with NodeProcess(*arguments, log=tmp_path_factory.mktemp("node") / "log") as process:
        process.wait_for_output(STARTED)
        yield process


@pytest.fixture
def remote(ros_environment: None) -> Iterator[RemoteParameters]:
    graph = Graph("asker")
    yield RemoteParameters(graph)
    graph.close()


def changed(parameter_file: Path, **changes: object) -> Setup:
    return load_parameters(parameter_file).changed({f"recognizer.{name}": v for name, v in changes.items()})


def found_by(remote: RemoteParameters) -> list[str]:
    """The nodes, when discovery has come so far."""
    found: list[str] = wait_until(remote.nodes)
    return found


def test_recogniser_nodes_are_known_by_their_parameters(node: NodeProcess, remote: RemoteParameters) -> None:
    with Peer():  # which has parameter services, too
        assert found_by(remote) == [NODE]


def test_a_graph_that_has_just_begun_waits_for_who_was_there_before(node: NodeProcess, ros_environment: None) -> None:
    """The first press of Find found nobody: discovery takes longer than a call."""
    graph = Graph("newcomer")
    try:
        assert RemoteParameters(graph).nodes() == [NODE]
    finally:
        graph.close()


def test_what_differs_is_told_and_set(node: NodeProcess, remote: RemoteParameters, parameter_file: Path) -> None:
    assert found_by(remote)
    same = load_parameters(parameter_file)
    set_on_node(differences(same, remote, NODE), remote, NODE)
    assert differences(same, remote, NODE) == []
    setup = changed(parameter_file, min_probability=0.61, time_budget_ms=900)
    setup = setup.changed({"publish_tf": True, "image.blank": [1, 2, 3, 4]})
    found = differences(setup, remote, NODE)
    told = {d.spec.name: (d.here, d.there, d.is_live) for d in found}
    assert told == {
        "image.blank": ([1, 2, 3, 4], [], True),
        "recognizer.min_probability": (0.61, same.recognizer.min_probability, True),
        "recognizer.time_budget_ms": (900.0, 2000.0, True),
        "publish_tf": (True, False, False),
    }
    assert [d.is_live for d in found] == [True, True, True, False]
    assert set_on_node(found, remote, NODE) == {}
    (left,) = differences(setup, remote, NODE)
    assert left.spec.name == "publish_tf"


def test_two_that_fit_together_are_set_whatever_their_order(
    node: NodeProcess, remote: RemoteParameters, parameter_file: Path
) -> None:
    assert found_by(remote)
    for low, high in ((10.0, 20.0), (100.0, 200.0), (1.0, 2.0)):
        found = differences(changed(parameter_file, min_scale=low, max_scale=high), remote, NODE)
        assert {"recognizer.min_scale", "recognizer.max_scale"} <= {d.spec.name for d in found}
        assert set_on_node(found, remote, NODE) == {}
    assert remote.values(NODE, ["recognizer.min_scale", "recognizer.max_scale", "no.such"]) == {
        "recognizer.min_scale": 1.0,
        "recognizer.max_scale": 2.0,
    }


def test_what_the_node_refuses_is_told_with_its_reason(
    node: NodeProcess, remote: RemoteParameters, parameter_file: Path
) -> None:
    assert found_by(remote)
    setup = changed(parameter_file, min_probability=0.33).changed({"expert.alignment.coarse_keep": 9})
    found = differences(setup, remote, NODE)
    refused = set_on_node(found, remote, NODE)
    assert (
        refused.keys() == {"expert.alignment.coarse_keep"}
        and "only where it was given at the start" in refused["expert.alignment.coarse_keep"]
    )
    assert remote.values(NODE, ["recognizer.min_probability"]) == {"recognizer.min_probability": 0.33}


def test_a_node_that_is_gone_is_told(remote: RemoteParameters, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remote_parameters, "_PATIENCE_S", 0.3)
    with pytest.raises(SourceError, match="node /gone does not answer within 0.3 s"):
        remote.values("/gone", ["objects"])
