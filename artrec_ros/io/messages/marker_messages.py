"""What RViz and Foxglove show: outlines of the found markers, the object's frame, its name and score."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np

from ...core.canvas import class_text
from ...core.drawing import object_colour
from ...core.geometry.polygons import in_space
from ...core.geometry.transforms import Array, Pose
from ...core.model.found import Detection
from ...core.model.kinematics import Kinematics
from ...core.model.objects import ObjectModel
from ...core.model.target import Target
from .detection_messages import HeaderOf, Message, instance_name, pose_message, xyz
from .image_messages import image_frame, turn_in_image

# visualization_msgs/Marker
SPHERE, LINE_STRIP, LINE_LIST, TEXT_VIEW_FACING = 2, 4, 5, 9
ADD, DELETE = 0, 2

_AXIS_COLOURS = ((1.0, 0.0, 0.0), (0.0, 0.8, 0.0), (0.2, 0.4, 1.0))  # x, y, z as RViz draws them

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Sizes:
    """Of lines, frames' axes and letters, in the unit of the frame in which they are drawn."""

    line: float
    frame: float
    text: float


_FAINT = 0.35  # opacity of what is not seen but expected
_METRES, _PIXELS = Sizes(0.004, 0.08, 0.05), Sizes(1.0, 20.0, 10.0)


@dataclass(frozen=True)
class Drawn:
    """Where and how an object is drawn.

    :param pose: of its frame. :param above: where its name stands. :param opacity: 0 to 1.
    """

    header: Any
    pose: Message
    above: Message
    sizes: Sizes
    colour: Colour
    opacity: float = 1.0


class MarkerScene:
    """Turns each frame's detections into markers whose (ns, id) stay, and deletes only those that vanished."""

    def __init__(self, targets: Sequence[Target]) -> None:
        self._models = {t.name: t.model for t in targets}
        self._kinematics = {t.name: Kinematics(t.model) for t in targets}
        self._solids = {t.name: t.solids for t in targets}
        self._names = [t.name for t in targets]
        self._shown: dict[tuple[str, int], str] = {}  # (ns, id) -> frame

    def update(self, detections: Sequence[Detection], frame_id: str, header_of: HeaderOf) -> Message:
        """MarkerArray of this frame, with deletions of what the last one showed and this one does not.

        An object without a pose in space is drawn in the image's own frame, in pixels.
        """
        shown: dict[tuple[str, int], str] = {}
        markers = []
        for d in detections:
            frame = image_frame(frame_id) if d.pose is None else d.frame_id or frame_id
            own = list(self._object(d, self._drawn(d, header_of(frame))))
            shown |= {(m.fields["ns"], m.fields["id"]): frame for m in own}
            markers += own
        gone = [_deletion(key, header_of(frame)) for key, frame in self._shown.items() if key not in shown]
        self._shown = shown
        return Message("visualization_msgs/msg/MarkerArray", {"markers": [*gone, *markers]})

    def _drawn(self, detection: Detection, header: Any) -> Drawn:
        blue, green, red = object_colour(self._names, detection.object)
        colour = (red / 255, green / 255, blue / 255)
        told = detection.told_pose
        if told is None:
            image, sizes = detection.image, _PIXELS
            place = xyz((image.x, image.y, 0.0))
            fields = {"position": place, "orientation": turn_in_image(image.theta)}
            pose = Message("geometry_msgs/msg/Pose", fields)
            above = np.array([image.x, image.y, 0.0])
        else:
            pose, above, sizes = pose_message(told), told.position, _METRES
        name_at = pose_message(Pose(np.eye(3), above + (0, -2 * sizes.text, 0)))
        return Drawn(header, pose, name_at, sizes, colour, _FAINT if detection.predicted else 1.0)

    def _object(self, detection: Detection, drawn: Drawn) -> Iterable[Message]:
        yield _frame(detection, drawn)
        yield _name(detection, drawn)
        slots = _marker_slots(self._models[detection.object])
        for slot, line in sorted(((slots[key], line) for key, line in self._outlines(detection)), key=itemgetter(0)):
            fields: dict[str, Any] = {"type": LINE_STRIP, "scale": _line_scale(drawn.sizes)}
            fields["points"] = [xyz(p) for p in (*line, line[0])]
            number = detection.id * len(slots) + slot
            yield _marker(f"{detection.object}/outline", number, drawn, drawn.colour, **fields)
        for key, centre, radius_m in self._balls(detection):
            fields = {"type": SPHERE, "scale": xyz(np.full(3, 2 * radius_m), "Vector3")}
            at, number = pose_message(Pose(np.eye(3), centre)), detection.id * len(slots) + slots[key]
            yield _marker(f"{detection.object}/outline", number, drawn, drawn.colour, at, **fields)

    def _balls(self, detection: Detection) -> Iterator[tuple[tuple[str, str], Array, float]]:
        """Component and marker of those that are seen, and their centres (3,) and radii, metres."""
        model, pose = self._models[detection.object], detection.told_pose
        if pose is None or detection.pose_from != "fit":
            return
        frames = component_frames(self._kinematics[detection.object], pose, detection.told_joints)
        for c in detection.components:
            if (ball := model.component(c.component).ball) is not None:
                yield (c.component, c.marker), frames[c.component].apply(ball.centre[None])[0], ball.radius

    def _outlines(self, detection: Detection) -> Iterator[tuple[tuple[str, str], Array]]:
        """Component and marker, and (n, 3) its outline where the object is drawn."""
        model, pose = self._models[detection.object], detection.told_pose
        if pose is not None and detection.pose_from == "fit":
            frames = component_frames(self._kinematics[detection.object], pose, detection.told_joints)
            for component, marker in {(c.component, c.marker) for c in detection.components}:
                part = model.component(component)
                if part.ball is not None:
                    continue  # it has no outline in space
                for side in part.markers if component in self._solids[detection.object] else [part.marker(marker)]:
                    assert side.T_component_marker is not None  # the object was fitted
                    points = side.T_component_marker.apply(in_space(side.outline))
                    yield (component, side.name), frames[component].apply(points)
            return
        to_plane = None if pose is None else in_plane(detection, pose, model)
        if pose is not None and to_plane is None:
            return
        for c in detection.components:
            if len(c.contour):
                yield (c.component, c.marker), (in_space if to_plane is None else to_plane)(c.contour)


