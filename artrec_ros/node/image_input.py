"""The image subscription: quality of service as its publishers offer it, the newest image only, losses counted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage, Image

from ..core.config import NodeConfig

_POLICIES = {"reliable": ReliabilityPolicy.RELIABLE, "best_effort": ReliabilityPolicy.BEST_EFFORT}


class ImageInput:
    """Subscribes to images and hands each to `on_image(message, received_ns)`.

    The queue holds one image: while one is processed, a newer one replaces the one that waits. `dropped` counts
    those that were sent and never handed on, by the publisher's numbering.
    """

    def __init__(self, node: Node, config: NodeConfig, on_image: Callable[[Any, int], None]) -> None:
        self._node = node
        self._on_image = on_image
        self._reliability = config.qos_reliability
        self._type = CompressedImage if config.image_transport == "compressed" else Image
        # as image_transport does: a remapped `image` takes the suffix along
        base = node.resolve_topic_name("image")
        self.topic = f"{base}/compressed" if config.image_transport == "compressed" else base
        self.dropped = 0
        self.incompatible = ""
        self._last_number: int | None = None
        self._policy = _POLICIES.get(self._reliability, ReliabilityPolicy.BEST_EFFORT)
        self._subscription = self._subscribe()

    def _subscribe(self) -> Any:
        self._last_number, self.incompatible = None, ""
        events = SubscriptionEventCallbacks(incompatible_qos=self._on_incompatible)
        qos = QoSProfile(depth=1, reliability=self._policy)
        return self._node.create_subscription(self._type, self.topic, self._receive, qos, event_callbacks=events)

    def publishers(self) -> int:
        """How many publishers there are on the topic, compatible or not."""
        return len(self._node.get_publishers_info_by_topic(self.topic))

    def follow_publishers(self) -> None:
        """Subscribe anew where the publishers offer another reliability than is asked for.

        A best-effort subscription hears every publisher but loses large images; a reliable one hears none that is
        best-effort. So reliable is right where all publishers are.
        """
        if self._reliability != "auto":
            return
        offered = [p.qos_profile.reliability for p in self._node.get_publishers_info_by_topic(self.topic)]
        if not offered:
            return
        reliable = all(r == ReliabilityPolicy.RELIABLE for r in offered)
        policy = ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT
        if policy == self._policy:
            return
        self._policy = policy
        self._node.destroy_subscription(self._subscription)
        self._subscription = self._subscribe()
        self._node.get_logger().info(f"{self.topic}: subscribed {policy.name.lower()}, as its publishers offer")

    def _receive(self, msg: Any, info: dict[str, Any]) -> None:
        number = info.get("publication_sequence_number")
        if number is not None and self._last_number is not None and self.publishers() == 1:
            self.dropped += max(0, int(number) - self._last_number - 1)
        self._last_number = None if number is None else int(number)
        self._on_image(msg, int(info["received_timestamp"]))

    def _on_incompatible(self, event: Any) -> None:
        policy = getattr(event.last_policy_kind, "name", str(event.last_policy_kind)).lower()
        self.incompatible = f"a publisher offers another {policy} than is asked for"
        self._node.get_logger().warning(
            f"{self.topic}: {self.incompatible}; its images cannot be received. Set qos_reliability: auto",
            throttle_duration_sec=10.0,
        )
