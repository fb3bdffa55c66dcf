"""Bags for the tests, written with rosbags in every form that recorders leave behind."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
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


def _write_rosbag2(
    path: Path, script: Script, storage: str = "mcap", compression: rosbag2.CompressionMode | None = None
) -> Path:
    plugin = rosbag2.StoragePlugin.MCAP if storage == "mcap" else rosbag2.StoragePlugin.SQLITE3
    writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
    if compression is not None:
        writer.set_compression(compression, rosbag2.CompressionFormat.ZSTD)
    store = get_typestore(Stores.ROS2_JAZZY)
    with writer:
        connections: dict[str, Any] = {}
        for topic, log_ns, (msgtype, message) in script:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=store)
            writer.write(connections[topic], log_ns, store.serialize_cdr(message, msgtype))
    return path


def _write_rosbag1(path: Path, script: Script, chunk_bytes: int | None = None) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    writer = rosbag1.Writer(path)
    if chunk_bytes is not None:
        writer.chunk_threshold = chunk_bytes
    with writer:
        connections: dict[str, Any] = {}
        for topic, log_ns, (msgtype, message) in script:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=store)
            writer.write(connections[topic], log_ns, store.serialize_ros1(message, msgtype))
    return path


@pytest.fixture(scope="session")
def ros2() -> Messages:
    return Messages()


@pytest.fixture(scope="session")
def ros1() -> Messages:
    return Messages(ros1=True)


@pytest.fixture(scope="session")
def write_rosbag2() -> Callable[..., Path]:
    """(path, script, storage, compression) -> path."""
    return _write_rosbag2


@pytest.fixture(scope="session")
def write_rosbag1() -> Callable[..., Path]:
    """(path, script, chunk_bytes) -> path."""
    return _write_rosbag1


@pytest.fixture
def pictures() -> Callable[..., list[np.ndarray]]:
    """(count, (height, width)) -> label images of noise, each different, that no compression makes small."""
    rng = np.random.default_rng(5)
    return lambda count, size=(6, 8): [rng.integers(0, 8, size, np.uint8) for _ in range(count)]
