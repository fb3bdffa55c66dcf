"""The node: images in; poses, joints, markers, an overlay and diagnostics out. Wiring only."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Sequence
from typing import Any

import cv2
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from ..core.datatypes import Camera, FrameResult
from ..core.drawing import draw_result
from ..core.errors import ArtrecError, ConfigError
from ..io.parameters import Setup
from . import conversions
from .diagnostics import Diagnostics, InputState
from .image_input import ImageInput
from .parameters import LiveParameters, initial_setup
from .publishers import ObjectPublishers

_FOLLOW_PERIOD_S = 0.25
_REPORT_PERIOD_S = 1.0


class RecognizerNode(Node):
    """Recognises the objects that its parameters name in every image that it receives.

    :param arguments: the command line's: they tell where the parameter file is.
    :raises ConfigError: the parameters, or files that they name, are not valid.
    """

    def __init__(self, arguments: Sequence[str] = ()) -> None:
        super().__init__("artrec_node")
        setup = initial_setup(self, arguments)
        self._recognizer = setup.build()
        self._camera: Camera | None = None
        self._uncalibrated = "no camera_info received"
        self._live_parameters = LiveParameters(self, setup, self._prepare)
        self._outputs = ObjectPublishers(self, setup.targets)
        self._names = [t.name for t in setup.targets]
        self._overlay = self.create_publisher(Image, "debug/image", 1)
        self._diagnostics_out = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._diagnostics = Diagnostics(self.get_fully_qualified_name(), setup.node.no_image_after_s, time.monotonic())
        self._info_subscription = self.create_subscription(
            CameraInfo, "camera_info", self._on_camera_info, qos_profile_sensor_data
        )
        self._input = ImageInput(self, setup.node, self._on_image)
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # a stopped simulation is something to report
        self.create_timer(_FOLLOW_PERIOD_S, self._input.follow_publishers, clock=steady)
        self.create_timer(_REPORT_PERIOD_S, self._report, clock=steady)
        self.get_logger().info(f"looking for {', '.join(self._names)} in {self._input.topic}")

    def _prepare(self, setup: Setup) -> Callable[[], None]:
        """Build what changed parameters lead to, before they are taken."""
        recognizer = setup.build()

        def take() -> None:
            self._recognizer = recognizer

        return take

    def _on_camera_info(self, msg: CameraInfo) -> None:
        try:
            self._camera, self._uncalibrated = conversions.camera_from_msg(msg), ""
        except ConfigError as error:
            self._camera, self._uncalibrated = None, str(error)

    def _on_image(self, msg: Any, received_ns: int) -> None:
        try:
            n_objects = self._process(msg)
        except (ArtrecError, cv2.error) as error:
            self._skip(" ".join(str(error).split()))
        except Exception as error:  # a fault of this package: it costs one image, not the node
            self._skip(f"internal error: {error!r}")
            self.get_logger().error(traceback.format_exc(), throttle_duration_sec=30.0)
        else:
            latency_ms = (time.time_ns() - received_ns) * 1e-6
            self._diagnostics.image_processed(time.monotonic(), latency_ms, n_objects)

    def _process(self, msg: Any) -> int:
        """Recognise and publish; how many objects there were."""
        image = conversions.image_from_msg(msg)
        camera = self._camera_for(image.shape)
        result = self._recognizer.recognize(image, camera)
        self._outputs.publish(result.detections, msg.header)
        self._publish_overlay(image, result, camera, msg.header)
        return len(result.detections)

    def _skip(self, reason: str) -> None:
        self._diagnostics.image_failed(time.monotonic(), reason)
        self.get_logger().warning(f"image skipped: {reason}", throttle_duration_sec=5.0)

    def _camera_for(self, shape: tuple[int, ...]) -> Camera | None:
        """The camera where it fits the image; None, with a warning, where metric poses must be withheld."""
        size = (shape[1], shape[0])
        if self._camera is not None and self._camera.size != size:
            w, h = self._camera.size
            self._camera, self._uncalibrated = None, f"camera_info is for {w}x{h} images, these are {size[0]}x{size[1]}"
        if self._camera is None:
            self.get_logger().warning(f"metric poses are withheld: {self._uncalibrated}", throttle_duration_sec=10.0)
        return self._camera

    def _publish_overlay(self, image: Any, result: FrameResult, camera: Camera | None, header: Header) -> None:
        if self._overlay.get_subscription_count():
            picture = draw_result(image, result, self._names, camera)
            self._overlay.publish(conversions.image_to_msg(picture, header))

    def _report(self) -> None:
        state = InputState(
            self._input.topic,
            self._input.publishers(),
            self._input.incompatible,
            self._input.dropped,
            self._uncalibrated,
        )
        header = Header(stamp=self.get_clock().now().to_msg())
        self._diagnostics_out.publish(self._diagnostics.report(state, time.monotonic(), header))
