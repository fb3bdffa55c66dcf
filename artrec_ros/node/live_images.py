"""The last images of a topic, kept to be chosen from: the node's own subscriptions, conversions and calibrations."""

from __future__ import annotations

import threading
import time
from collections import deque
from typing import Any

from ..core.base.config import NodeConfig
from ..core.base.errors import ImageError, SourceError
from ..io.bags.topics import decode_message
from ..io.messages import node_topics as topics
from ..io.sources.frames import Frame
from . import conversions
from .calibration import Calibrations
from .graph import Graph, check_topic
from .inputs import Inputs, LiveImage

_NODE = "artrec_studio"
_FOLLOW_PERIOD_S = 0.25
_RATED = 30  # images that the rate is told by
_STALE_S = 2.0
_COMPRESSED = "/compressed"
_IMAGE_TYPES = (topics.IMAGE.type, topics.COMPRESSED.type)


class LiveImages:
    """Listens to an image topic and the calibration beside it.

    :ivar topic: the images', as it is subscribed to.
    """

    def __init__(self, topic: str, camera_info_topic: str | None, rectified: bool, kept: int) -> None:
        """:param topic: raw, or with /compressed behind it. :param camera_info_topic: None: camera_info beside it.
        :param rectified: images are rectified: P of the calibration holds. :param kept: how many of the last images.
        :raises SourceError: that is no name of a topic."""
        base = topic.removesuffix(_COMPRESSED)
        info = camera_info_topic or f"{base.rpartition('/')[0]}/camera_info"
        for name in (base, info):
            check_topic(name, f"--topic {topic}")
        self._graph = Graph(_NODE, [f"{topics.IMAGE.name}:={base}", f"{topics.CAMERA_INFO.name}:={info}"])
        self._kept: deque[LiveImage] = deque(maxlen=kept)
        self._lock = threading.Lock()
        self._rectified, self._calibrations = rectified, Calibrations()
        transport = "compressed" if topic.endswith(_COMPRESSED) else "raw"
        node = self._graph.node
        self._inputs = Inputs(node, NodeConfig(image_transport=transport), self._calibrations.receive, self._receive)
        self.topic = self._inputs.image.topic
        node.create_timer(_FOLLOW_PERIOD_S, self._inputs.follow)

    @property
    def graph(self) -> Graph:
        """Through which others may ask, too."""
        return self._graph

    def close(self) -> None:
        self._graph.close()
        self._inputs.close()

    def _receive(self, image: LiveImage) -> None:
        self._calibrations.meet(image.msg.header)
        with self._lock:
            self._kept.append(image)

    def held(self) -> tuple[Any, ...]:
        """The last images, the newest at the end, for `frame`."""
        with self._lock:
            return tuple(self._kept)

    def frame(self, held: Any) -> Frame:
        """The pixels of one of `held`, with the calibration that holds for it; the reason, where it has none.

        Images without a stamp get the time at which they came.
        """
        msg, received_ns = held.msg, held.received_ns
        stamp_ns = conversions.stamp_ns(msg.header) or received_ns
        try:
            image = decode_message(msg)
        except ImageError as error:
            return Frame(stamp_ns, self.topic, error=str(error))
        size = (int(image.shape[1]), int(image.shape[0]))
        camera = self._calibrations.camera_for(stamp_ns, size, self._rectified, msg.header.frame_id)
        return Frame(stamp_ns, self.topic, image, camera)

    def state(self) -> str:
        """How images come, in a line."""
        held = self.held()
        if not held or time.time_ns() - held[-1].received_ns > _STALE_S * 1e9:
            return f"{self.topic}: {self._why_silent()}"
        times = [image.received_ns for image in held[-_RATED:]]
        rate = f"{(len(times) - 1) * 1e9 / (times[-1] - times[0]):.0f} Hz" if times[-1] > times[0] else "images come"
        problem = self._inputs.uncalibrated(self._calibrations.problem)
        if problem:
            return f"{self.topic}: {rate}, without calibration ({problem})"
        doubt = self._calibrations.doubt
        return f"{self.topic}: {rate}, calibrated{f', in doubt: {doubt}' if doubt else ''}"

    def wait(self, patience_s: float) -> None:
        """Until there is an image. :raises SourceError: none comes in time, and why."""
        end_s = time.monotonic() + patience_s
        while not self.held():
            if time.monotonic() > end_s:
                raise SourceError(f"--topic {self.topic}: no image within {patience_s:g} s: {self._why_silent()}")
            time.sleep(0.05)

    def _why_silent(self) -> str:
        image = self._inputs.image
        if image.other_type:
            return f"it is {image.other_type}, not {image.type}; /compressed behind a topic tells compressed images"
        if image.incompatible:
            return image.incompatible
        if image.publishers:
            return "it has a publisher, that sends nothing"
        others = [
            name
            for name, types in self._graph.node.get_topic_names_and_types()
            if set(types) & set(_IMAGE_TYPES) and name != self.topic
        ]
        return (
            f"nobody publishes it; images are on {', '.join(sorted(others)) or 'no topic that can be seen from here'}"
        )
