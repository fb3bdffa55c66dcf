"""Objects as tf frames, where tf2_ros is installed. Nothing else of the package needs it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rclpy.node import Node
from std_msgs.msg import Header

from ..core.model.found import Detection
from ..io.messages.detection_messages import object_frames
from .conversions import header_of, to_ros


class TransformSender:
    """Sends the frame of each object whose pose is known, as a child of that in which it is, mostly the image's.

    tf knows no namespaces, so a node's namespace goes before its frames' names: left/red_0.
    """

    def __init__(self, node: Node, broadcaster: Any) -> None:
        """:param broadcaster: tf2_ros.TransformBroadcaster, or what can send as it does."""
        self._broadcaster = broadcaster
        namespace = node.get_namespace().strip("/")
        self._prefix = f"{namespace}/" if namespace else ""

    def send(self, detections: Sequence[Detection], header: Header) -> None:
        frames = object_frames(detections, header.frame_id, header_of(header), self._prefix)
        if transforms := [to_ros(m) for m in frames]:
            self._broadcaster.sendTransform(transforms)


def transform_sender(node: Node) -> TransformSender | None:
    """What sends to tf; None, with a warning, where tf2_ros is missing."""
    try:
        from tf2_ros import TransformBroadcaster
    except ImportError as error:
        node.get_logger().warning(f"publish_tf: nothing is sent to tf ({error}); install tf2_ros")
        return None
    return TransformSender(node, TransformBroadcaster(node))
