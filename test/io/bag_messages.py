"""Messages of one ROS generation or the other, for bags that tests write."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from rosbags.typesys import Stores, get_typestore

IMAGE, COMPRESSED, INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/CameraInfo"


class Messages:
    """Makes messages of one ROS generation."""

    def __init__(self, ros1: bool = False) -> None:
        self.ros1 = ros1
        self.store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)

    def _new(self, msgtype: str, **fields: Any) -> Any:
        return self.store.types[msgtype](**fields)

    def _header(self, stamp_ns: int) -> Any:
        seq = {"seq": 0} if self.ros1 else {}
        stamp = self._new("builtin_interfaces/msg/Time", sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
        return self._new("std_msgs/msg/Header", stamp=stamp, frame_id="optical", **seq)

    def image(self, stamp_ns: int, pixels: np.ndarray, **overrides: Any) -> tuple[str, Any]:
        fields: dict[str, Any] = {
            "header": self._header(stamp_ns),
            "height": pixels.shape[0],
            "width": pixels.shape[1],
            "encoding": "mono8" if pixels.ndim == 2 else "bgr8",
            "is_bigendian": 0,
            "step": pixels.size // pixels.shape[0],
            "data": pixels.reshape(-1),
        }
        return IMAGE, self._new(IMAGE, **{**fields, **overrides})

    def compressed(self, stamp_ns: int, pixels: np.ndarray, suffix: str = ".png") -> tuple[str, Any]:
        data = cv2.imencode(suffix, pixels)[1].reshape(-1)
        return COMPRESSED, self._new(COMPRESSED, header=self._header(stamp_ns), format=suffix[1:], data=data)

    def info(self, stamp_ns: int, focal_px: float, size: tuple[int, int]) -> tuple[str, Any]:
        roi = self._new("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
        K = np.array([focal_px, 0, 3.5, 0, focal_px, 2.5, 0, 0, 1])
        arrays = {"d": np.zeros(5), "k": K, "r": np.eye(3).reshape(-1), "p": np.zeros(12)}
        if self.ros1:
            arrays = {name.upper(): values for name, values in arrays.items()}
        fields = {
            "header": self._header(stamp_ns),
            "width": size[0],
            "height": size[1],
            "distortion_model": "plumb_bob",
        }
        return INFO, self._new(INFO, **fields, **arrays, binning_x=0, binning_y=0, roi=roi)


Script = list[tuple[str, int, tuple[str, Any]]]  # topic, time of recording, (type, message)
