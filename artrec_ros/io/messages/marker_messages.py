"""What RViz and Foxglove show: outlines of the found markers, the object's frame, its name and score."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ...core.drawing import class_text, object_colour
from ...core.geometry.transforms import Pose
from ...core.model.found import Detection
from ...core.model.kinematics import Kinematics
from ...core.model.objects import ObjectModel
from ...core.model.target import Target
from .detection_messages import Message, instance_name, pose_message, xyz

# visualization_msgs/Marker
LINE_STRIP, LINE_LIST, TEXT_VIEW_FACING = 4, 5, 9
ADD, DELETE = 0, 2

_LINE_M = 0.004
_FRAME_M = 0.08
_TEXT_M = 0.05
_AXIS_COLOURS = ((1.0, 0.0, 0.0), (0.0, 0.8, 0.0), (0.2, 0.4, 1.0))  # x, y, z as RViz draws them

Colour = tuple[float, float, float]
HeaderOf = Callable[[str], Any]
"""The frame's stamp with a frame_id, as a header."""


class MarkerScene:
    """Turns each frame's detections into markers whose (ns, id) stay, and deletes only those that vanished."""

    def __init__(self, targets: Sequence[Target]) -> None:
        self._models = {t.name: t.model for t in targets}
        self._kinematics = {t.name: Kinematics(t.model) for t in targets}
        self._names = [t.name for t in targets]
        self._shown: dict[tuple[str, int], str] = {}  # (ns, id) -> frame

    def update(self, detections: Sequence[Detection], frame_id: str, header_of: HeaderOf) -> Message:
        """MarkerArray of this frame, with deletions of what the last one showed and this one does not."""
        header = header_of(frame_id)
        markers = [m for d in detections if d.pose is not None for m in self._object(d, d.pose, header)]
        now = {(m.fields["ns"], m.fields["id"]): frame_id for m in markers}
        gone = [_deletion(key, header_of(frame)) for key, frame in self._shown.items() if key not in now]
        self._shown = now
        return Message("visualization_msgs/msg/MarkerArray", {"markers": [*gone, *markers]})

    def _object(self, detection: Detection, pose: Pose, header: Any) -> Iterable[Message]:
        blue, green, red = object_colour(self._names, detection.object)
        colour = (red / 255, green / 255, blue / 255)
        yield _frame(detection, pose, header)
        yield _name(detection, pose, header, colour)
        model = self._models[detection.object]
        if not model.is_spatial:
            return
        slots = marker_slots(model)
        found = sorted({slots[i.component, i.marker] for i in detection.components})
        frames = component_frames(self._kinematics[detection.object], pose, detection.joints)
        keys = list(slots)
        for slot in found:
            component, marker = keys[slot]
            place = model.component(component).marker(marker)
            points = np.column_stack([place.outline, np.zeros(len(place.outline))])
            assert place.T_component_marker is not None
            line = frames[component].apply(place.T_component_marker.apply(points))
            fields: dict[str, Any] = {"type": LINE_STRIP, "scale": _line_scale()}
            fields["points"] = [xyz(p) for p in (*line, line[0])]
            number = detection.id * len(slots) + slot
            yield _marker(f"{detection.object}/outline", number, header, colour, **fields)


def marker_slots(model: ObjectModel) -> dict[tuple[str, str], int]:
    """A fixed number for each (component, marker) of a model."""
    pairs = [(c.name, m.name) for c in model.components for m in c.markers]
    return {pair: i for i, pair in enumerate(pairs)}


def component_frames(kinematics: Kinematics, pose: Pose, joints: dict[str, float]) -> dict[str, Pose]:
    """T_camera_component of each component; a joint that was not seen is drawn in its middle."""
    middle = (kinematics.lower + kinematics.upper) / 2
    names = kinematics.model.joint_names
    q = np.array([joints.get(name, m) for name, m in zip(names, middle, strict=True)])
    frames = kinematics.forward(pose.rotation[None], pose.position[None], q[None])
    return {c.name: Pose(frames.R[0, i], frames.t[0, i]) for i, c in enumerate(kinematics.model.components)}


def _frame(detection: Detection, pose: Pose, header: Any) -> Message:
    ends = [p for axis in np.eye(3) * _FRAME_M for p in (xyz((0, 0, 0)), xyz(axis))]
    colours = [_colour(c) for c in _AXIS_COLOURS for _ in range(2)]
    fields: dict[str, Any] = {"type": LINE_LIST, "scale": _line_scale(), "points": ends, "colors": colours}
    ns = f"{detection.object}/frame"
    return _marker(ns, detection.id, header, (1.0, 1.0, 1.0), pose_message(pose), **fields)


def _name(detection: Detection, pose: Pose, header: Any, colour: Colour) -> Message:
    above = Pose(np.eye(3), pose.position + (0, -2 * _TEXT_M, 0))  # the optical frame's y is down
    text = f"{instance_name(detection)} {detection.score:.2f}{class_text(detection)}"
    fields: dict[str, Any] = {"type": TEXT_VIEW_FACING, "scale": xyz((0, 0, _TEXT_M), "Vector3"), "text": text}
    return _marker(f"{detection.object}/name", detection.id, header, colour, pose_message(above), **fields)


def _marker(ns: str, number: int, header: Any, colour: Colour, pose: Message | None = None, **fields: Any) -> Message:
    placed = pose or pose_message(Pose(np.eye(3), np.zeros(3)))
    number = int(number) % 2**31  # the message's id is an int32; objects' ids are never given twice
    common = {"header": header, "ns": ns, "id": number, "action": ADD, "color": _colour(colour), "pose": placed}
    return Message("visualization_msgs/msg/Marker", {**common, **fields})


def _deletion(key: tuple[str, int], header: Any) -> Message:
    fields = {"header": header, "ns": key[0], "id": key[1], "action": DELETE}
    return Message("visualization_msgs/msg/Marker", fields)


def _line_scale() -> Message:
    return xyz((_LINE_M, 0, 0), "Vector3")


def _colour(rgb: Colour) -> Message:
    return Message("std_msgs/msg/ColorRGBA", {**dict(zip("rgb", map(float, rgb), strict=True)), "a": 1.0})
