"""Messages to values and values to messages. Fields are cast: rclpy sends wrong types as garbage, in silence."""

from __future__ import annotations

import array
import importlib
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from ..core.base.errors import ImageError
from ..io.messages.detection_messages import HeaderOf, Message


def stamp_ns(header: Header) -> int:
    """The stamp in nanoseconds."""
    return int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)


def image_to_msg(picture: NDArray[np.uint8], header: Header) -> Image:
    """A (H, W, 3) uint8 BGR picture as a bgr8 message."""
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3:
        raise ImageError(f"a (H, W, 3) uint8 picture is expected, not {picture.shape} {picture.dtype}")
    height, width = picture.shape[:2]
    msg = Image(header=header, height=int(height), width=int(width), encoding="bgr8", step=int(3 * width))
    msg.data = array.array("B", np.ascontiguousarray(picture).tobytes())  # other types are copied item by item
    return msg


def to_ros(message: Message) -> Any:
    """A message of `io/messages/detection_messages.py` as the ROS message of that type."""
    return message_class(message.type)(**{name: _ros_value(value) for name, value in message.fields.items()})


def _ros_value(value: Any) -> Any:
    if isinstance(value, Message):
        return to_ros(value)
    return [_ros_value(v) for v in value] if isinstance(value, list) else value


@cache
def message_class(msgtype: str) -> Any:
    """The class of a message type such as sensor_msgs/msg/Image."""
    package, _, name = msgtype.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def header_of(header: Header) -> HeaderOf:
    """Headers with the same stamp and other frames."""
    return lambda frame_id: Header(stamp=header.stamp, frame_id=frame_id)
