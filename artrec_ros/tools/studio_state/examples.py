"""Examples: the axes of objects' markers in frames, kept as a COCO file that train, learn-colours and evaluate read."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array
from ...core.model.found import Detection
from ...core.model.frame_result import FrameResult
from ...core.model.objects import ObjectModel
from ...core.model.target import Target
from ...io.learned.annotation_writer import save_coco
from ...io.learned.annotations import (
    IDENTITY,
    MACHINE,
    MADE_BY,
    AnnotatedObject,
    axis_px,
    instance_from_axis,
    load_coco,
)
from ...io.learned.coco import coco_image, read_coco
from ...io.learned.marked_objects import identities_of, what_is_shown
from ...simulation.records import keypoint_names
from ...simulation.surfaces import component_poses
from .misfits import misfits
from .session import Session

ANNOTATIONS_FILE = "annotations.json"
_ALIKE = 0.99  # cosine between normals of markers that lie in one plane, or in parallel ones
_SAME_SHARE = 0.5  # of an axis' length: objects whose required markers lie nearer are the same

Key = tuple[str, str]  # (component, marker)


class Examples:
    """The examples of a sitting, written to a file after each change.

    :ivar objects: in the order in which they were made. :ivar empty: frames in which somebody saw no object.
    :ivar on_change: called after each change. :ivar misfits: what of the files begun with fits no frame or object.
    """

    def __init__(self, session: Session, more: Sequence[Path] = ()) -> None:
        """:param more: files with examples to begin with, where this sitting's folder has none yet: they are written
        to its file, unless not one of their images is a frame.
        :raises ArtrecError: a file that is none, or whose categories are not those of the parameter file."""
        self._session = session
        self.on_change: Callable[[], None] = lambda: None
        self.categories = {t.name: tuple(keypoint_names(t.model)) for t in session.setup.targets}
        self.objects: list[AnnotatedObject] = []
        self.empty: list[Path] = []
        self.misfits: tuple[str, ...] = ()
        if self.path.is_file():
            self._load([self.path])
        elif more:
            images = self._load(more)
            if any(session.stills.number(image) is not None for image in images):
                self.save()  # what learns and scores reads the file
            else:
                self.objects, self.empty = [], []

    def _load(self, paths: Sequence[Path]) -> list[Path]:
        """Returns the images that the files name."""
        known = load_coco(paths)
        for o in known.objects:
            target, _ = what_is_shown(o, self._session.setup.targets)
            self.categories.setdefault(o.category, tuple(keypoint_names(target.model)))
            unknown = [name for name in o.points if name not in self.categories[o.category]]
            if unknown:
                raise ConfigError(f"{o.place}: keypoint '{unknown[0]}' is none of object '{target.model.name}'")
            self.objects.append(replace(o, image=self._own(o.image)))
        images = [coco_image(v, path.parent)[1][0] for path in paths for v in read_coco(path)["images"].items()]
        shown = {o.image for o in self.objects}
        self.empty = [own for own in map(self._own, images) if own not in shown]
        self.misfits = tuple(misfits(", ".join(map(str, paths)), known, images, self._session.stills))
        return images

    def _own(self, image: Path) -> Path:
        """The frame's file, where an image is one of the frames."""
        number = self._session.stills.number(image)
        return image if number is None else self._session.stills.files[number]

    @property
    def path(self) -> Path:
        return self._session.folder / ANNOTATIONS_FILE

    def save(self) -> None:
        """:raises ConfigError: it cannot be written."""
        save_coco(self.path, self.categories, self.objects, self.empty)
        self.on_change()

    def of(self, number: int) -> list[AnnotatedObject]:
        """The examples in a frame."""
        return [o for o in self.objects if o.image == self._session.stills.files[number]]

    def is_marked(self, number: int) -> bool:
        file = self._session.stills.files[number]
        return file in self.empty or any(o.image == file for o in self.objects)

    def target(self, annotated: AnnotatedObject) -> Target:
        return what_is_shown(annotated, self._session.setup.targets)[0]

    def new(self, number: int, target: Target, key: Key, tail: Array, head: Array) -> AnnotatedObject:
        """An object begun with one axis; markers that are rigid with it and lie in its plane follow from it."""
        points = rigid_points(target.model, key, tail, head)
        made = self._annotated(number, target, points)
        self.objects.append(made)
        self.empty = [f for f in self.empty if f != made.image]
        self.save()
        return made

    def accept(self, proposal: AnnotatedObject) -> AnnotatedObject:
        """Takes a proposal over as it is; it stays marked as the machine's."""
        self.objects.append(proposal)
        self.save()
        return proposal

    def with_axis(self, annotated: AnnotatedObject, key: Key, tail: Array, head: Array) -> AnnotatedObject:
        """One more axis, or another place of one: a person's work from then on."""
        name = "/".join(key)
        points = {**annotated.points, f"{name}.tail": np.asarray(tail, float), f"{name}.head": np.asarray(head, float)}
        return self._changed(annotated, points=points)

    def moved(self, annotated: AnnotatedObject, end: str, place: Array) -> AnnotatedObject:
        """One end of an axis dragged elsewhere. :param end: COMPONENT/MARKER.tail or .head."""
        return self._changed(annotated, points={**annotated.points, end: np.asarray(place, float)})

    def identified(self, annotated: AnnotatedObject, identity: str | None) -> AnnotatedObject:
        """The same object under another name of its identities, or none."""
        kept = {k: v for k, v in annotated.attributes.items() if k != IDENTITY}
        return self._changed(annotated, attributes={**kept, **({IDENTITY: identity} if identity else {})})

    def remove(self, annotated: AnnotatedObject) -> None:
        self.objects = [o for o in self.objects if o is not annotated]
        self.save()

    def set_empty(self, number: int) -> None:
        """Nobody is there: the frame counts as looked at."""
        self.empty = list(dict.fromkeys([*self.empty, self._session.stills.files[number]]))
        self.save()

    def _changed(self, annotated: AnnotatedObject, **changes: Mapping[str, object]) -> AnnotatedObject:
        attributes = dict(changes.pop("attributes", annotated.attributes))
        attributes.pop(MADE_BY, None)
        made = replace(annotated, box=None, attributes=attributes, **changes)  # type: ignore[arg-type]
        if any(o is annotated for o in self.objects):
            self.objects = [made if o is annotated else o for o in self.objects]
        else:  # a proposal that was mended
            self.objects.append(made)
        self.save()
        return made

    def _annotated(
        self, number: int, target: Target, points: Mapping[str, Array], attributes: Mapping[str, str] | None = None
    ) -> AnnotatedObject:
        height, width = self._session.stills.image(number).shape[:2]
        file = self._session.stills.files[number]
        return AnnotatedObject(file, target.name, str(self.path), points, (width, height), dict(attributes or {}))

    def proposals(self, number: int, result: FrameResult) -> list[AnnotatedObject]:
        """What the recogniser found in a frame and nobody has marked there, the best first."""
        targets = {t.name: t for t in self._session.setup.targets}
        found = []
        for d in sorted(result.detections, key=lambda d: -d.score):
            told = {MADE_BY: MACHINE}
            if d.identity is not None and d.identity.name is not None:
                told[IDENTITY] = d.identity.name
            found.append(self._annotated(number, targets[d.object], dict(_points(targets[d.object].model, d)), told))
        marked = self.of(number)
        return [p for p in found if not any(is_same(p, o, self.target(p), self.target(o)) for o in marked)]


