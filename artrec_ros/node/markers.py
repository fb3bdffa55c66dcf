"""What RViz shows: outlines of the found markers, the object's frame, its name and score."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker as MarkerMsg
from visualization_msgs.msg import MarkerArray

from ..core.datatypes import Detection, Target
from ..core.drawing import object_colour
from ..core.kinematics import Kinematics
from ..core.objects import ObjectModel
from ..core.transforms import Array, Pose
from .conversions import instance_name, pose_to_msg

_LINE_M = 0.004
_FRAME_M = 0.08
_TEXT_M = 0.05
_AXIS_COLOURS = ((1.0, 0.0, 0.0), (0.0, 0.8, 0.0), (0.2, 0.4, 1.0))  # x, y, z as RViz draws them


class MarkerScene:
    """Turns each frame's detections into markers whose (ns, id) stay, and deletes only those that vanished."""

    def __init__(self, targets: Sequence[Target]) -> None:
        self._models = {t.name: t.model for t in targets}
        self._kinematics = {t.name: Kinematics(t.model) for t in targets}
        self._names = [t.name for t in targets]
        self._shown: dict[tuple[str, int], str] = {}  # (ns, id) -> frame

    def update(self, detections: Sequence[Detection], header: Header) -> MarkerArray:
        """The markers of this frame, and deletions of what the last one showed and this one does not."""
        markers = [m for d in detections if d.pose is not None for m in self._object(d, d.pose, header)]
        now = {(m.ns, m.id): header.frame_id for m in markers}
        gone = [(key, frame) for key, frame in self._shown.items() if key not in now]
        self._shown = now
        return MarkerArray(markers=[*(_deletion(key, frame, header) for key, frame in gone), *markers])

    def _object(self, detection: Detection, pose: Pose, header: Header) -> Iterable[MarkerMsg]:
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
            msg = _marker(f"{detection.object}/outline", detection.id * len(slots) + slot, header, colour)
            msg.type, msg.scale.x = MarkerMsg.LINE_STRIP, _LINE_M
            msg.points = [_point(p) for p in (*line, line[0])]
            yield msg


def marker_slots(model: ObjectModel) -> dict[tuple[str, str], int]:
    """A fixed number for each (component, marker) of a model."""
    pairs = [(c.name, m.name) for c in model.components for m in c.markers]
    return {pair: i for i, pair in enumerate(pairs)}


def component_frames(kinematics: Kinematics, pose: Pose, joints: dict[str, float]) -> dict[str, Pose]:
    """T_camera_component of each component; a joint that was not seen is drawn in its middle."""
    middle = (kinematics.lower + kinematics.upper) / 2
    names = [c.name for c in kinematics.model.joint_components]
    q = np.array([joints.get(name, m) for name, m in zip(names, middle, strict=True)])
    frames = kinematics.forward(pose.rotation[None], pose.position[None], q[None])
    return {c.name: Pose(frames.R[0, i], frames.t[0, i]) for i, c in enumerate(kinematics.model.components)}


def _frame(detection: Detection, pose: Pose, header: Header) -> MarkerMsg:
    msg = _marker(f"{detection.object}/frame", detection.id, header, (1.0, 1.0, 1.0))
    msg.type, msg.scale.x = MarkerMsg.LINE_LIST, _LINE_M
    msg.pose = pose_to_msg(pose)
    for axis, colour in zip(np.eye(3) * _FRAME_M, _AXIS_COLOURS, strict=True):
        msg.points += [Point(), _point(axis)]
        msg.colors += [_colour(colour)] * 2
    return msg


def _name(detection: Detection, pose: Pose, header: Header, colour: tuple[float, float, float]) -> MarkerMsg:
    msg = _marker(f"{detection.object}/name", detection.id, header, colour)
    msg.type, msg.scale.z = MarkerMsg.TEXT_VIEW_FACING, _TEXT_M
    msg.pose.position = _point(pose.position + (0, -2 * _TEXT_M, 0))  # above it: the optical frame's y is down
    msg.text = f"{instance_name(detection)} {detection.score:.2f}"
    return msg


def _marker(ns: str, number: int, header: Header, colour: tuple[float, float, float]) -> MarkerMsg:
    msg = MarkerMsg(header=header, ns=ns, id=int(number), action=MarkerMsg.ADD, color=_colour(colour))
    msg.pose.orientation.w = 1.0
    return msg


def _deletion(key: tuple[str, int], frame_id: str, header: Header) -> MarkerMsg:
    header = Header(stamp=header.stamp, frame_id=frame_id)
    return MarkerMsg(header=header, ns=key[0], id=key[1], action=MarkerMsg.DELETE)


def _point(p: Array) -> Point:
    return Point(x=float(p[0]), y=float(p[1]), z=float(p[2]))


def _colour(rgb: tuple[float, float, float]) -> ColorRGBA:
    return ColorRGBA(r=float(rgb[0]), g=float(rgb[1]), b=float(rgb[2]), a=1.0)
