"""Writes rosbag2 bags of images, calibrations and poses, without ROS. What reads them is io/bags.py."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from ..core.datatypes import Camera
from ..core.errors import SourceError
from ..core.transforms import Pose

STORAGES = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
_JPEG_QUALITY = 90


class BagWriter:
    """A bag that is being written; a context manager. Topics appear with their first message.

    :param path: a folder that does not exist yet.
    :param storage: mcap or sqlite3.
    :raises SourceError: the folder exists or cannot be made.
    """

    def __init__(self, path: Path, storage: str = "mcap") -> None:
        if path.exists():
            raise SourceError(f"{path}: exists already; name a new folder for the bag")
        self._path = path
        self._writer = Writer(path, version=9, storage_plugin=STORAGES[storage])
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._connections: dict[str, Any] = {}

    def __enter__(self) -> BagWriter:
        try:
            self._writer.open()
        except OSError as error:
            raise SourceError(f"{self._path}: cannot be written: {error}") from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._writer.close()

    def write_image(self, topic: str, stamp_ns: int, frame_id: str, image: NDArray[np.uint8]) -> None:
        """sensor_msgs/Image: (H, W) as mono8, (H, W, 3) as bgr8."""
        height, width = image.shape[:2]
        fields = {
            "height": height,
            "width": width,
            "encoding": "mono8" if image.ndim == 2 else "bgr8",
            "is_bigendian": 0,
            "step": image.size // height,
            "data": np.ascontiguousarray(image).reshape(-1),
        }
        self._write(topic, stamp_ns, "sensor_msgs/msg/Image", header=self._header(stamp_ns, frame_id), **fields)

    def write_jpeg(self, topic: str, stamp_ns: int, frame_id: str, image: NDArray[np.uint8]) -> None:
        """sensor_msgs/CompressedImage of a (H, W, 3) BGR image."""
        _, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
        header = self._header(stamp_ns, frame_id)
        kind = "sensor_msgs/msg/CompressedImage"
        self._write(topic, stamp_ns, kind, header=header, format="bgr8; jpeg compressed bgr8", data=data.reshape(-1))

    def write_camera(self, topic: str, stamp_ns: int, camera: Camera) -> None:
        """sensor_msgs/CameraInfo of an unrectified camera."""
        roi = self._new("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
        fields = {
            "width": camera.size[0],
            "height": camera.size[1],
            "distortion_model": "rational_polynomial" if camera.distortion.size > 5 else "plumb_bob",
            "d": camera.distortion if camera.distortion.size else np.zeros(5),
            "k": camera.matrix.reshape(-1),
            "r": np.eye(3).reshape(-1),
            "p": np.column_stack([camera.matrix, np.zeros(3)]).reshape(-1),
            "binning_x": 0,
            "binning_y": 0,
            "roi": roi,
        }
        header = self._header(stamp_ns, camera.frame_id)
        self._write(topic, stamp_ns, "sensor_msgs/msg/CameraInfo", header=header, **fields)

    def write_poses(self, topic: str, stamp_ns: int, frame_id: str, poses: Sequence[Pose]) -> None:
        """geometry_msgs/PoseArray."""
        messages = []
        for pose in poses:
            x, y, z, w = map(float, pose.quaternion)
            position = self._new("geometry_msgs/msg/Point", **dict(zip("xyz", map(float, pose.position), strict=True)))
            orientation = self._new("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)
            messages.append(self._new("geometry_msgs/msg/Pose", position=position, orientation=orientation))
        header = self._header(stamp_ns, frame_id)
        self._write(topic, stamp_ns, "geometry_msgs/msg/PoseArray", header=header, poses=messages)

    def _new(self, msgtype: str, **fields: Any) -> Any:
        return self._store.types[msgtype](**fields)

    def _header(self, stamp_ns: int, frame_id: str) -> Any:
        stamp = self._new("builtin_interfaces/msg/Time", sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
        return self._new("std_msgs/msg/Header", stamp=stamp, frame_id=frame_id)

    def _write(self, topic: str, stamp_ns: int, msgtype: str, **fields: Any) -> None:
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(topic, msgtype, typestore=self._store)
        data = self._store.serialize_cdr(self._new(msgtype, **fields), msgtype)
        self._writer.write(self._connections[topic], stamp_ns, data)
