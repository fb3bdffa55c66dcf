"""Somebody beside the robot's nodes: a node of its own, spun in a thread, that others of the process ask through."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Sequence
from typing import Any

import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.expand_topic_name import expand_topic_name
from rclpy.task import Future
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_topic_name import validate_topic_name

from ..core.base.errors import SourceError
from .log_folder import check_log_folder

_TURN_S = 0.1
_PATIENCE_S = 5.0


def check_topic(name: str, given: str) -> None:
    """:param given: where the user wrote it. :raises SourceError: no topic can be called so."""
    try:
        validate_topic_name(name)
        validate_full_topic_name(expand_topic_name(name, "node", "/"))
    except (InvalidTopicNameException, ValueError) as error:
        raise SourceError(f"{given}: '{name}' is no topic: {' '.join(str(error).split())}") from None


class Graph:
    """A node in a context of its own; `close` takes both down.

    :ivar node: what subscriptions and clients are made on; its callbacks come in the thread.
    """

    def __init__(self, name: str, remappings: Sequence[str] = ()) -> None:
        """:param name: the process' number goes behind it. :param remappings: rules such as image:=/camera/image.
        :raises ConfigError: ROS cannot write its log."""
        check_log_folder()
        self._since_s = time.monotonic()
        self._context = rclpy.Context()
        self._context.init(args=[])
        rules = [word for rule in remappings for word in ("-r", rule)]
        self.node = rclpy.create_node(
            f"{name}_{os.getpid()}",
            context=self._context,
            cli_args=["--ros-args", *rules] if rules else [],
            start_parameter_services=False,
            enable_rosout=False,
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._open = True
        self._thread = threading.Thread(target=self._spin, name=name, daemon=True)
        self._thread.start()

    @property
    def age_s(self) -> float:
        """How long it has been part of the graph: who was there before is not known at once."""
        return time.monotonic() - self._since_s

    def close(self) -> None:
        """Ends the thread, then the node."""
        self._open = False
        self._thread.join(_PATIENCE_S)
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()

    def _spin(self) -> None:
        while self._open and self._context.ok():
            try:
                self._executor.spin_once(timeout_sec=_TURN_S)
            except ExternalShutdownException:
                return
            except Exception as error:  # of one callback; the others go on
                self.node.get_logger().error(f"a callback failed: {error!r}", throttle_duration_sec=5.0)

    def answers(self, asked: Sequence[tuple[type, str, Any]], timeout_s: float) -> list[Any]:
        """Calls services, all at once. Returns each one's answer, None where it came not in time.

        :param asked: type, name and request of each.
        """
        clients = [self.node.create_client(kind, name) for kind, name, _ in asked]
        try:
            end_s = time.monotonic() + timeout_s
            while time.monotonic() < end_s and not all(c.service_is_ready() for c in clients):
                time.sleep(_TURN_S / 10)
            calls = [
                c.call_async(request) if c.service_is_ready() else None
                for c, (*_, request) in zip(clients, asked, strict=True)
            ]
            return [_result(call, end_s) for call in calls]
        finally:
            for client in clients:
                self.node.destroy_client(client)


def _result(call: Future | None, end_s: float) -> Any:
    """What a call brings until the end; None: nothing."""
    while call is not None and not call.done() and time.monotonic() < end_s:
        time.sleep(_TURN_S / 20)
    return call.result() if call is not None and call.done() else None
