"""Messages to values and values to messages. Fields are cast: rclpy sends wrong types as garbage, in silence."""

from __future__ import annotations

import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import Pose as PoseMsg
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped, Transform
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, JointState, MultiDOFJointState
from std_msgs.msg import Header

from ..core.datatypes import Camera, Detection
from ..core.errors import ImageError
from ..core.transforms import Pose
from ..io.cameras import camera_from_info
from ..io.images import decode_compressed, decode_image


def image_from_msg(msg: Image | CompressedImage) -> NDArray[Any]:
    """The pixels: (H, W) class numbers, or (H, W, 3) uint8 BGR.

    :raises ImageError: the message cannot be an image.
    """
    if isinstance(msg, CompressedImage):
        return decode_compressed(msg.format, msg.data)
    return decode_image(msg.encoding, msg.height, msg.width, msg.step, bool(msg.is_bigendian), msg.data)


def camera_from_msg(msg: CameraInfo) -> Camera:
    """The camera of the image beside it.

    :raises ConfigError: there is no calibration in it, or one that is not supported.
    """
    return camera_from_info(
        msg.width,
        msg.height,
        msg.k,
        msg.d,
        msg.distortion_model,
        msg.header.frame_id,
        binning=(msg.binning_x, msg.binning_y),
        roi=(msg.roi.x_offset, msg.roi.y_offset, msg.roi.width, msg.roi.height),
    )


def image_to_msg(picture: NDArray[np.uint8], header: Header) -> Image:
    """A (H, W, 3) uint8 BGR picture as a bgr8 message."""
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3:
        raise ImageError(f"a (H, W, 3) uint8 picture is expected, not {picture.shape} {picture.dtype}")
    height, width = picture.shape[:2]
    msg = Image(header=header, height=int(height), width=int(width), encoding="bgr8", step=int(3 * width))
    msg.data = array.array("B", np.ascontiguousarray(picture).tobytes())  # other types are copied item by item
    return msg


def instance_name(detection: Detection) -> str:
    """What an object is called in messages: red_0."""
    return f"{detection.object}_{detection.id}"


def pose_to_msg(pose: Pose) -> PoseMsg:
    msg = PoseMsg()
    msg.position.x, msg.position.y, msg.position.z = (float(v) for v in pose.position)
    q = msg.orientation
    q.x, q.y, q.z, q.w = (float(v) for v in pose.quaternion)
    return msg


def pose_array(detections: Sequence[Detection], header: Header) -> PoseArray:
    """The metric poses, in the detections' order."""
    return PoseArray(header=header, poses=[pose_to_msg(d.pose) for d in detections if d.pose is not None])


def robots(detections: Sequence[Detection], header: Header) -> MultiDOFJointState:
    """The same poses with names, in one message."""
    msg = MultiDOFJointState(header=header)
    for detection in detections:
        if detection.pose is None:
            continue
        pose = pose_to_msg(detection.pose)
        transform = Transform(rotation=pose.orientation)
        t, p = transform.translation, pose.position
        t.x, t.y, t.z = p.x, p.y, p.z
        msg.joint_names.append(instance_name(detection))
        msg.transforms.append(transform)
    return msg


def joint_states(detections: Sequence[Detection], header: Header) -> JointState:
    """The joints of all objects; names red_0/front_left, radians (metres where a joint is prismatic)."""
    msg = JointState(header=header)
    joints = [(f"{instance_name(d)}/{joint}", float(q)) for d in detections for joint, q in d.joints.items()]
    msg.name = [name for name, _ in joints]
    msg.position = [q for _, q in joints]
    return msg


def best_pose(detections: Sequence[Detection], header: Header) -> PoseWithCovarianceStamped | None:
    """The pose with the best score among those whose covariance is known; None: there is none."""
    known = [d for d in detections if d.pose is not None and d.pose_covariance is not None]
    if not known:
        return None
    best = max(known, key=lambda d: d.score)
    msg = PoseWithCovarianceStamped(header=header)
    assert best.pose is not None and best.pose_covariance is not None
    msg.pose.pose = pose_to_msg(best.pose)
    msg.pose.covariance = np.asarray(best.pose_covariance, np.float64).reshape(36)
    return msg
