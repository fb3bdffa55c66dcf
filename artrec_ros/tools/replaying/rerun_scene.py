"""What a Rerun recording shows of a frame: entities by path, each with what it is made of. Needs rerun-sdk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from ...core.base.config import ImageConfig
from ...core.canvas import class_text
from ...core.drawing import class_picture, object_colour
from ...core.geometry.camera import Camera
from ...core.geometry.transforms import Array, Pose, quaternion_from_rotation
from ...core.model.found import Detection
from ...core.model.frame_result import FrameResult
from ...core.model.kinematics import Kinematics
from ...core.model.objects import Component, ObjectModel
from ...core.model.target import Target
from ...io.messages.marker_messages import component_frames, in_plane
from ...io.results.journal import Recognised
from .raw_frames import RawFrame

with suppress(ImportError):  # RerunFile tells what to install
    import rerun as rr

Entity = tuple[list[str], list[Any]]
"""A path below the source's, and its archetypes."""

_PIXEL = 0.5  # Rerun counts from a pixel's corner, this package from its centre
_INSIDE_95 = np.sqrt(7.815)  # of a Gaussian in three dimensions 95 % lie within so many standard deviations
_AXES_M = 0.08
_LINE_PX, _POINT_PX, _LINE_M = 1.0, 3.0, 0.002


def class_names(image: ImageConfig, targets: Sequence[Target]) -> rr.AnnotationContext:
    """Names and colours of the class numbers, as in the overlays."""
    names = {0: "nothing", **{t.label: t.name for t in targets}}
    names |= {cls.label: name for name, cls in image.classes.items()}
    colours = class_picture(np.arange(256)[None], image.named_labels)[0, :, ::-1].tolist()
    return rr.AnnotationContext([(n, names.get(n, f"class {n}"), colours[n]) for n in range(len(colours))])


class Scene:
    """Draws frames with these objects."""

    def __init__(self, targets: Sequence[Target]) -> None:
        self._names = [t.name for t in targets]
        self._models = {t.name: t.model for t in targets}
        self._kinematics = {t.name: Kinematics(t.model) for t in targets}

    def entities(self, frame: Recognised, raw: RawFrame | None) -> Iterator[Entity]:
        """All that is there in this frame, and stays until the next."""
        if raw is not None:
            yield from _picture(raw)
        if frame.result is None:
            return
        for detection in frame.result.detections:
            yield from self._found(detection)
        yield from self._turned_down(frame.result)
        for stage, milliseconds in frame.result.timing_ms.items():
            yield _plotted("milliseconds", milliseconds, stage)

    def _found(self, d: Detection) -> Iterator[Entity]:
        colour = self._colour(d.object)
        outlines = [c for c in d.components if len(c.contour)]
        strips = [_closed(c.contour) + _PIXEL for c in outlines]
        labels = [f"{d.name} {c.component} {c.score:.2f}" for c in outlines]
        lines = rr.LineStrips2D(strips, colors=colour, radii=-_LINE_PX, labels=labels, show_labels=False)
        yield ["camera", "found", d.name], [lines]
        yield _plotted("scores", d.score, d.name)
        for joint, q in d.joints.items():
            yield _plotted("joints", q, d.name, joint)
        if d.pose is not None:
            yield from self._in_space(d, d.pose, _space_of(d))

    def _in_space(self, d: Detection, pose: Pose, space: list[str]) -> Iterator[Entity]:
        root, colour = [*space, "objects", d.name], self._colour(d.object)
        yield root, [_transform(pose), rr.TransformAxes3D(_AXES_M)]
        called = f"({d.name})" if d.predicted else d.name  # as in the overlays
        name = rr.Points3D([[0, 0, 0]], labels=[f"{called} {d.score:.2f}{class_text(d)}"], radii=0, colors=colour)
        yield [*root, "name"], [name]
        if d.pose_from == "fit":
            frames = component_frames(self._kinematics[d.object], Pose.identity(), d.joints)
            for component in in_view(self._models[d.object], d):
                yield from _component([*root, component.name], component, frames[component.name], d, colour)
        elif to_plane := in_plane(d, pose, self._models[d.object]):
            back = pose.inverse()
            lines = [back.apply(to_plane(_closed(c.contour))) for c in d.components if len(c.contour)]
            yield [*root, "markers"], [rr.LineStrips3D(lines, colors=colour, radii=_LINE_M)]
        if d.pose_covariance is not None:
            yield [*space, "uncertainty", d.name], [_ellipsoid(d.pose_covariance, pose.position, colour)]

    def _turned_down(self, result: FrameResult) -> Iterator[Entity]:
        told = [r for r in result.rejected if (r.x, r.y) != (0.0, 0.0)]  # the others have no place
        if not told:
            return
        places, colours = np.array([(r.x, r.y) for r in told]) + _PIXEL, [self._colour(r.object) for r in told]
        labels = [f"{r.object}: {r.reason}" for r in told]
        points = rr.Points2D(places, colors=colours, labels=labels, radii=-_POINT_PX, show_labels=False)
        yield ["camera", "rejected"], [points]

    def _colour(self, name: str) -> tuple[int, int, int]:
        blue, green, red = object_colour(self._names, name)
        return red, green, blue


