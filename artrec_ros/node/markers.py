"""The markers of `io/messages/marker_messages.py` as ROS messages."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.duration import Duration
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from ..core.model.found import Detection
from ..core.model.target import Target
from ..io.messages import marker_messages
from .conversions import header_of, to_ros


class MarkerScene:
    """Turns each frame's detections into markers whose (ns, id) stay, and deletes only those that vanished."""

    def __init__(self, targets: Sequence[Target]) -> None:
        self._scene = marker_messages.MarkerScene(targets)

    def update(self, detections: Sequence[Detection], header: Header, lifetime_s: float = 0.0) -> MarkerArray:
        """The markers of this frame, and deletions of what the last one showed and this one does not.

        :param lifetime_s: RViz drops what is not renewed for so long, as when the node dies; 0: never.
        """
        scene: MarkerArray = to_ros(self._scene.update(detections, header.frame_id, header_of(header)))
        lifetime = Duration(seconds=lifetime_s).to_msg()
        for marker in scene.markers:
            marker.lifetime = lifetime
        return scene
