"""Objects as tf frames, where tf2_ros is installed. Nothing else of the package needs it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rclpy.node import Node
from std_msgs.msg import Header

from ..core.model.found import Detection
from ..io.messages.detection_messages import object_frames
from .conversions import to_ros


class TransformSender:
    """Sends each object's frame as a child of its image's frame.

    tf knows no namespaces, so a node's namespace goes before its frames' names: left/red_0.
    """

    def __init__(self, node: Node, broadcaster: Any) -> None:
        """:param broadcaster: tf2_ros.TransformBroadcaster, or what can send as it does."""
        self._broadcaster = broadcaster
        namespace = node.get_namespace().strip("/")
        self._prefix = f"{namespace}/" if namespace else ""

    def send(self, detections: Sequence[Detection], header: Header) -> None:
        transforms = [to_ros(m) for m in object_frames(detections, header, self._prefix)]
        if transforms and header.frame_id:  # tf refuses frames without a parent
            self._broadcaster.sendTransform(transforms)


def transform_sender(node: Node) -> TransformSender | None:
    """What sends to tf; None, with a warning, where tf2_ros is missing."""
    try:
        from tf2_ros import TransformBroadcaster
    except ImportError as error:
        node.get_logger().warning(f"publish_tf: nothing is sent to tf ({error}); install tf2_ros")
        return None
    return TransformSender(node, TransformBroadcaster(node))
