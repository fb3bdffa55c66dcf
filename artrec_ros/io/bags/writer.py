"""Writes rosbag2 bags of images, calibrations, poses and any `Message`, without ROS. What reads them is reader.py."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from ...core.base.errors import SourceError
from ...core.geometry.camera import Camera
from ...core.geometry.transforms import Pose
from ..messages.detection_messages import Message, header, pose_array

STORAGES = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
_JPEG_QUALITY = 90
_PLAIN = {"string": str, "bool": bool, "float32": float, "float64": float} | {
    f"{sign}int{bits}": int for sign in ("u", "") for bits in (8, 16, 32, 64)
}
_DEFAULTS = {"geometry_msgs/msg/Quaternion": {"w": 1.0}}  # what ROS fills in that is not zero


class BagWriter:
    """A bag that is being written; a context manager. Topics appear with their first message.

    :param path: a folder that does not exist yet.
    :param storage: mcap or sqlite3.
    :param packed: mcap: chunks are compressed (zstd), which every reader of mcap undoes.
    :raises SourceError: the folder exists or cannot be made.
    """

    def __init__(self, path: Path, storage: str = "mcap", packed: bool = False) -> None:
        if path.exists():
            raise SourceError(f"{path}: exists already; name a new folder for the bag")
        self._path = path
        self._writer = Writer(path, version=9, storage_plugin=STORAGES[storage])
        if packed:
            self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._connections: dict[str, Any] = {}

    def __enter__(self) -> BagWriter:
        try:
            self._writer.open()
        except OSError as error:
            raise SourceError(f"{self._path}: cannot be written: {error}") from error
        return self

    def __exit__(self, *raised: object) -> None:
        self._writer.close()

    def write(self, topic: str, stamp_ns: int, message: Message) -> None:
        """Any message of ROS 2's common_interfaces, recorded at `stamp_ns`."""
        data = self._store.serialize_cdr(self._made(message.type, message.fields), message.type)
        self.write_raw(topic, stamp_ns, message.type, data)

    def write_raw(self, topic: str, stamp_ns: int, msgtype: str, data: bytes | memoryview) -> None:
        """A message that is serialised already, as ROS 2 does (CDR)."""
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(topic, msgtype, typestore=self._store)
        self._writer.write(self._connections[topic], stamp_ns, data)

    def write_image(self, topic: str, stamp_ns: int, frame_id: str, image: NDArray[Any]) -> None:
        """sensor_msgs/Image: (H, W) uint8 as mono8, uint16 as mono16, (H, W, 3) as bgr8."""
        height, width = image.shape[:2]
        encoding = "bgr8" if image.ndim == 3 else "mono16" if image.dtype == np.uint16 else "mono8"
        fields = {
            "header": header(stamp_ns, frame_id),
            "height": height,
            "width": width,
            "encoding": encoding,
            "is_bigendian": 0,
            "step": image.nbytes // height,
            "data": np.ascontiguousarray(image).reshape(-1).view(np.uint8),
        }
        self.write(topic, stamp_ns, Message("sensor_msgs/msg/Image", fields))

    def write_jpeg(self, topic: str, stamp_ns: int, frame_id: str, image: NDArray[np.uint8]) -> None:
        """sensor_msgs/CompressedImage of a (H, W, 3) BGR image."""
        _, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
        self.write_encoded(topic, stamp_ns, frame_id, "bgr8; jpeg compressed bgr8", data.reshape(-1))

    def write_encoded(self, topic: str, stamp_ns: int, frame_id: str, image_format: str, data: Any) -> None:
        """sensor_msgs/CompressedImage of encoded bytes."""
        pixels = np.frombuffer(data, np.uint8)
        fields = {"header": header(stamp_ns, frame_id), "format": image_format, "data": pixels}
        self.write(topic, stamp_ns, Message("sensor_msgs/msg/CompressedImage", fields))

    def write_camera(self, topic: str, stamp_ns: int, camera: Camera) -> None:
        """sensor_msgs/CameraInfo of an unrectified camera."""
        fields = {
            "header": header(stamp_ns, camera.frame_id),
            "width": camera.size[0],
            "height": camera.size[1],
            "distortion_model": "rational_polynomial" if camera.distortion.size > 5 else "plumb_bob",
            "d": camera.distortion if camera.distortion.size else np.zeros(5),
            "k": camera.matrix.reshape(-1),
            "r": np.eye(3).reshape(-1),
            "p": np.column_stack([camera.matrix, np.zeros(3)]).reshape(-1),
        }
        self.write(topic, stamp_ns, Message("sensor_msgs/msg/CameraInfo", fields))

    def write_poses(self, topic: str, stamp_ns: int, frame_id: str, poses: Sequence[Pose]) -> None:
        """geometry_msgs/PoseArray."""
        self.write(topic, stamp_ns, pose_array(poses, header(stamp_ns, frame_id)))

    def _made(self, msgtype: str, fields: Mapping[str, Any]) -> Any:
        """The message as rosbags has it; fields that are not given are zero, empty or false."""
        content = {name: self._value(kind, fields.get(name)) for name, kind in self._store.fielddefs[msgtype][1]}
        return self._store.types[msgtype](**content)

    def _value(self, kind: Any, value: Any) -> Any:
        """`value` as a field of this kind: (node type, type's name, or (its item's kind, size))."""
        node, content = kind
        if node == Nodetype.NAME:
            return self._made(content, value.fields if value is not None else _DEFAULTS.get(content, {}))
        if node == Nodetype.BASE:
            return _PLAIN[content[0]]() if value is None else value
        item, size = content
        if item[0] == Nodetype.NAME or item[1][0] == "string":
            return [self._value(item, v) for v in value or []]
        dtype = np.dtype(item[1][0])
        return np.zeros(size, dtype) if value is None else np.asarray(value, dtype)
