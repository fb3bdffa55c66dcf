"""What the node says of detections, as plain values: the node makes ROS messages of them, `BagWriter` those of a bag.

Types and fields are those of ROS 2's common_interfaces; fields that are left out keep the type's default.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...core.geometry.transforms import Array, Pose
from ...core.model.found import ClassFit, Detection


@dataclass(frozen=True)
class Message:
    """A message: its type, spelt package/msg/Name, and its fields: plain values, Messages, lists of either.

    A field may hold what only one side understands, such as the header of a ROS message; it is passed on as it is.
    """

    type: str
    fields: Mapping[str, Any]


_NO_TWIST = np.full(6, np.nan)

HeaderOf = Callable[[str], Any]
"""A header with the image's stamp and this frame_id."""


def header(stamp_ns: int, frame_id: str) -> Message:
    stamp = Message("builtin_interfaces/msg/Time", {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9})
    return Message("std_msgs/msg/Header", {"stamp": stamp, "frame_id": frame_id})


def instance_name(detection: Detection) -> str:
    """What an object is called in messages: red_0, or yellow_gr."""
    return detection.name


def xyz(values: Sequence[float] | Any, kind: str = "Point") -> Message:
    """geometry_msgs/Point, or Vector3."""
    return Message(f"geometry_msgs/msg/{kind}", dict(zip("xyz", map(float, values), strict=True)))


def quaternion(pose: Pose) -> Message:
    return Message("geometry_msgs/msg/Quaternion", dict(zip("xyzw", map(float, pose.quaternion), strict=True)))


def pose_message(pose: Pose) -> Message:
    """geometry_msgs/Pose."""
    return Message("geometry_msgs/msg/Pose", {"position": xyz(pose.position), "orientation": quaternion(pose)})


def _transform_message(pose: Pose) -> Message:
    """geometry_msgs/Transform."""
    fields = {"translation": xyz(pose.position, "Vector3"), "rotation": quaternion(pose)}
    return Message("geometry_msgs/msg/Transform", fields)


def object_frames(
    detections: Sequence[Detection], frame_id: str, header_of: HeaderOf, prefix: str = ""
) -> list[Message]:
    """TransformStamped of each object's frame, a child of that in which its pose is, as tf has them.

    :param frame_id: the image's: where a detection tells no frame, its pose is in this one. tf knows no empty one.
    :param prefix: of the children's names.
    """
    return [
        Message(
            "geometry_msgs/msg/TransformStamped",
            {
                "header": header_of(parent),
                "child_frame_id": prefix + instance_name(d),
                "transform": _transform_message(pose),
            },
        )
        for d in detections
        if (pose := d.told_pose) is not None and (parent := d.frame_id or frame_id)
    ]


def _twist_message(twist: Array) -> Message:
    """geometry_msgs/Twist. :param twist: (6,) along x, y, z, then about them."""
    fields = {"linear": xyz(twist[:3], "Vector3"), "angular": xyz(twist[3:], "Vector3")}
    return Message("geometry_msgs/msg/Twist", fields)


def pose_array(poses: Sequence[Pose], header: Any) -> Message:
    return Message("geometry_msgs/msg/PoseArray", {"header": header, "poses": [pose_message(p) for p in poses]})


def detected_poses(detections: Sequence[Detection], header: Any) -> Message:
    """PoseArray of the metric poses, in the detections' order."""
    return pose_array([pose for d in detections if (pose := d.told_pose) is not None], header)


def robots(detections: Sequence[Detection], header: Any) -> Message:
    """MultiDOFJointState: the same poses with names, in one message, and, where any is known, how fast they change; NaN
    is what is not known."""
    posed = [(d, pose) for d in detections if (pose := d.told_pose) is not None]
    fields: dict[str, Any] = {"header": header, "joint_names": [instance_name(d) for d, _ in posed]}
    fields["transforms"] = [_transform_message(pose) for _, pose in posed]
    if any(d.motion is not None for d, _ in posed):
        fields["twist"] = [_twist_message(_NO_TWIST if d.motion is None else d.motion.twist) for d, _ in posed]
    return Message("sensor_msgs/msg/MultiDOFJointState", fields)


def joint_states(detections: Sequence[Detection], header: Any) -> Message:
    """JointState: the joints of all objects; names red_0/front_left, radians (metres where a joint is prismatic), and,
    where any is known, their rates; NaN is what is not known."""
    each = [(d, joint, q) for d in detections for joint, q in d.told_joints.items()]
    rates = [float("nan") if d.motion is None else d.motion.joints.get(joint, float("nan")) for d, joint, _ in each]
    names, values = [f"{instance_name(d)}/{joint}" for d, joint, _ in each], [float(q) for _, _, q in each]
    fields: dict[str, Any] = {"header": header, "name": names, "position": values}
    if not all(rate != rate for rate in rates):
        fields["velocity"] = [float(rate) for rate in rates]
    return Message("sensor_msgs/msg/JointState", fields)


def classes(detections: Sequence[Detection], header: Any) -> Message:
    """DiagnosticArray: the class of each object that has classes; the message is empty where it is of none."""
    status = [_class_status(instance_name(d), d.class_fit) for d in detections if d.class_fit is not None]
    return Message("diagnostic_msgs/msg/DiagnosticArray", {"header": header, "status": status})


def _class_status(name: str, fit: ClassFit) -> Message:
    values = {"confidence": f"{fit.confidence:.4f}", "runner_up": fit.runner_up or ""}
    values["runner_up_confidence"] = f"{fit.runner_up_confidence:.4f}"
    if fit.name is None:
        values["reason"] = fit.reason
    pairs = [Message("diagnostic_msgs/msg/KeyValue", {"key": k, "value": v}) for k, v in values.items()]
    return Message("diagnostic_msgs/msg/DiagnosticStatus", {"name": name, "message": fit.name or "", "values": pairs})


def best_pose(detections: Sequence[Detection], frame_id: str, header_of: HeaderOf) -> Message | None:
    """PoseWithCovarianceStamped: the best score among those seen whose covariance is known; None: there is none.

    :param frame_id: the image's.
    """
    known = [d for d in detections if d.pose is not None and d.pose_covariance is not None and not d.predicted]
    if not known:
        return None
    best = max(known, key=lambda d: d.score)
    told = best.told_pose
    assert told is not None
    covariance = best.pose_covariance if best.filtered is None else best.filtered.covariance
    pose = {"pose": pose_message(told), "covariance": np.asarray(covariance, np.float64).reshape(36)}
    fields = {"header": header_of(best.frame_id or frame_id)}
    fields["pose"] = Message("geometry_msgs/msg/PoseWithCovariance", pose)
    return Message("geometry_msgs/msg/PoseWithCovarianceStamped", fields)