def _space_of(d: Detection) -> list[str]:
    """Where poses of this frame lie: the camera's frame is at the root, others beside it."""
    return [d.frame_id] if d.frame_id else []


def told_in_words(frame: Recognised) -> Iterator[tuple[str, str]]:
    """Level and text of what is worth a line."""
    if frame.error is not None:
        yield "ERROR", f"{frame.frame}: {frame.error}"
    if frame.result is not None and not frame.result.complete:
        yield "WARN", f"{frame.frame}: the search was ended by {', '.join(frame.result.ended_by)}"


def in_view(model: ObjectModel, d: Detection) -> list[Component]:
    """The components whose place is known: nothing moves them, or their joints and those they hang on are told."""
    of_component: Mapping[str, str] = {
        c.name: n for c, n in zip(model.joint_components, model.joint_names, strict=True)
    }
    known: dict[str, Component] = {}
    for c in model.components:  # parents first
        carried = c.joint is None or c.joint.parent in known
        if carried and (c.name not in of_component or of_component[c.name] in d.joints):
            known[c.name] = c
    return list(known.values())


def _picture(raw: RawFrame) -> Iterator[Entity]:
    if raw.camera is not None:
        yield ["camera"], [_pinhole(raw.camera)]
    if raw.image is not None:
        yield ["camera", "image"], [rr.EncodedImage(contents=raw.image, media_type="image/jpeg", draw_order=-20)]
    yield ["camera", "classes"], [rr.SegmentationImage(raw.classes(), draw_order=-10)]


def _pinhole(camera: Camera) -> rr.Pinhole:
    """Without the lens' distortion, which Rerun does not know."""
    K = camera.matrix.copy()
    K[:2, 2] += _PIXEL
    return rr.Pinhole(image_from_camera=K, resolution=camera.size, camera_xyz=rr.ViewCoordinates.RDF)


def _component(
    path: list[str], component: Component, T_object_component: Pose, d: Detection, colour: tuple[int, int, int]
) -> Iterator[Entity]:
    found = {c.marker for c in d.components if c.component == component.name}
    yield path, [_transform(T_object_component)]
    placed = [(m, m.T_component_marker) for m in component.markers if m.T_component_marker is not None]
    lines = [T.apply(np.pad(_closed(m.outline), ((0, 0), (0, 1)))) for m, T in placed]
    radii = [_LINE_M * (2 if m.name in found else 0.5) for m, _ in placed]
    labels = [f"{component.name} {m.name}" for m, _ in placed]
    yield [*path, "markers"], [rr.LineStrips3D(lines, colors=colour, radii=radii, labels=labels, show_labels=False)]
    if component.bodies:
        places = [b.T_component_box for b in component.bodies]
        turns, centres = [rr.Quaternion(xyzw=T.quaternion) for T in places], [T.position for T in places]
        sizes = [b.size for b in component.bodies]
        boxes = rr.Boxes3D(sizes=sizes, centers=centres, quaternions=turns, colors=colour, radii=_LINE_M / 2)
        yield [*path, "bodies"], [boxes]


def _transform(pose: Pose) -> rr.Transform3D:
    return rr.Transform3D(translation=pose.position, quaternion=rr.Quaternion(xyzw=pose.quaternion))


def _ellipsoid(covariance: Array, centre: Array, colour: tuple[int, int, int]) -> rr.Ellipsoids3D:
    """Where the object's origin lies with a probability of 95 %."""
    variances, axes = np.linalg.eigh(np.asarray(covariance).reshape(6, 6)[:3, :3])
    axes[:, 2] *= np.sign(np.linalg.det(axes))  # a rotation
    half = _INSIDE_95 * np.sqrt(np.maximum(variances, 0))
    turn = rr.Quaternion(xyzw=quaternion_from_rotation(axes))
    return rr.Ellipsoids3D(half_sizes=[half], centers=[centre], quaternions=[turn], colors=[colour])


def _plotted(kind: str, value: float, *names: str) -> Entity:
    return ["plots", kind, *names], [rr.Scalars(float(value)), rr.SeriesLines(names=" ".join(names))]


def _closed(outline: Array) -> Array:
    return np.vstack([outline, outline[:1]])
