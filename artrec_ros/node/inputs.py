"""What the node listens to: images, the newest of them, and calibrations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from ..core.base.config import NodeConfig
from ..io.messages import node_topics as topics
from .conversions import message_class
from .subscription import FollowingSubscription
from .worker import LiveQueue


class Inputs:
    """Calls `on_camera_info(message)` in the executor's thread, and `on_image(message, received_ns)` in another."""

    def __init__(
        self,
        node: Node,
        config: NodeConfig,
        on_camera_info: Callable[[Any], None],
        on_image: Callable[[Any, int], None],
    ) -> None:
        compressed = config.image_transport == "compressed"
        of = topics.COMPRESSED if compressed else topics.IMAGE
        # as image_transport does: a remapped `image` takes the suffix along
        topic = node.resolve_topic_name(topics.IMAGE.name) + ("/compressed" if compressed else "")
        self._worker = LiveQueue[tuple[Any, int]](
            lambda item: on_image(*item), f"{node.get_name()} images", config.queue_size
        )
        info = topics.CAMERA_INFO
        self._camera_info = FollowingSubscription(  # before images: of what waits, calibrations come first
            node, message_class(info.type), info.name, lambda msg, _: on_camera_info(msg), depth=info.depth
        )
        self.image = FollowingSubscription(
            node,
            message_class(of.type),
            topic,
            lambda msg, received_ns: self._worker.offer((msg, received_ns)),
            depth=of.depth,
            reliability=config.qos_reliability,
        )

    @property
    def dropped(self) -> int:
        """Images that newer ones replaced before they were looked at."""
        return self._worker.dropped

    @property
    def busy_s(self) -> float:
        """Since when one image is looked at; 0: none is."""
        return self._worker.busy_s

    def follow(self) -> None:
        """Look at the publishers: they may have come, gone or changed."""
        self._camera_info.follow()
        self.image.follow()

    def close(self) -> None:
        self.image.close()
        self._camera_info.close()
        self._worker.close()
