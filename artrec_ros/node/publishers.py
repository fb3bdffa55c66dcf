"""The topics of each object, and the markers of all."""

from __future__ import annotations

from collections.abc import Sequence

from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState, MultiDOFJointState
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from ..core.datatypes import Detection, Target
from .conversions import best_pose, joint_states, pose_array, robots
from .markers import MarkerScene

_DEPTH = 10


class ObjectPublishers:
    """Publishes one frame's detections, each message with the image's header."""

    def __init__(self, node: Node, targets: Sequence[Target]) -> None:
        names = [t.name for t in targets]
        self._poses = {n: node.create_publisher(PoseArray, f"{n}/poses", _DEPTH) for n in names}
        self._robots = {n: node.create_publisher(MultiDOFJointState, f"{n}/robots", _DEPTH) for n in names}
        self._joints = {n: node.create_publisher(JointState, f"{n}/joint_states", _DEPTH) for n in names}
        self._best = {n: node.create_publisher(PoseWithCovarianceStamped, f"{n}/pose", _DEPTH) for n in names}
        self._markers = node.create_publisher(MarkerArray, "markers", _DEPTH)
        self._scene = MarkerScene(targets)

    def publish(self, detections: Sequence[Detection], header: Header) -> None:
        """`poses`, `robots` and `joint_states` for every image, empty too; `pose` only where one is known."""
        for name in self._poses:
            own = [d for d in detections if d.object == name]
            self._poses[name].publish(pose_array(own, header))
            self._robots[name].publish(robots(own, header))
            self._joints[name].publish(joint_states(own, header))
            best = best_pose(own, header)
            if best is not None:
                self._best[name].publish(best)
        self._markers.publish(self._scene.update(detections, header))
