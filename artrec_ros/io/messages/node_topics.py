"""The node's topics, once: the node makes its subscriptions and publishers from them, and docs/topics.md its tables."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class NodeTopic:
    """One topic.

    :param name: relative to the node's namespace; {object} stands for the name of each object.
    :param type: such as sensor_msgs/msg/Image.
    :param meaning: when a message comes and what it holds.
    :param depth: messages that a publisher keeps for slow subscribers, or that a subscription queues.
    """

    name: str
    type: str
    meaning: str
    depth: int = 10

    def of(self, name: str) -> str:
        """The topic's name for one object."""
        return self.name.format(object=name)


IMAGE = NodeTopic(
    "image",
    "sensor_msgs/msg/Image",
    "what is looked at: mono8, mono16, bgr8, rgb8, bgra8, rgba8, or 8UC1, 16UC1, 8UC3",
    1,
)
COMPRESSED = NodeTopic(
    "image/compressed",
    "sensor_msgs/msg/CompressedImage",
    "in place of `image` where `image_transport` is `compressed`: PNG, JPEG, WebP or BMP",
    1,
)
CAMERA_INFO = NodeTopic(
    "camera_info",
    "sensor_msgs/msg/CameraInfo",
    "the calibration; of those of the image's camera (`frame_id`) the one with its stamp, else the newest; without it "
    "there are no metric poses but those on `scene.plane`",
)
INPUTS = (IMAGE, COMPRESSED, CAMERA_INFO)

POSES = NodeTopic(
    "{object}/poses",
    "geometry_msgs/msg/PoseArray",
    "for every image, empty too: all objects of this name whose pose in space is known, metres",
)
ROBOTS = NodeTopic(
    "{object}/robots",
    "sensor_msgs/msg/MultiDOFJointState",
    "for every image: the same poses, with names such as `red_0`, and how fast they change, in one message",
)
JOINTS = NodeTopic(
    "{object}/joint_states",
    "sensor_msgs/msg/JointState",
    "for every image: the joints in view of all of them, `red_0/front_left`, in radians (metres where prismatic), and "
    "their rates",
)
POSE = NodeTopic(
    "{object}/pose",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "only when seen: the pose in space with the best score, and its covariance",
)
IMAGE_POSES = NodeTopic(
    "{object}/image_poses",
    "geometry_msgs/msg/PoseArray",
    "for every image, empty too: every object of this name that was found, with or without calibration: x, y in "
    "pixels, yaw is `theta`; in the image's own frame",
)
IMAGE_ROBOTS = NodeTopic(
    "{object}/image_robots",
    "sensor_msgs/msg/MultiDOFJointState",
    "for every image: the same in the same order, with names such as `red_0`",
)
IMAGE_COMPONENTS = NodeTopic(
    "{object}/image_components",
    "sensor_msgs/msg/MultiDOFJointState",
    "for every image: the components found of all of them, each by the marker that shows it, `red_0/torso/frontal`; "
    "pixels as before",
)
CLASSES = NodeTopic(
    "{object}/classes",
    "diagnostic_msgs/msg/DiagnosticArray",
    "for every image: a status for each object that has classes of configurations: its name is `red_0`, its message "
    "the class, empty where it is of none; values: confidence, runner_up, runner_up_confidence, and why it is of none",
)
MARKERS = NodeTopic(
    "markers",
    "visualization_msgs/msg/MarkerArray",
    "for RViz: outlines of the markers found, each object's frame, name, score and class; what vanished is deleted; of "
    "objects without a pose in space, in the image's own frame",
)
OVERLAY = NodeTopic(
    "debug/image",
    "sensor_msgs/msg/Image",
    "bgr8, made only while somebody subscribes: outlines, axes, frames, names, scores; faint, the best candidates that "
    "were turned down, and why",
    1,
)
LABELS = NodeTopic(
    "debug/labels",
    "sensor_msgs/msg/Image",
    "bgr8, made only while somebody subscribes: what the recogniser saw, each class in the colour that it is named "
    "after, or one of its own; dark: background, unknown, blanked",
    1,
)
DIAGNOSTICS = NodeTopic(
    "/diagnostics",
    "diagnostic_msgs/msg/DiagnosticArray",
    "every second: rates, latencies, drops, the last error; tells apart no images, QoS mismatch, images that cannot be "
    "used, no calibration, nothing found",
)
TF = NodeTopic(
    "/tf",
    "tf2_msgs/msg/TFMessage",
    "where `publish_tf` is set: the frame of each object whose pose in space is known, a child of that pose's frame",
)
OBJECT_OUTPUTS = (POSES, ROBOTS, JOINTS, POSE, CLASSES, IMAGE_POSES, IMAGE_ROBOTS, IMAGE_COMPONENTS)
OUTPUTS = (*OBJECT_OUTPUTS, MARKERS, OVERLAY, LABELS, DIAGNOSTICS)