def in_plane(detection: Detection, pose: Pose, model: ObjectModel) -> Callable[[Array], Array] | None:
    """What brings points of the image (n, 2) to the plane of the marker that shows the required component (n, 3); None
    where that is not told.

    :param pose: the detection's.
    """
    shown = detection.instance_of(model.required.name)
    if shown is None:
        return None
    marker = model.required.marker(shown.marker)
    T = pose @ (marker.T_component_marker or Pose.identity())
    turn = shown.theta - marker.axis_angle
    c, s = np.cos(turn), np.sin(turn)

    def to_plane(pixels: Array) -> Array:
        x, y = ((pixels - (shown.x, shown.y)) / shown.scale @ np.array([[c, -s], [s, c]])).T
        on_marker = np.column_stack([x, -y]) + marker.centroid  # the image's y is down, the marker's up
        return T.apply(in_space(on_marker))

    return to_plane


def _marker_slots(model: ObjectModel) -> dict[tuple[str, str], int]:
    """A fixed number for each (component, marker) of a model."""
    return {key: i for i, key in enumerate(model.markers)}


def component_frames(kinematics: Kinematics, pose: Pose, joints: Mapping[str, float]) -> dict[str, Pose]:
    """T_camera_component of each component; a joint that was not seen is drawn in its middle."""
    names = kinematics.model.joint_names
    q = np.array([joints.get(name, middle) for name, middle in zip(names, kinematics.middle, strict=True)])
    frames = kinematics.forward(pose.rotation[None], pose.position[None], q[None])
    return {c.name: Pose(frames.R[0, i], frames.t[0, i]) for i, c in enumerate(kinematics.model.components)}


def _frame(detection: Detection, drawn: Drawn) -> Message:
    axes = np.eye(3)[: 3 if detection.pose is not None else 2] * drawn.sizes.frame
    ends = [p for axis in axes for p in (xyz((0, 0, 0)), xyz(axis))]
    colours = [_colour(c, drawn.opacity) for c in _AXIS_COLOURS[: len(axes)] for _ in range(2)]
    fields: dict[str, Any] = {"type": LINE_LIST, "scale": _line_scale(drawn.sizes), "points": ends, "colors": colours}
    return _marker(f"{detection.object}/frame", detection.id, drawn, (1.0, 1.0, 1.0), drawn.pose, **fields)


def _name(detection: Detection, drawn: Drawn) -> Message:
    text = f"{instance_name(detection)} {detection.score:.2f}{class_text(detection)}"
    size = xyz((0, 0, drawn.sizes.text), "Vector3")
    fields: dict[str, Any] = {"type": TEXT_VIEW_FACING, "scale": size, "text": text}
    return _marker(f"{detection.object}/name", detection.id, drawn, drawn.colour, drawn.above, **fields)


def _marker(ns: str, number: int, drawn: Drawn, colour: Colour, pose: Message | None = None, **fields: Any) -> Message:
    placed = pose or pose_message(Pose(np.eye(3), np.zeros(3)))
    number = int(number) % 2**31  # the message's id is an int32; objects' ids are never given twice
    common = {"header": drawn.header, "ns": ns, "id": number, "action": ADD, "pose": placed}
    common["color"] = _colour(colour, drawn.opacity)
    return Message("visualization_msgs/msg/Marker", {**common, **fields})


def _deletion(key: tuple[str, int], header: Any) -> Message:
    fields = {"header": header, "ns": key[0], "id": key[1], "action": DELETE}
    return Message("visualization_msgs/msg/Marker", fields)


def _line_scale(sizes: Sizes) -> Message:
    return xyz((sizes.line, 0, 0), "Vector3")


def _colour(rgb: Colour, opacity: float) -> Message:
    return Message("std_msgs/msg/ColorRGBA", {**dict(zip("rgb", map(float, rgb), strict=True)), "a": opacity})
