"""A subscription whose quality of service follows its publishers, and that counts what got lost on the way."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSCompatibility, QoSProfile, ReliabilityPolicy, qos_check_compatible

from .conversions import message_class

RELIABILITY = {"reliable": ReliabilityPolicy.RELIABLE, "best_effort": ReliabilityPolicy.BEST_EFFORT}


class FollowingSubscription:
    """Hands each message to `receive(message, received_ns)`; received_ns is the system clock's: when it arrived, or
    where the middleware does not tell, when it is handed on.

    :param message_type: such as sensor_msgs/msg/Image.
    :param reliability: 'auto': as the publishers offer; else 'reliable' or 'best_effort'.
    :param may_repeat: a message may be handed on twice: then latched ones are heard beside a publisher that is not so.
    :ivar lost: messages that were sent and never handed on, by the publisher's numbering (with one publisher only).
    :ivar incompatible: which publisher offers what does not fit; empty where all fits; as of the last `follow`.
    :ivar publishers: how many there are on the topic, compatible or not; as of the last `follow`.
    :ivar other_type: of a publisher that sends other messages, which are not heard; empty: none does. The same.
    """

    def __init__(
        self,
        node: Node,
        message_type: str,
        topic: str,
        receive: Callable[[Any, int], None],
        *,
        depth: int = 1,
        reliability: str = "auto",
        may_repeat: bool = False,
    ) -> None:
        self._node, self._receive = node, receive
        self.type, self.other_type = message_type, ""
        self.topic = node.resolve_topic_name(topic)
        self._asked = reliability
        self.lost, self.incompatible, self.publishers = 0, "", 0
        self._depth, self._may_repeat = depth, may_repeat
        self._last_number: int | None = None
        self._known: frozenset[bytes] = frozenset()
        self._qos = [(RELIABILITY.get(reliability, ReliabilityPolicy.BEST_EFFORT), DurabilityPolicy.VOLATILE)]
        self._subscriptions = self._subscribe()

    def close(self) -> None:
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)

    def follow(self) -> None:
        """Look at the publishers, and subscribe anew where they offer another quality than is asked for.

        A best-effort subscription hears every publisher but loses large messages; a reliable one hears none that is
        best-effort; only a transient-local one gets what was sent before it began. So the stronger quality is right
        where all publishers offer it; where some are latched, a second subscription hears what these have sent.
        """
        offered = self._node.get_publishers_info_by_topic(self.topic)
        self.publishers = len(offered)
        self.other_type = next((p.topic_type for p in offered if p.topic_type != self.type), "")
        offered = [p for p in offered if p.topic_type == self.type]
        present = frozenset(bytes(p.endpoint_gid) for p in offered)
        if present != self._known:  # a new publisher numbers from its own beginning
            self._known, self._last_number = present, None
        if offered and self._asked == "auto":
            self._ask_as(offered)
        self._tell_incompatible(offered)

    def _ask_as(self, offered: Sequence[Any]) -> None:
        reliable = all(p.qos_profile.reliability == ReliabilityPolicy.RELIABLE for p in offered)
        latched = [p.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in offered]
        reliability = ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT
        qos = [(reliability, DurabilityPolicy.TRANSIENT_LOCAL if all(latched) else DurabilityPolicy.VOLATILE)]
        if self._may_repeat and any(latched) and not all(latched):
            qos.append((ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL))
        if qos != self._qos:
            self._qos = qos
            self.close()
            self._subscriptions = self._subscribe()
            names = ", and ".join(" and ".join(policy.name.lower() for policy in policies) for policies in qos)
            self._node.get_logger().info(f"{self.topic}: subscribed {names}, as its publishers offer")

    def _subscribe(self) -> list[Any]:
        self._last_number = None
        # no event handlers: each costs every turn of the executor time, and none tells that a publisher has gone
        events = SubscriptionEventCallbacks(use_default_callbacks=False)
        kind, hear = message_class(self.type), self._on_message
        return [
            self._node.create_subscription(kind, self.topic, hear, profile, event_callbacks=events)
            for profile in self._profiles()
        ]

    def _profiles(self) -> list[QoSProfile]:
        return [QoSProfile(depth=self._depth, reliability=r, durability=d) for r, d in self._qos]

    def _on_message(self, msg: Any, info: dict[str, Any]) -> None:
        number = info.get("publication_sequence_number")
        if number is not None and self._last_number is not None and self.publishers == 1:
            self.lost += max(0, int(number) - self._last_number - 1)
        self._last_number = None if number is None else int(number)
        # CycloneDDS does not say when a message came, but 0: then it is now
        self._receive(msg, int(info["received_timestamp"]) or time.time_ns())

    def _tell_incompatible(self, offered: Sequence[Any]) -> None:
        """Name a publisher that cannot be heard, while it is there."""
        before, self.incompatible = self.incompatible, ""
        for publisher in offered:
            compatible, reason = qos_check_compatible(publisher.qos_profile, self._profiles()[0])
            if compatible == QoSCompatibility.ERROR:
                self.incompatible = f"{publisher.node_name} cannot be heard: {reason.rstrip(';')}"
        if self.incompatible and self.incompatible != before:
            self._node.get_logger().warning(f"{self.topic}: {self.incompatible}. Set qos_reliability: auto")
