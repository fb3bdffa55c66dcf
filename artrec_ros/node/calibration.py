"""Which calibration holds for which image."""

from __future__ import annotations

import math
import threading
import time

from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header

from ..core.base.errors import ConfigError
from ..core.geometry.camera import Camera
from ..io.bags.infos import Info, Infos, of_another
from ..io.bags.topics import camera_of
from .conversions import stamp_ns
from .delays import Delays

NONE_RECEIVED = "no camera_info received"
_PATIENCE_S = 0.1  # a driver sends an image and its calibration together; what comes later is not waited for
_CHANGES_S = 10.0  # a camera whose calibration changed within that may change it again
_RECENT_S = 2.0  # what was in doubt so long ago is still told: a report covers a second
_UNLIKE = (
    "camera_info changes, and images were taken with one of another stamp than theirs: each image's own must come with "
    "it, under its stamp"
)


class Calibrations:
    """Keeps the last calibrations. Filled by one thread and asked by another.

    :ivar problem: why the last image that was asked for had none; empty: it had one, or there is one for the next.
    """

    def __init__(self) -> None:
        self._news = threading.Condition()
        self._infos = Infos[CameraInfo]()
        self._delays = Delays()
        self._ready: tuple[tuple[object, ...], Camera | str] | None = None
        self._changed_s = -math.inf
        self._unlike_s: float | None = None  # when an image was last taken with one that may not be its own
        self._another = ""  # of the last image
        self.problem = NONE_RECEIVED

    def receive(self, msg: CameraInfo) -> None:
        """Keep a calibration, for images that bear its stamp or come later."""
        info, now_s = Info(stamp_ns(msg.header), msg.header.frame_id, msg), time.monotonic()
        with self._news:
            before = self._infos.newest(info.frame_id)
            if before is not None and _told(before.content) != _told(msg):
                self._changed_s = now_s
            self._infos.add(info)
            taken = self._delays.came(info, now_s)
            if taken is not None and _told(taken) != _told(msg):
                self._unlike_s = now_s
            self._news.notify_all()
        if self.problem == NONE_RECEIVED:
            self.problem = ""

    def meet(self, header: Header) -> None:
        """Images of a stream in their order; where stamps go back calibrations of the same stamps are of another."""
        with self._news:
            if self._infos.meet(stamp_ns(header), header.frame_id):
                self._delays.begin_again()

    def camera_for(
        self, image_stamp_ns: int, size: tuple[int, int], rectified: bool, frame_id: str = ""
    ) -> Camera | None:
        """The calibration with the image's stamp, else the newest, where it is valid and for images of this size; those
        of another camera than the image's are taken only where there are no others.

        Of a camera whose calibration changes, or is of before stamps went back, that of the image's stamp is waited for
        a moment where such usually come.

        :param size: (width, height), pixels. :param rectified: the image is. :param frame_id: the image's.
        """
        info = self._choose(image_stamp_ns, frame_id)
        camera = NONE_RECEIVED if info is None else self._read(info.content, rectified)
        if isinstance(camera, Camera) and camera.size != size:
            width, height = camera.size
            camera = f"camera_info is for {width}x{height} images, these are {size[0]}x{size[1]}"
        self.problem = "" if isinstance(camera, Camera) else camera
        fits = info is None or info.rank(image_stamp_ns, frame_id).fits
        self._another = "" if info is None or fits else of_another(info.frame_id, frame_id, "camera_info")
        return camera if isinstance(camera, Camera) else None

    @property
    def camera(self) -> Camera | None:
        """The last valid one that an image asked for."""
        ready = self._ready
        return ready[1] if ready is not None and isinstance(ready[1], Camera) else None

    @property
    def doubt(self) -> str:
        """Why images may have been taken with a calibration that is not theirs; empty: they were not."""
        unlike_s = self._unlike_s
        return self._another or (_UNLIKE if unlike_s is not None and time.monotonic() - unlike_s < _RECENT_S else "")

    def _choose(self, image_stamp_ns: int, frame_id: str) -> Info[CameraInfo] | None:
        def chosen() -> Info[CameraInfo] | None:
            return self._infos.choose(image_stamp_ns, frame_id)

        def is_own() -> bool:
            info = chosen()
            return info is not None and info.stamp_ns == image_stamp_ns

        with self._news:
            usual_s, began_s = self._delays.usual_s, time.monotonic()
            self._delays.asked(image_stamp_ns, frame_id, began_s, is_own())
            # one that does not change is the newest, too: a fixed camera's images wait for nothing
            may_change = began_s - self._changed_s < _CHANGES_S or self._infos.are_outdated
            if may_change and usual_s <= _PATIENCE_S:
                self._news.wait_for(is_own, _PATIENCE_S)
            info, now_s = chosen(), time.monotonic()
            if info is not None and not is_own():
                self._delays.taken(image_stamp_ns, info.content)
                if now_s - self._changed_s < _RECENT_S:
                    self._unlike_s = now_s
            return info

    def _read(self, msg: CameraInfo, rectified: bool) -> Camera | str:
        """The camera, or why it is none; made anew only where something changed."""
        key = rectified, *_told(msg)
        if self._ready is None or self._ready[0] != key:
            try:
                self._ready = key, camera_of(msg, rectified)
            except ConfigError as error:
                self._ready = key, str(error)
        return self._ready[1]


def _told(msg: CameraInfo) -> tuple[object, ...]:
    """What it says of the camera."""
    roi = msg.roi
    return (
        msg.width, msg.height, msg.distortion_model, msg.header.frame_id, msg.binning_x, msg.binning_y,
        roi.x_offset, roi.y_offset, roi.width, roi.height, bytes(msg.k), bytes(msg.p), bytes(msg.d),
    )  # fmt: skip
