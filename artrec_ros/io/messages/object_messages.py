"""All that is said of one object name in an image, topic by topic: the node publishes it, a result bag holds it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from ...core.model.found import Detection
from . import node_topics as topics
from .detection_messages import HeaderOf, Message, best_pose, classes, detected_poses, joint_states, robots
from .image_messages import image_components, image_frame, image_poses, image_robots
from .node_topics import NodeTopic

Maker = Callable[[Sequence[Detection], str, HeaderOf], Iterator[Message]]
"""The messages of a topic: of an object name's detections in an image, that image's frame_id, and its headers."""


def _by_frame(detections: Sequence[Detection], frame_id: str) -> dict[str, list[Detection]]:
    """The detections that have a pose, by the frame in which it is; without any, none of the image's frame."""
    found: dict[str, list[Detection]] = {}
    for d in detections:
        if d.pose is not None:
            found.setdefault(d.frame_id or frame_id, []).append(d)
    return found or {frame_id: []}


def _in_space(make: Callable[[Sequence[Detection], Any], Message]) -> Maker:
    """A message for each frame in which there are poses, or an empty one."""

    def messages(detections: Sequence[Detection], frame_id: str, header_of: HeaderOf) -> Iterator[Message]:
        for frame, own in _by_frame(detections, frame_id).items():
            yield make(own, header_of(frame))

    return messages


def _once(make: Callable[[Sequence[Detection], Any], Message], frame: Callable[[str], str] = str) -> Maker:
    """One message, in a frame that follows from the image's."""

    def messages(detections: Sequence[Detection], frame_id: str, header_of: HeaderOf) -> Iterator[Message]:
        yield make(detections, header_of(frame(frame_id)))

    return messages


def _best(detections: Sequence[Detection], frame_id: str, header_of: HeaderOf) -> Iterator[Message]:
    message = best_pose(detections, frame_id, header_of)
    if message is not None:
        yield message


OBJECT_MAKERS: Mapping[NodeTopic, Maker] = {
    topics.POSES: _in_space(detected_poses),
    topics.ROBOTS: _in_space(robots),
    topics.JOINTS: _once(joint_states),
    topics.POSE: _best,
    topics.CLASSES: _once(classes),
    topics.IMAGE_POSES: _once(image_poses, image_frame),
    topics.IMAGE_ROBOTS: _once(image_robots, image_frame),
    topics.IMAGE_COMPONENTS: _once(image_components, image_frame),
}
