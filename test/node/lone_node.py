"""A node in this process that nothing spins, and what holds up its parts."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from peer import WAIT_S, label_image, ros, wait_until
from rclpy.lifecycle import TransitionCallbackReturn

from artrec_ros.io.parameters.parameter_file import Setup
from artrec_ros.node.node import RecognizerNode


@contextmanager
def alone(parameter_file: Path, *more: str) -> Iterator[RecognizerNode]:
    """An active node in this process; nothing spins it, images are handed to it. :param more: arguments of ROS."""
    context = rclpy.Context()
    context.init()
    arguments = ros(parameter_file, *more, "-r", "__ns:=/alone")
    node = RecognizerNode(arguments, cli_args=arguments, context=context)
    node.autostart()
    assert wait_until(lambda: node.is_ready)
    yield node
    node.destroy_node()
    context.try_shutdown()


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
