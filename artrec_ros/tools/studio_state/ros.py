"""What the studio asks of a ROS graph. The node's package alone imports ROS: it is named here, and found when it is
called for, so that all else works without."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from ...core.base.errors import ArtrecError
from ...io.parameters.specs import Spec
from ...io.sources.frames import Frame

_NODE = "artrec_ros.node"


class Live(Protocol):
    """The last images of a topic: `node/live_images.py`."""

    topic: str
    graph: Any

    def held(self) -> tuple[Any, ...]: ...
    def frame(self, held: Any) -> Frame: ...
    def state(self) -> str: ...
    def wait(self, patience_s: float) -> None: ...
    def close(self) -> None: ...


class Remote(Protocol):
    """Parameters of nodes that run elsewhere: `node/remote_parameters.py`."""

    def nodes(self) -> list[str]: ...
    def values(self, node: str, names: Sequence[str]) -> dict[str, Any]: ...
    def set(self, node: str, values: Mapping[str, Any], specs: Mapping[str, Spec]) -> dict[str, str]: ...


class Ros:
    """A studio's part in the graph, taken when it is first needed."""

    def __init__(self) -> None:
        self._live: Live | None = None
        self._graph: Any = None
        self._lock = threading.Lock()  # several windows may ask first

    @property
    def live(self) -> Live | None:
        """The topic that is the source; None: it is none."""
        return self._live

    def listen(self, topic: str, camera_info_topic: str | None, rectified: bool, kept: int) -> Live:
        """:raises ArtrecError: there is no ROS here, or that is no topic."""
        self._live = _module("live_images").LiveImages(topic, camera_info_topic, rectified, kept)
        return self._live

    def parameters(self) -> Remote:
        """:raises ArtrecError: there is no ROS here."""
        module = _module("remote_parameters")
        if self._live is not None:
            return module.RemoteParameters(self._live.graph)
        with self._lock:
            if self._graph is None:
                self._graph = _module("graph").Graph("artrec_studio")
        return module.RemoteParameters(self._graph)

    def close(self) -> None:
        for part in (self._live, self._graph):
            if part is not None:
                part.close()


def _module(name: str) -> Any:
    """:raises ArtrecError: ROS is missing."""
    try:
        return importlib.import_module(f"{_NODE}.{name}")
    except ImportError as error:
        raise ArtrecError(importlib.import_module(f"{_NODE}.main").MISSING.format(error)) from error
