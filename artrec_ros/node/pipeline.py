"""One image on its way through the node: message, pixels, calibration, recognition, messages."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from std_msgs.msg import Header

from ..core.base.errors import ArtrecError
from ..core.drawing import draw_result
from ..core.geometry.camera import Camera
from ..core.model.found import FrameResult
from ..core.recognizer import Recognizer
from ..core.tracking.tracker import Tracker
from ..io.parameters import Setup
from . import conversions
from .calibration import Calibrations
from .publishers import Publishers


@dataclass(frozen=True)
class FrameReport:
    """What became of an image.

    :param latency_ms: from its reception until its results were published, by the system clock.
    :param recognition_ms: the recogniser's and the tracker's part of it; the rest is what the node adds.
    :param ended_by: the recogniser's limits, by name, that ended its search early.
    :param header_problem: what the image's header lacks; empty: nothing.
    """

    n_objects: int
    latency_ms: float
    recognition_ms: float
    ended_by: tuple[str, ...]
    header_problem: str


class Pipeline:
    """Processes images, one at a time. Parameters may change between two of them."""

    def __init__(self, setup: Setup, calibrations: Calibrations, publishers: Publishers) -> None:
        self._calibrations, self._publishers = calibrations, publishers
        self._names = [t.name for t in setup.targets]
        self._tracker = Tracker(setup.tracking)
        self._closed = False
        self.use(setup, setup.build())

    def use(self, setup: Setup, recognizer: Recognizer) -> None:
        """From the next image on, recognise with these parameters."""
        self._current = setup, recognizer

    def close(self) -> None:
        """Publish no more, not even what is under way."""
        self._closed = True

    def process(self, msg: Any, received_ns: int) -> FrameReport | None:
        """Recognise and publish. None: closed meanwhile.

        :raises ArtrecError: the image cannot be used.
        """
        setup, recognizer = self._current
        image = conversions.image_from_msg(msg)
        size = (int(image.shape[1]), int(image.shape[0]))
        stamp_ns = conversions.stamp_ns(msg.header)
        camera = self._calibrations.camera_for(stamp_ns, size, setup.image.rectified)
        began = time.perf_counter()
        result = recognizer.recognize(image, camera)
        self._tracker.configure(setup.tracking)
        frame_id = (msg.header.frame_id or camera.frame_id) if camera else ""
        result = self._tracker.update(stamp_ns, result, frame_id)
        recognition_ms = (time.perf_counter() - began) * 1e3
        if self._closed:
            return None
        self._publishers.publish(result.detections, msg.header, setup.node.marker_lifetime_s)
        latency_ms = (time.time_ns() - received_ns) * 1e-6
        self._publish_overlay(image, result, camera, msg.header)
        return FrameReport(
            len(result.detections), latency_ms, recognition_ms, result.ended_by, _header_problem(msg.header)
        )

    def _publish_overlay(self, image: Any, result: FrameResult, camera: Camera | None, header: Header) -> None:
        if self._publishers.overlay_is_wanted:
            picture = draw_result(image, result, self._names, camera)
            self._publishers.publish_overlay(conversions.image_to_msg(picture, header))


def _header_problem(header: Header) -> str:
    if not header.frame_id:
        return "images bear no frame_id: RViz and tf cannot place what is found"
    if not conversions.stamp_ns(header):
        return "images bear no stamp: results cannot be told apart by time"
    return ""


def one_line(error: BaseException) -> str:
    """An error as users see it."""
    text = " ".join(str(error).split())
    return text if isinstance(error, ArtrecError) else f"{type(error).__name__}: {text}"
