"""Publishes the messages of a bag as they were recorded, with their own stamps, and the bag's time on /clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from ..core.base.errors import SourceError
from ..io.bags.heads import head_of
from ..io.bags.reader import RawMessage, Topic
from .conversions import message_class

_CLOCK_PERIOD_S = 0.025
_DEPTH = 10
_DISCOVERY_S = 0.1
_STEADY_S = 0.5
_UNSET = 0  # a stamp that was never set
_SETTLE_S = 5.0  # discovery may take so long, and a node to follow what is offered
_SILENT_S = 1.0


class Player:
    """Plays bags on a node of its own.

    :param topics: of the bag, those to publish. :param names: what a bag's topic is called in the graph instead.
    :param wait_for: a topic; an image is sent when the one before it was answered there, by its stamp. Only images that
        somebody who answers there listens to are waited for.
    :param timeout_s: the longest that an answer, or somebody who listens, is waited for.
    :param say: called with a line for the user.
    :ivar sent: messages by topic of the bag. :ivar skipped: topics whose type, the value, is not installed here.
    :ivar unanswered: stamps of images that `wait_for` brought no answer to; a node sends none where one cannot be used.
    """

    def __init__(
        self,
        node: Node,
        topics: Iterable[Topic],
        *,
        names: Mapping[str, str] | None = None,
        wait_for: str | None = None,
        timeout_s: float = 60.0,
        say: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._node, self._timeout_s, self._say = node, timeout_s, say
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(node)
        self._clock = node.create_publisher(Clock, "/clock", 1)
        self.sent: dict[str, int] = {}
        self.skipped: dict[str, str] = {}
        self.unanswered: list[int] = []
        topics = list(topics)
        self._publishers = {t.name: self._publisher(t, (names or {}).get(t.name, t.name)) for t in topics}
        self._images = {t.name for t in topics if t.msgtype.endswith(("/Image", "/CompressedImage"))}
        self._wait_for = node.resolve_topic_name(wait_for) if wait_for else None
        self._answers: list[int] = []
        self._awaited: set[str] = set()  # topics of the bag
        self._calibrations: dict[str, bytes] = {}  # the last one of each topic of the bag, but for its stamp

    def begin(self) -> None:
        """Give listeners time to connect; with `wait_for`, until somebody answers there.

        :raises SourceError: nobody does in time.
        """
        if self._wait_for is not None:
            self._await_answers(self._wait_for)
        used = [p for p in self._publishers.values() if p is not None]
        self._settle(lambda: all(self._is_heard_well(p) for p in used), _SETTLE_S)
        if self._wait_for is not None:  # some topics nobody may listen to; but each that somebody does counts
            heard = [p for p in used if self._listeners(p)]
            self._settle(lambda: all(self._is_heard_well(p) for p in heard), self._timeout_s)
            self._awaited = self._images_to_await(self._wait_for)
            self._say(f"waiting for the answer to each image of {', '.join(sorted(self._awaited))}")

    def _settle(self, condition: Callable[[], Any], patience_s: float) -> None:
        """Until the condition has held for a while: who subscribes anew counts twice for a moment, or not at all."""
        began_s = since_s = time.monotonic()
        end_s, told = began_s + patience_s, False
        while (now_s := time.monotonic()) < min(end_s, since_s + _STEADY_S):
            self._executor.spin_once(timeout_sec=_DISCOVERY_S)
            if not condition():
                since_s = now_s
            if not told and now_s > began_s + _SILENT_S:
                self._say(f"waiting for those who listen to connect, for {patience_s:g} s at most")
                told = True

    def play(self, messages: Iterable[RawMessage], rate: float) -> None:
        """Publishes until the end, and until all is received.

        :param rate: how much faster than recorded; passed over while waiting for answers.
        """
        first_ns, began_s = None, 0.0
        for message in messages:
            if first_ns is None:
                first_ns, began_s = message.log_ns, time.monotonic()
            if not self._wait_for:
                self._sleep_until(began_s + (message.log_ns - first_ns) * 1e-9 / rate, message.log_ns, rate)
            self._send_clock(message.log_ns)
            self._send(message)
        for publisher in (p for p in [self._clock, *self._publishers.values()] if p is not None):
            publisher.wait_for_all_acked(Duration(seconds=_SETTLE_S))

    def _publisher(self, topic: Topic, name: str) -> Any:
        try:
            kind = message_class(topic.msgtype)
        except (ImportError, AttributeError, ValueError):
            self.skipped[topic.name] = topic.msgtype
            return None
        # who listens to what was latched hears no publisher that is not; and transforms that stay always are
        latched = topic.latched or topic.name.endswith("/tf_static")
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        qos = QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.RELIABLE, durability=durability)
        return self._node.create_publisher(kind, name, qos)

    def _send(self, message: RawMessage) -> None:
        publisher = self._publishers[message.topic]
        if publisher is None:
            return
        self._answers.clear()
        publisher.publish(message.data)
        self.sent[message.topic] = self.sent.get(message.topic, 0) + 1
        if message.topic in self._awaited:
            stamp_ns = head_of(message.data, _UNSET).stamp_ns
            if not self._spin_until(lambda: stamp_ns in self._answers):
                self.unanswered.append(stamp_ns)
                self._say(f"{message.topic}: the image of {stamp_ns} ns was not answered in {self._timeout_s:g} s")
        elif self._wait_for and message.msgtype.endswith("/CameraInfo") and self._is_another(message):
            publisher.wait_for_all_acked(Duration(seconds=_SETTLE_S))  # it is to be there before the next image

    def _is_another(self, calibration: RawMessage) -> bool:
        """Whether it tells something else than the one before on its topic: that one has arrived is known. To know it
        of each would take a heartbeat of the middleware, three seconds."""
        told = calibration.data[head_of(calibration.data, _UNSET).end :]
        before, self._calibrations[calibration.topic] = self._calibrations.get(calibration.topic), told
        return told != before

    def _send_clock(self, now_ns: int) -> None:
        msg = Clock()
        msg.clock.sec, msg.clock.nanosec = divmod(now_ns, 10**9)
        self._clock.publish(msg)

    def _sleep_until(self, end_s: float, end_ns: int, rate: float) -> None:
        """Until the steady clock's `end_s`, while /clock goes on to the bag's `end_ns`."""
        while (left_s := end_s - time.monotonic()) > 0:
            if left_s > _CLOCK_PERIOD_S:
                self._send_clock(end_ns - round(left_s * rate * 1e9))
            self._executor.spin_once(timeout_sec=min(left_s, _CLOCK_PERIOD_S))

    def _on_answer(self, data: bytes) -> None:
        self._answers.append(head_of(data, _UNSET).stamp_ns)

    def _await_answers(self, topic: str) -> None:
        def kind() -> str:
            return next((types[0] for name, types in self._node.get_topic_names_and_types() if name == topic), "")

        def is_heard() -> bool:
            return any(p and p.get_subscription_count() for name, p in self._publishers.items() if name in self._images)

        self._say(f"waiting for somebody who listens to images and publishes {topic}")
        if not self._spin_until(kind):
            raise SourceError(f"waited {self._timeout_s:g} s: nobody publishes {topic}")
        # raw: a message that begins with a header tells its stamp, whatever its type
        answers = self._node.create_subscription(message_class(kind()), topic, self._on_answer, _DEPTH, raw=True)
        if not self._spin_until(lambda: answers.get_publisher_count() and is_heard()):
            raise SourceError(f"waited {self._timeout_s:g} s: nobody listens to the images; --remap gives other names")

    def _images_to_await(self, topic: str) -> set[str]:
        """The bag's topics of images that one of the nodes which publish `topic` listens to.

        None of them may: then others stand between, and whatever is listened to leads to them.
        """
        nodes = {(p.node_name, p.node_namespace) for p in self._node.get_publishers_info_by_topic(topic)}
        heard, direct = set(), set()
        for name, publisher in self._publishers.items():
            listeners = []
            if name in self._images and publisher is not None:
                listeners = self._node.get_subscriptions_info_by_topic(publisher.topic_name)
            if listeners:
                heard.add(name)
            if nodes & {(s.node_name, s.node_namespace) for s in listeners}:
                direct.add(name)
        return direct or heard

    def _is_heard_well(self, publisher: Any) -> bool:
        """Everybody who can hear it listens reliably, and is connected."""
        listeners = self._listeners(publisher)
        reliable = all(s.qos_profile.reliability == ReliabilityPolicy.RELIABLE for s in listeners)
        return bool(listeners) and reliable and publisher.get_subscription_count() >= len(listeners)

    def _listeners(self, publisher: Any) -> list[Any]:
        """Of those who listen to the topic those who can hear this publisher."""
        there, kept = self._node.get_subscriptions_info_by_topic(publisher.topic_name), DurabilityPolicy.TRANSIENT_LOCAL
        latched = publisher.qos_profile.durability == kept
        return [s for s in there if latched or s.qos_profile.durability != kept]

    def _spin_until(self, condition: Callable[[], Any]) -> bool:
        """Whether it came true in time."""
        end_s = time.monotonic() + self._timeout_s
        while not condition():
            if time.monotonic() > end_s:
                return False
            self._executor.spin_once(timeout_sec=_DISCOVERY_S)
        return True
