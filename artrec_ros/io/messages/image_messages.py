"""What the node says of objects as the image shows them: pixels, not metres, in a frame of the image's own.

That frame is called after the camera's with `_image` behind it. Its origin is the centre of the first pixel, x runs to
the right, y down, z into the picture; its unit is the pixel. No transform leads there from the camera's frame, for none
could: pixels are no place in space. Viewers that have it as their fixed frame draw a pixel as a metre.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ...core.model.found import Detection, ImagePose, Instance
from .detection_messages import Message, instance_name, xyz

_SUFFIX = "_image"


def image_frame(frame_id: str) -> str:
    """The frame of an image in pixels, from that of its header."""
    return f"{frame_id}{_SUFFIX}" if frame_id else _SUFFIX.strip("_")


def turn_in_image(theta: float) -> Message:
    """geometry_msgs/Quaternion of a direction in the image: about z, from x towards y."""
    fields = {"x": 0.0, "y": 0.0, "z": math.sin(theta / 2), "w": math.cos(theta / 2)}
    return Message("geometry_msgs/msg/Quaternion", fields)


def image_poses(detections: Sequence[Detection], header: Any) -> Message:
    """PoseArray: x, y in pixels, yaw is theta; of every detection, in their order."""
    poses = [
        Message(
            "geometry_msgs/msg/Pose",
            {"position": _place(d.image, "Point"), "orientation": turn_in_image(d.image.theta)},
        )
        for d in detections
    ]
    return Message("geometry_msgs/msg/PoseArray", {"header": header, "poses": poses})


def image_robots(detections: Sequence[Detection], header: Any) -> Message:
    """MultiDOFJointState: the same with names, red_0."""
    return _named([(instance_name(d), d.image) for d in detections], header)


def image_components(detections: Sequence[Detection], header: Any) -> Message:
    """MultiDOFJointState: each component that was found, by the marker that shows it, red_0/torso/frontal."""
    parts = [(f"{instance_name(d)}/{c.component}/{c.marker}", c) for d in detections for c in d.components]
    return _named(parts, header)


def _named(places: Sequence[tuple[str, ImagePose | Instance]], header: Any) -> Message:
    transforms = [
        Message(
            "geometry_msgs/msg/Transform",
            {"translation": _place(place, "Vector3"), "rotation": turn_in_image(place.theta)},
        )
        for _, place in places
    ]
    fields = {"header": header, "joint_names": [name for name, _ in places], "transforms": transforms}
    return Message("sensor_msgs/msg/MultiDOFJointState", fields)


def _place(place: ImagePose | Instance, kind: str) -> Message:
    return xyz((place.x, place.y, 0.0), kind)
