"""What the node listens to: images, the newest of them, and calibrations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rclpy.node import Node

from ..core.base.config import NodeConfig
from ..io.messages import node_topics as topics
from .calibration import NONE_RECEIVED
from .conversions import stamp_ns
from .subscription import FollowingSubscription
from .worker import LiveQueue

_SUFFIX = "/compressed"


class LiveImage(NamedTuple):
    """An image message, when it was received, and what was made of it while it waited."""

    msg: Any
    received_ns: int
    ahead: Any = None


class Inputs:
    """Calls `on_camera_info(message)` in the executor's thread, and `on_image(image)` in another."""

    def __init__(
        self,
        node: Node,
        config: NodeConfig,
        on_camera_info: Callable[[Any], None],
        on_image: Callable[[LiveImage], None],
        look_ahead: Callable[[Any], Any] | None = None,
    ) -> None:
        """:param look_ahead: makes of the message of an image that waits what `LiveImage.ahead` is to be, in a third
        thread."""
        self._node = node
        compressed = config.image_transport == "compressed"
        of = topics.COMPRESSED if compressed else topics.IMAGE
        # as image_transport does: a remapped `image` takes the suffix along
        topic = node.resolve_topic_name(topics.IMAGE.name) + (_SUFFIX if compressed else "")
        prepare = None if look_ahead is None else lambda image: image._replace(ahead=look_ahead(image.msg))
        self._worker = LiveQueue[LiveImage](on_image, f"{node.get_name()} images", config.queue_size, prepare)
        info = topics.CAMERA_INFO
        self._camera_info = FollowingSubscription(  # before images: of what waits, calibrations come first
            node, info.type, info.name, lambda msg, _: on_camera_info(msg), depth=info.depth, may_repeat=True
        )
        self.image = FollowingSubscription(
            node,
            of.type,
            topic,
            lambda msg, received_ns: self._worker.offer(LiveImage(msg, received_ns), stamp_ns(msg.header)),
            depth=of.depth,
            reliability=config.qos_reliability,
        )

    @property
    def dropped(self) -> int:
        """Images that newer ones replaced before they were looked at."""
        return self._worker.dropped

    @property
    def is_late(self) -> bool:
        """Whether a newer image waits while one is looked at, or images come faster than they can be looked at."""
        return self._worker.is_late

    def answered(self) -> None:
        """What the image shows that is looked at is about to be published."""
        self._worker.answered()

    @property
    def busy_s(self) -> float:
        """Since when one image is looked at; 0: none is."""
        return self._worker.busy_s

    @property
    def wrong_type(self) -> str:
        """Of whoever publishes something else than images of this transport as images, and the way out; else empty."""
        image, other = self.image, self.image.other_type
        if not other:
            return ""
        base = image.topic.removesuffix(_SUFFIX)
        ways = {
            topics.IMAGE.type: f"set image_transport: raw, and remap image to {image.topic}",
            topics.COMPRESSED.type: "set image_transport: compressed, and remap "
            + (f"image/compressed, not image, to {base}" if base == image.topic else f"image to {base}"),
        }
        return f"{image.topic} is {other}, not {image.type}: {ways.get(other, 'take another topic')}"

    def uncalibrated(self, problem: str) -> str:
        """`Calibrations.problem`, with what is known of the topic where nothing has come from there."""
        info = self._camera_info
        if problem != NONE_RECEIVED:
            return problem
        if not info.publishers:
            return f"{problem}: nobody publishes {info.topic}"
        if info.other_type:
            return f"{problem}: {info.topic} is {info.other_type}, not {info.type}"
        return f"{problem}: {info.publishers} publisher(s) of {info.topic} sent none"

    def follow(self) -> None:
        """Look at the publishers: they may have come, gone or changed."""
        before = self.wrong_type
        self._camera_info.follow()
        self.image.follow()
        if self.wrong_type not in ("", before):
            self._node.get_logger().warning(self.wrong_type)

    def end(self) -> None:
        """Hand on no more images."""
        self._worker.end()

    def close(self) -> None:
        self.image.close()
        self._camera_info.close()
        self._worker.close()
