"""Regions of classes from COCO keypoint files: where objects are annotated for training, nothing is marked twice.

The two ends of a marker's axis fix its place, so its outline in the image follows, and the object file knows its class;
a ball's follows from its centre and a point of its edge.
So do those of the bodies of an object that lies flat. What lies outside all outlines of an image is background. What
else is drawn there, boxes and polygons of other categories, is of the class of that name, or background of its own;
where it and an outline overlap, the smaller one goes before.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

import cv2
import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.field_plane import FieldPlane
from ...core.geometry.transforms import Array
from ...core.model.found import Instance
from ...core.model.identities import identities_of as existing_identities
from ...core.model.marker import Marker
from ...core.model.objects import Component
from ...core.model.target import Target
from ..base.yaml_files import nearest
from .annotations import IDENTITY, AnnotatedObject, Annotations, axis_px, load_coco
from .coco import coco_entry, coco_image, read_coco
from .marked_balls import marked_balls
from .regions import MarkedImage, drawn_regions, larger_first, outlines_of, parted

REST = "unmarked"
"""Category of what lies outside all outlines."""
BESIDE = "beside markers"
"""The part of it that lies around them."""
_SURE_OF_BODY = 0.85  # of a box' sides
_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))  # of a box, in its sizes


def load_marked_objects(
    paths: Sequence[str | Path],
    targets: Sequence[Target],
    names: Mapping[int, str],
    images_folder: Path | None = None,
    around_px: float = math.inf,
    plane: FieldPlane | None = None,
) -> list[MarkedImage]:
    """The images of COCO keypoint files that have annotated objects; crowds (`iscrowd`) are regions to ignore.

    :param names: class label -> name.
    :param images_folder: where the images lie; without it, beside each file.
    :param around_px: what is farther than this from all regions is no background either.
    :param plane: on which the markers lie, and by which outlines are squeezed; None: they face the camera.
    :raises ConfigError: an annotation that is of none of the targets, or does not tell a component's class.
    """
    annotations, drawn = load_coco(paths, images_folder), drawn_regions(paths, images_folder)
    seen: dict[Path, _Seen] = defaultdict(_Seen)
    for o in annotations.objects:
        seen[o.image].add(o, annotations, targets, names, plane)
    for image, outline in crowds(paths, images_folder):
        seen[image].ignored.append(outline)
    sizes = {o.image: o.size for o in annotations.objects}
    marked = []
    for image, own in seen.items():
        if own.markers:
            beneath, above = parted(drawn.pop(image, ()), own.markers)
            regions = (*larger_first([*beneath, *own.bodies]), *larger_first([*above, *own.markers]))
            exact, ignored = (tuple(own.markers), tuple(own.called)), tuple(own.ignored)
            marked.append(MarkedImage(image, regions, REST, around_px, ignored, sizes[image], *exact))
    # where no object is annotated nobody has said that the rest is background
    return marked + [MarkedImage(image, tuple(larger_first(own))) for image, own in drawn.items() if own]


@dataclass
class _Seen:
    """What an image shows of the objects in it: outlines of markers and of bodies' sure parts, each with its class'
    name, what each marker is called, and outlines of what is ignored."""

    markers: list[tuple[str, Array]] = field(default_factory=list)
    called: list[str] = field(default_factory=list)
    bodies: list[tuple[str, Array]] = field(default_factory=list)
    ignored: list[Array] = field(default_factory=list)

    def add(
        self,
        o: AnnotatedObject,
        annotations: Annotations,
        targets: Sequence[Target],
        names: Mapping[int, str],
        plane: FieldPlane | None,
    ) -> None:
        """An object; the rest as of `load_marked_objects`."""
        target, shown = what_is_shown(o, targets)
        for ball, outline in marked_balls(o, target):
            label = label_of(ball, target.label, shown.get(ball.name), o)
            self.markers.append((_named(label, ball.name, o, names), outline))
            self.called.append(f"{target.name}: {ball.name}")
        flat = target.model.is_flat  # else bodies do not follow from axes
        for component, marker, place, label in _shown_markers(o, annotations, targets, names):
            self.markers.append((names[label], outline_px(marker, place, plane)))
            self.called.append(f"{target.name}: {component.name}/{marker.name}")
            for body_label in {*component.body_labels} & {*names} if flat else ():
                for outline in _body_outlines(component, marker, place, plane):
                    self.bodies.append((names[body_label], _inner_part(outline)))
                    self.ignored.append(outline)
        self.ignored += _hidden_parts(o, target)


def _shown_markers(
    annotated: AnnotatedObject, annotations: Annotations, targets: Sequence[Target], names: Mapping[int, str]
) -> Iterator[tuple[Component, Marker, Instance, int]]:
    """Each marker whose axis is annotated: its component, its place, its class' label."""
    target, shown = what_is_shown(annotated, targets)
    keypoints = {annotated.category: annotations.categories[annotated.category]}
    example = Annotations(keypoints, (annotated,)).examples(target.model)[0]
    for (name, marker), place in example.items():
        component = target.model.component(name)
        label = label_of(component, target.label, shown.get(name), annotated)
        _named(label, name, annotated, names)
        yield component, component.marker(marker), place, label


def _named(label: int, component: str, annotated: AnnotatedObject, names: Mapping[int, str]) -> str:
    if label not in names:
        raise ConfigError(f"{annotated.place}: component '{component}' has the label {label}, which no class has")
    return names[label]


