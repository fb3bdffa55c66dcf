"""`ros2 param dump`, by the calls that it makes: what the parameter file says comes back, and starts the same node."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import yaml
from peer import ROOT, STARTED, WAIT_S, NodeProcess, Peer, ros
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

from artrec_ros.io.parameters.parameter_file import load_parameters

SHIPPED = ROOT / "config" / "aibo.yaml"
STARTED_AIBO = STARTED.replace("toy", "red, blue")


@pytest.fixture(scope="module")
def dumped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file that `ros2 param dump /artrec_node` would write."""
    folder = tmp_path_factory.mktemp("dump")
    with NodeProcess(*ros(SHIPPED), log=folder / "log") as process, Peer() as peer:
        process.wait_for_output(STARTED_AIBO)
        values = dump(peer)
    (folder / "dump.yaml").write_text(yaml.dump(values, default_flow_style=False), encoding="utf-8")
    return folder / "dump.yaml"


def dump(peer: Peer) -> dict[str, Any]:
    """As ros2param does: the names of one call are those of the next, all at once; then dots become levels."""
    client = AsyncParameterClient(peer.node, "/artrec_node")
    assert client.wait_for_services(WAIT_S)
    names = sorted(answer(peer, client.list_parameters).result.names)
    values = [parameter_value_to_python(v) for v in answer(peer, partial(client.get_parameters, names)).values]
    nested: dict[str, Any] = {}
    for name, value in zip(names, values, strict=True):
        *levels, last = name.split(".")
        place = nested
        for level in levels:
            place = place.setdefault(level, {})
        place[last] = value if not hasattr(value, "tolist") else value.tolist()
    return {"/artrec_node": {"ros__parameters": nested}}


def answer(peer: Peer, ask: Callable[[], Any]) -> Any:
    """What a service answers, which is asked again: it may see the request before it sees where the answer goes, and
    then nobody hears it."""
    for _ in range(3):
        asked = ask()
        if peer.spin_until(asked.done):
            return asked.result()
    raise AssertionError("no answer")


def leaves(values: dict[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def parameters(path: Path) -> dict[str, Any]:
    ((_, node),) = yaml.safe_load(path.read_text(encoding="utf-8")).items()
    return dict(leaves(node["ros__parameters"]))


def test_what_the_file_says_comes_back(dumped: Path) -> None:
    given, found = parameters(SHIPPED), parameters(dumped)
    assert len(given) > 8 and len(found) > len(given)
    for name, value in given.items():
        if name.endswith("_file"):  # so that it can be read from anywhere
            assert Path(found[name]) == SHIPPED.parent / value
        else:
            assert (found[name], type(found[name])) == (value, type(value)), name
    assert not [name for name, value in found.items() if value is None], "each holds something"


def test_the_dump_is_a_parameter_file_of_the_same_node(dumped: Path) -> None:
    ros_own = {"use_sim_time": False, "start_type_description_service": True}
    assert load_parameters(dumped).resolved == load_parameters(SHIPPED).resolved | ros_own


def test_a_node_starts_from_its_dump(dumped: Path, tmp_path: Path) -> None:
    with NodeProcess(*ros(dumped), log=tmp_path / "log") as process, Peer() as peer:
        process.wait_for_output(STARTED_AIBO)
        assert yaml.safe_load(dumped.read_text(encoding="utf-8")) == dump(peer)
        assert "WARN" not in process.output, process.output
