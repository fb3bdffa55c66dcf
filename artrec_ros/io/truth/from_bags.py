"""Truth from a bag: PoseArray topics, one for each object name, in the camera's optical frame."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...core.base.errors import ConfigError, ImageError, SourceError
from ...core.geometry.camera import Camera
from ...core.geometry.transforms import Pose, rotation_from_quaternion
from ..bags.reader import Bag
from ..bags.topics import camera_of, listed
from .records import FrameKey, Told, TrueObject, Truth

_POSE_ARRAY = "geometry_msgs/msg/PoseArray"
_CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
_PREFERRED = "/ground_truth/"


def load_pose_truth(path: Path, topics: Sequence[str]) -> Truth:
    """The poses of a bag's PoseArray topics; .../NAME/poses holds the objects called NAME.

    :param topics: which ones; none named: those under /ground_truth/, else all, if each name is there once.
    :raises SourceError: no such topic, two topics of one name, a message that cannot be read.
    """
    frames: dict[FrameKey, tuple[TrueObject, ...]] = {}
    frame_ids: set[str] = set()
    with Bag(path) as bag:
        names = {topic: object_name(topic) for topic in _choose(bag, topics)}
        for message in bag.messages(names):
            try:
                content = bag.parse(message)
                objects = tuple(_object(p, names[message.topic]) for p in content.poses)
            except (ImageError, ValueError) as error:
                raise SourceError(f"{path}: topic {message.topic}: {error}") from error
            stamp_ns = bag.head(message).stamp_ns
            frames[stamp_ns] = frames.get(stamp_ns, ()) + objects
            frame_ids.add(content.header.frame_id)
        camera = _camera(bag)
        problems = bag.problems
    if not frames:
        raise SourceError(f"{problems[0] if problems else path}: {', '.join(names)}: no message in it")
    if len(frame_ids) > 1:
        raise SourceError(f"{path}: the poses are in different frames: {', '.join(sorted(map(repr, frame_ids)))}")
    source, (frame_id,) = f"{path} ({', '.join(names)})", frame_ids
    return Truth(dict(sorted(frames.items())), source, camera, frame_id, problems=tuple(problems))


def object_name(topic: str) -> str:
    """'red' of '/ground_truth/red/poses'; of a topic with another ending, its last part."""
    *before, last = [part for part in topic.split("/") if part]
    return before[-1] if last == "poses" and before else last


def _choose(bag: Bag, topics: Sequence[str]) -> list[str]:
    there = sorted(t.name for t in bag.topics.values() if t.msgtype == _POSE_ARRAY)
    for topic in topics:
        if topic not in there:
            raise SourceError(f"{bag.path}: no PoseArray topic '{topic}' ({', '.join(there) or listed(bag)})")
    if not there:
        raise SourceError(f"{bag.path}: no truth: it holds no topic of {_POSE_ARRAY}. {listed(bag)}")
    chosen = list(topics) or [t for t in there if t.startswith(_PREFERRED)] or there
    names = [object_name(topic) for topic in chosen]
    if twice := [t for t in chosen if names.count(object_name(t)) > 1]:
        raise SourceError(f"{bag.path}: {' and '.join(twice)} hold objects of one name; choose with --truth-topic")
    return chosen


def _object(pose: Any, name: str) -> TrueObject:
    p, q = pose.position, pose.orientation
    position, quaternion = np.array([p.x, p.y, p.z]), np.array([q.x, q.y, q.z, q.w])
    if not np.isfinite([*position, *quaternion]).all() or np.linalg.norm(quaternion) < 1e-6:
        raise ValueError(f"a pose of '{name}' is none: position {position}, orientation {quaternion}")
    T_camera_object = Pose(rotation_from_quaternion(quaternion), position)
    return TrueObject(None, T_camera_object, {}, None, name, told=Told.REQUIRED)


def _camera(bag: Bag) -> Camera | None:
    """The first calibration of the bag, if all its calibration topics are of one camera."""
    topics = [t.name for t in bag.topics.values() if t.msgtype == _CAMERA_INFO and t.count]
    if len(topics) != 1:
        return None
    message = next(bag.messages(topics), None)
    try:
        return camera_of(bag.parse(message)) if message is not None else None
    except (ImageError, ConfigError):
        return None  # asked for where it is needed: evaluation says how to give one