def what_is_shown(annotated: AnnotatedObject, targets: Sequence[Target]) -> tuple[Target, Mapping[str, str]]:
    """Which target an annotation is of, and component -> class name where one has alternatives.

    Its category is the target's name, its identity's name, or both joined by _. Attributes tell what the category does
    not: `identity`, or a component's class by the component's name.
    """
    found = [
        (target, identity)
        for target in targets
        for identity in (None, *identities_of(target))
        if annotated.category in _called(target, identity)
    ]
    if not found and len(targets) == 1:
        found = [(targets[0], None)]
    if len(found) != 1:
        known = [name for t in targets for i in (None, *identities_of(t)) for name in _called(t, i)[:1]]
        what = "could be any of several objects" if found else "is no object of the parameter file"
        raise ConfigError(
            f"{annotated.place}: category '{annotated.category}' {what}{nearest(annotated.category, known)}"
        )
    target, identity = found[0]
    identity = annotated.attributes.get(IDENTITY, identity)
    known_identities = identities_of(target)
    if identity is not None and identity not in known_identities:
        raise ConfigError(unknown_identity(annotated, target.name, identity, known_identities))
    classes = dict(known_identities[identity]) if identity is not None else {}
    components = {c.name for c in target.model.components}
    return target, {**classes, **{k: v for k, v in annotated.attributes.items() if k in components}}


def unknown_identity(annotated: AnnotatedObject, name: str, identity: str, known: Iterable[str]) -> str:
    """What is wrong with an annotation of an object `name` with an identity that this does not have."""
    return f"{annotated.place}: object '{name}' has no identity '{identity}'{nearest(identity, known)}"


def _called(target: Target, identity: str | None) -> tuple[str, ...]:
    return (target.name,) if identity is None else (f"{target.name}_{identity}", identity)


def identities_of(target: Target) -> dict[str, Mapping[str, str]]:
    """Identity -> component -> class name, of those that exist, be they declared or not."""
    return {i.name: i.classes for i in existing_identities(target.model)}


def label_of(component: Component, own: int, class_name: str | None, annotated: AnnotatedObject) -> int:
    """The label of a component's markers in an annotation. :param own: the object's."""
    classes = component.classes
    if not classes:
        return own if component.label is None else component.label
    if class_name is None or class_name not in classes:
        told = "is not told" if class_name is None else f"is told as '{class_name}', which it has not"
        raise ConfigError(
            f"{annotated.place}: the class of component '{component.name}' {told}; name it in the annotation's "
            f"attributes, as identity or as {component.name} (known: {', '.join(classes)})"
        )
    label = classes[class_name]
    assert label is not None  # the parameter file's classes have been read
    return label


def outline_px(marker: Marker, place: Instance, plane: FieldPlane | None = None) -> Array:
    """(n, 2) a marker's outline at its place in the image.

    :param plane: in which it lies; None: it faces the camera.
    """
    return _placed_px(marker.outline, marker, place, plane)


def _placed_px(points: Array, marker: Marker, place: Instance, plane: FieldPlane | None) -> Array:
    """(n, 2) pixels of points (n, 2) in a marker's plane, metres, which is at its place in the image."""
    tail, head = axis_px(marker, place) @ np.array([1, 1j])
    own, up = (points - marker.tail) @ np.array([1, 1j]), (marker.head - marker.tail) @ np.array([1, 1j])
    if plane is not None:
        there = plane.places(np.array([[tail.real, tail.imag], [head.real, head.imag]])) @ np.array([1, 1j])
        at = there[0] + own * (there[1] - there[0]) / up
        return plane.pixels(np.stack([at.real, at.imag], axis=1))
    at = tail + np.conj(own / up) * (head - tail)  # the image's y is down
    return np.stack([at.real, at.imag], axis=1)


def _body_outlines(component: Component, marker: Marker, place: Instance, plane: FieldPlane | None) -> Iterator[Array]:
    """(n, 2) pixels of the outline of each box of a component that lies flat, of which a marker is at its place in the
    image; none where the marker's place on it is not known. :param plane: as of `outline_px`."""
    if marker.T_component_marker is None:
        return
    to_marker = marker.T_component_marker.inverse()
    for box in component.bodies:
        corners = to_marker.apply(box.T_component_box.apply(_CORNERS * box.size))[:, :2]
        yield _placed_px(cv2.convexHull(corners.astype(np.float32))[:, 0].astype(float), marker, place, plane)


def _inner_part(outline: Array) -> Array:
    """(n, 2) what of an outline shows a body for sure, though its box is rough."""
    middle = outline.mean(axis=0)
    return np.asarray(middle + _SURE_OF_BODY * (outline - middle))


def _hidden_parts(annotated: AnnotatedObject, target: Target) -> list[Array]:
    """The box of an object some of whose markers are not annotated, be it that its category has no keypoints for them:
    they may yet be seen in part."""
    balls = {ball.name for ball, _ in marked_balls(annotated, target)}
    incomplete = any(annotated.axis("/".join(key)) is None for key in target.model.markers if key[0] not in balls)
    return [annotated.box] if annotated.box is not None and incomplete else []


def crowds(paths: Iterable[str | Path], images_folder: Path | None) -> Iterator[tuple[Path, Array]]:
    """Image and outline of what is annotated as a crowd: something of which nothing is told."""
    for path in map(Path, paths):
        top = read_coco(path)
        images = dict(coco_image(v, images_folder or path.parent) for v in top["images"].items())
        for annotation in top["annotations"].items():
            if annotation.raw.get("iscrowd") in (1, True):
                image = images[coco_entry(annotation, "image_id").integer()][0]
                yield from ((image, outline) for outline in outlines_of(annotation))
