"""All that the node publishes about images."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSCompatibility, qos_check_compatible
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from ..core.model.found import Detection
from ..core.model.target import Target
from ..io.messages import node_topics as topics
from ..io.messages.node_topics import NodeTopic
from ..io.messages.object_messages import OBJECT_MAKERS
from .conversions import header_of, message_class, to_ros
from .markers import MarkerScene
from .tf import TransformSender


class Publishers:
    """Publishes what was found in one image, each message with the image's header.

    :param tf: None: nothing is sent to tf.
    """

    def __init__(self, node: Node, targets: Sequence[Target], tf: TransformSender | None = None) -> None:
        def publisher(topic: NodeTopic, name: str = "") -> Any:
            # no event handlers: each costs every turn of the executor time; `unheard` asks in their place
            events = PublisherEventCallbacks(use_default_callbacks=False)
            made = node.create_publisher(message_class(topic.type), topic.of(name), topic.depth, event_callbacks=events)
            self._all.append(made)
            return made

        self._node, self._tf, self._names = node, tf, [t.name for t in targets]
        self._all: list[Any] = []
        self._of_objects = [
            (t.name, make, publisher(topic, t.name)) for t in targets for topic, make in OBJECT_MAKERS.items()
        ]
        self._shared_by_nobody = [p.topic_name for p in self._all]
        self._markers = publisher(topics.MARKERS)
        self._overlay, self._labels = publisher(topics.OVERLAY), publisher(topics.LABELS)
        self._scene = MarkerScene(targets)

    @property
    def overlay_is_wanted(self) -> bool:
        return bool(self._overlay.get_subscription_count())

    @property
    def labels_are_wanted(self) -> bool:
        return bool(self._labels.get_subscription_count())

    def publish(self, detections: Sequence[Detection], header: Header, marker_lifetime_s: float = 0.0) -> None:
        """What OBJECT_MAKERS make of it, and markers, to those who listen: of each image, empty too, but for `pose`."""
        of_name = {name: [d for d in detections if d.object == name] for name in self._names}
        for name, make, publisher in self._of_objects:
            if publisher.get_subscription_count():
                for message in make(of_name[name], header.frame_id, header_of(header)):
                    publisher.publish(to_ros(message))
        if self._markers.get_subscription_count():
            markers = self._scene.update(detections, header, marker_lifetime_s)
            if markers.markers:
                self._markers.publish(markers)
        if self._tf is not None:
            self._tf.send(detections, header)

    def publish_overlay(self, picture: Image) -> None:
        self._overlay.publish(picture)

    def publish_labels(self, picture: Image) -> None:
        self._labels.publish(picture)

    def clear(self) -> None:
        """Delete all markers that are shown."""
        self._markers.publish(self._scene.update([], Header(stamp=self._node.get_clock().now().to_msg())))

    def unheard(self) -> list[str]:
        """A line for each subscriber that gets nothing, for it asks for another type or quality of service."""
        lines = []
        own = self._node.get_name(), self._node.get_namespace()
        for topic in (p.topic_name for p in self._all):
            publishers = self._node.get_publishers_info_by_topic(topic)
            offered = [p for p in publishers if (p.node_name, p.node_namespace) == own]
            for subscriber in self._node.get_subscriptions_info_by_topic(topic) if offered else []:
                told = f"on {topic}: {subscriber.node_name} hears nothing"
                compatible, reason = qos_check_compatible(offered[0].qos_profile, subscriber.qos_profile)
                if subscriber.topic_type != (own_type := offered[0].topic_type):
                    lines.append(f"wrong type {told}: it asks for {subscriber.topic_type}, not {own_type}")
                elif compatible == QoSCompatibility.ERROR:
                    lines.append(f"QoS mismatch {told}: {reason.rstrip(';')}")
        return lines

    def shared(self) -> list[str]:
        """A line for each other node that publishes results of the same name, and for one that has this node's name."""
        own = self._node.get_name(), self._node.get_namespace()
        lines = []
        if self._node.get_node_names_and_namespaces().count(own) > 1:
            name = self._node.get_fully_qualified_name()
            lines.append(f"another node is called {name} too, or was and has not ended properly a moment ago")
        for topic in self._shared_by_nobody:
            publishers = self._node.get_publishers_info_by_topic(topic)
            others = {p.node_name for p in publishers if (p.node_name, p.node_namespace) != own}
            lines += [f"{topic}: {other} publishes there too" for other in sorted(others)]
        return lines

    def close(self) -> None:
        for publisher in self._all:
            self._node.destroy_publisher(publisher)
