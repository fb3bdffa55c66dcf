"""Which calibration holds for which image."""

from __future__ import annotations

import threading
from collections import deque

from sensor_msgs.msg import CameraInfo

from ..core.base.errors import ConfigError
from ..core.geometry.camera import Camera
from ..io.bags.topics import camera_of
from .conversions import stamp_ns

NONE_RECEIVED = "no camera_info received"
_KEPT = 16  # a calibration may come before its image while others still wait for theirs


class Calibrations:
    """Keeps the last calibrations. Filled by one thread and asked by another.

    :ivar problem: why the last image that was asked for had none; empty: it had one, or there is one for the next.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._received: deque[CameraInfo] = deque(maxlen=_KEPT)
        self._ready: tuple[tuple[object, ...], Camera | str] | None = None
        self.problem = NONE_RECEIVED

    def receive(self, msg: CameraInfo) -> None:
        """Keep a calibration, for images that bear its stamp or come later."""
        with self._lock:
            self._received.append(msg)
        if self.problem == NONE_RECEIVED:
            self.problem = ""

    def camera_for(self, image_stamp_ns: int, size: tuple[int, int], rectified: bool) -> Camera | None:
        """The calibration with the image's stamp, else the newest, where it is valid and for images of this size.

        :param size: (width, height), pixels. :param rectified: the image is.
        """
        msg = self._choose(image_stamp_ns)
        camera = NONE_RECEIVED if msg is None else self._read(msg, rectified)
        if isinstance(camera, Camera) and camera.size != size:
            width, height = camera.size
            camera = f"camera_info is for {width}x{height} images, these are {size[0]}x{size[1]}"
        self.problem = "" if isinstance(camera, Camera) else camera
        return camera if isinstance(camera, Camera) else None

    @property
    def camera(self) -> Camera | None:
        """The last valid one that an image asked for."""
        ready = self._ready
        return ready[1] if ready is not None and isinstance(ready[1], Camera) else None

    def _choose(self, image_stamp_ns: int) -> CameraInfo | None:
        with self._lock:
            received = list(self._received)
        same = (msg for msg in reversed(received) if stamp_ns(msg.header) == image_stamp_ns)
        return next(same, received[-1] if received else None)

    def _read(self, msg: CameraInfo, rectified: bool) -> Camera | str:
        """The camera, or why it is none; made anew only where something changed."""
        roi = msg.roi
        key = (
            rectified, msg.width, msg.height, msg.distortion_model, msg.header.frame_id, msg.binning_x, msg.binning_y,
            roi.x_offset, roi.y_offset, roi.width, roi.height, bytes(msg.k), bytes(msg.p), bytes(msg.d),
        )  # fmt: skip
        if self._ready is None or self._ready[0] != key:
            try:
                self._ready = key, camera_of(msg, rectified)
            except ConfigError as error:
                self._ready = key, str(error)
        return self._ready[1]
