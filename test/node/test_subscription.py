"""When a message came, as middlewares tell it."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from artrec_ros.node.subscription import FollowingSubscription


class _Node:
    """What a subscription asks of a node; `send` is the middleware's side."""

    send: Any

    def resolve_topic_name(self, topic: str) -> str:
        return f"/{topic}"

    def create_subscription(self, kind: type, topic: str, hear: Any, qos: Any, *, event_callbacks: Any) -> object:
        self.send = hear
        return SimpleNamespace()


def test_a_message_comes_when_the_middleware_says_or_now_where_it_does_not() -> None:
    node, received = _Node(), list[tuple[Any, int]]()
    FollowingSubscription(node, "sensor_msgs/msg/Image", "image", lambda *both: received.append(both))  # type: ignore[arg-type]
    node.send("first", {"received_timestamp": 17, "publication_sequence_number": 1})
    before = time.time_ns()
    node.send("second", {"received_timestamp": 0, "publication_sequence_number": 2})
    assert received[0] == ("first", 17)
    assert received[1][0] == "second" and before <= received[1][1] <= time.time_ns()