def identities(target: Target) -> list[str]:
    """The names by which an object's annotation may tell which one it is."""
    return list(identities_of(target))


def axes_of(annotated: AnnotatedObject, model: ObjectModel) -> Iterator[tuple[Key, Array]]:
    """(component, marker) and (2, 2) tail and head of each axis both of whose ends are marked."""
    for key in model.markers:
        if (axis := annotated.axis("/".join(key))) is not None:
            yield key, axis


def keys_of(model: ObjectModel) -> list[Key]:
    """The markers in the order in which they are marked: the required component's first."""
    return sorted(model.markers, key=lambda key: key[0] != model.required.name)


def rigid_points(model: ObjectModel, key: Key, tail: Array, head: Array) -> dict[str, Array]:
    """Keypoints that follow from one marker's axis: its own, and those of markers that no joint moves against it and
    that face the same way, as on a robot seen from above."""
    tail, head = np.asarray(tail, float), np.asarray(head, float)
    name = "/".join(key)
    points = {f"{name}.tail": tail, f"{name}.head": head}
    marker = model.markers[key]
    if marker.T_component_marker is None:
        return points
    poses, own = component_poses(model, {}), _carrier(model, key[0])
    T_marker_object = (poses[key[0]] @ marker.T_component_marker).inverse()
    place = instance_from_axis(key[0], marker, tail, head)
    z = place.scale * np.exp(1j * (place.theta - marker.axis_angle))
    for other, m in model.markers.items():
        if other == key or m.T_component_marker is None or _carrier(model, other[0]) != own:
            continue
        T = T_marker_object @ poses[other[0]] @ m.T_component_marker
        if T.rotation[2, 2] < _ALIKE:
            continue
        for end, at in (("tail", m.tail), ("head", m.head)):
            x, y, _ = T.apply(np.append(at, 0.0)[None])[0]
            there = complex(place.x, place.y) + z * complex(x - marker.centroid[0], -(y - marker.centroid[1]))
            points[f"{'/'.join(other)}.{end}"] = np.array([there.real, there.imag])
    return points


def _carrier(model: ObjectModel, component: str) -> str | None:
    """The component whose joint moves this one; None: none does."""
    name: str | None = component
    while name is not None:
        joint = model.component(name).joint
        if joint is not None and joint.kind != "fixed":
            return name
        name = joint.parent if joint is not None else None
    return None


def _points(model: ObjectModel, detection: Detection) -> Iterator[tuple[str, Array]]:
    for instance in detection.components:
        marker = model.markers[instance.component, instance.marker]
        for end, place in zip(("tail", "head"), axis_px(marker, instance), strict=True):
            yield f"{instance.component}/{instance.marker}.{end}", place


def is_same(a: AnnotatedObject, b: AnnotatedObject, of_a: Target, of_b: Target) -> bool:
    """Whether two objects' required markers lie on each other."""
    first = [axis for key, axis in axes_of(a, of_a.model) if key[0] == of_a.model.required.name]
    second = [axis for key, axis in axes_of(b, of_b.model) if key[0] == of_b.model.required.name]
    return any(
        np.linalg.norm(p.mean(axis=0) - q.mean(axis=0)) < _SAME_SHARE * np.linalg.norm(q[1] - q[0])
        for p in first
        for q in second
    )
