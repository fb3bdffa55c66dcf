"""Annotated examples from COCO keypoint files: where an object's markers lie in images.

Keypoints are named COMPONENT/MARKER.tail and COMPONENT/MARKER.head: the ends of the marker's axis. A camera
that is not tilted against the marker sees it under a similarity, which these two points fix.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...core.base.errors import ConfigError, ImageError
from ...core.geometry.transforms import Array
from ...core.model.found import Instance
from ...core.model.marker import Marker
from ...core.model.objects import ObjectModel
from ..base.yaml_files import Value, nearest
from ..images.decoding import Image, read_image
from .coco import coco_entry, coco_image, read_coco, rows_of
from .marked_balls import ball_keypoints

Key = tuple[str, str]  # (component, marker)
_ENDS = ("tail", "head")
IDENTITY = "identity"  # attribute: which of several like objects it is
MADE_BY, MACHINE = "made_by", "recogniser"
"""An annotation's attribute, and its value where the recogniser drew it and nobody has mended it since."""
_LEAST_AXIS_PX = 0.5  # a shorter axis has no direction


@dataclass(frozen=True)
class AnnotatedObject:
    """One annotation: an object in an image.

    :param points: keypoint name -> (2,) pixels, of the keypoints that are labelled.
    :param size: the image's (width, height) in pixels, where the file tells it.
    :param attributes: what the annotation tells besides, as CVAT writes it; text only.
    :param box: (4, 2) corners of its `bbox`, where it has one that holds something.
    """

    image: Path
    category: str
    place: str
    points: Mapping[str, Array]
    size: tuple[int, int] | None = None
    attributes: Mapping[str, str] = field(default_factory=dict)
    box: Array | None = None

    @property
    def by_machine(self) -> bool:
        """Whether the recogniser drew it: fit to learn from, but no truth to score the recogniser by."""
        return self.attributes.get(MADE_BY) == MACHINE

    def axis(self, marker: str) -> Array | None:
        """(2, 2) tail and head of the axis of COMPONENT/MARKER, pixels; None: not both are labelled."""
        ends = [p for end in _ENDS if (p := self.points.get(f"{marker}.{end}")) is not None]
        return np.stack(ends) if len(ends) == len(_ENDS) else None


@dataclass(frozen=True)
class Annotations:
    """The annotations of one or more COCO files, in order.

    :param categories: category name -> names of its keypoints.
    :param bare: category that has none -> its annotations, which are regions.
    :param crowds: the categories of the crowds (iscrowd: 1), which are passed over.
    """

    categories: Mapping[str, tuple[str, ...]]
    objects: tuple[AnnotatedObject, ...]
    bare: Mapping[str, int] = field(default_factory=dict)
    crowds: tuple[str, ...] = ()

    def of(self, categories: Sequence[str] = ()) -> Annotations:
        """The annotations of these categories; of all where none is named."""
        for name in categories:
            if name not in self.categories and name in self.bare:
                raise ConfigError(f"category '{name}': has no keypoints; name them COMPONENT/MARKER.tail and .head")
            if name not in self.categories:
                raise ConfigError(f"category '{name}': no annotation file has it{nearest(name, self.categories)}")
        chosen = tuple(categories) or tuple(self.categories)
        kept = tuple(o for o in self.objects if o.category in chosen)
        crowds = tuple(name for name in self.crowds if name in chosen)
        return Annotations({name: self.categories[name] for name in chosen}, kept, self.bare, crowds)

    def examples(self, model: ObjectModel) -> list[dict[Key, Instance]]:
        """Per annotated object, the places of `model`'s markers; a marker needs both ends labelled. Keypoints of balls
        (marked_balls.py) tell none."""
        markers = {"/".join(key): (key[0], m) for key, m in model.markers.items()}
        known = [f"{marker}.{end}" for marker in markers for end in _ENDS]
        if not {name for names in self.categories.values() for name in names} <= {*known}:
            known += ball_keypoints(model)
        several = "; of several categories choose one with --category" if len(self.categories) > 1 else ""
        for category, names in self.categories.items():
            for name in names:
                if name not in known:
                    raise ConfigError(
                        f"keypoint '{name}' of category '{category}' is no component/marker.tail or .head, nor a "
                        f"ball's .centre or .edge, of object '{model.name}'{nearest(name, known)}{several}"
                    )
        return [_example(o, markers) for o in self.objects]

    def half_labelled(self) -> int:
        """How many markers have one end labelled only; they are no examples."""
        count = 0
        for o in self.objects:
            stems = [name.rpartition(".")[0] for name in o.points]
            count += sum(stems.count(stem) == 1 for stem in stems)
        return count


def _example(annotated: AnnotatedObject, markers: Mapping[str, tuple[str, Marker]]) -> dict[Key, Instance]:
    example = {}
    for name, (component, marker) in markers.items():
        axis = annotated.axis(name)
        if axis is None:
            continue
        if np.linalg.norm(axis[1] - axis[0]) < _LEAST_AXIS_PX:
            raise ConfigError(f"{annotated.place}: {name}: tail and head are the same point")
        example[component, marker.name] = instance_from_axis(component, marker, *axis)
    return example


def instance_from_axis(component: str, marker: Marker, tail_px: Array, head_px: Array) -> Instance:
    """The similarity of the image plane that carries a marker's axis to the two pixels."""
    tail, head = ((p - marker.centroid) * (1, -1) for p in (marker.tail, marker.head))  # image_outline's frame
    as_complex = np.array([1, 1j])
    z = ((head_px - tail_px) @ as_complex) / ((head - tail) @ as_complex)
    centre = tail_px @ as_complex - z * (tail @ as_complex)
    theta = np.angle((head_px - tail_px) @ as_complex)
    return Instance(component, marker.name, 1.0, float(centre.real), float(centre.imag), float(theta), float(abs(z)))


def axis_px(marker: Marker, place: Instance) -> Array:
    """(2, 2) tail and head of a marker's axis in the image: the inverse of `instance_from_axis`."""
    z = place.scale * np.exp(1j * (place.theta - marker.axis_angle))
    ends = (np.stack([marker.tail, marker.head]) - marker.centroid) @ np.array([1, -1j])
    points = complex(place.x, place.y) + z * ends
    return np.stack([points.real, points.imag], axis=1)


def load_coco(paths: Iterable[str | Path], images_folder: Path | None = None) -> Annotations:
    """COCO keypoint files, one after another; crowds and categories without keypoints are passed over.

    :param images_folder: where the images lie; without it, beside each file.
    """
    categories: dict[str, tuple[str, ...]] = {}
    objects: list[AnnotatedObject] = []
    bare, crowds = Counter[str](), list[str]()
    for path in map(Path, paths):
        top = read_coco(path)
        with_points = (v for v in top["categories"].items() if v.entries().get("keypoints", v).raw)  # or an empty list
        own = dict(_category(v) for v in with_points if "keypoints" in v.entries())
        for name, keypoints in own.values():
            if categories.setdefault(name, keypoints) != keypoints:
                raise ConfigError(f"{path}: category '{name}': its keypoints differ from those of the files before it")
        images = dict(coco_image(v, images_folder or path.parent) for v in rows_of(top["images"]))
        known = {coco_entry(v, "id").integer(): str(v.raw.get("name")) for v in rows_of(top["categories"])}
        without = {number: name for number, name in known.items() if number not in own}
        bare.update(dict.fromkeys(without.values(), 0))
        objects += [o for v in top["annotations"].items() if (o := _annotation(v, images, own, known)) is not None]
        bare.update(
            without[v.raw["category_id"]] for v in top["annotations"].items() if v.raw["category_id"] in without
        )
        crowds += [own[v.raw["category_id"]][0] for v in top["annotations"].items() if _is_crowd(v, own)]
    return Annotations(
        categories, tuple(objects), {n: k for n, k in bare.items() if n not in categories}, tuple(crowds)
    )


def _is_crowd(value: Value, categories: Collection[int]) -> bool:
    return value.raw.get("category_id") in categories and value.raw.get("iscrowd") in (1, True)


def _category(value: Value) -> tuple[int, tuple[str, tuple[str, ...]]]:
    keypoints = coco_entry(value, "keypoints")
    names = tuple(v.text() for v in keypoints.items())
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise keypoints.error(f"'{twice[0]}' is listed twice")
    return coco_entry(value, "id").integer(), (coco_entry(value, "name").text(), names)


def annotated_image(path: Path, size: tuple[int, int] | None) -> Image:
    """An image's pixels. :raises ImageError: it cannot be read, or its file's (width, height) are not its own."""
    image = read_image(path)
    height, width = image.shape[:2]
    if size is not None and size != (width, height):
        raise ImageError(
            f"has {width}x{height} pixels; its COCO file says {size[0]}x{size[1]}, so that what is marked lies "
            "elsewhere: give the very image that was annotated"
        )
    return image


def _annotation(
    value: Value,
    images: Mapping[int, tuple[Path, tuple[int, int] | None]],
    categories: Mapping[int, tuple[str, tuple[str, ...]]],
    known: Collection[int],
) -> AnnotatedObject | None:
    category, image = coco_entry(value, "category_id"), coco_entry(value, "image_id")
    if category.integer() not in known:
        raise category.error(f"there is no category {category.raw}")
    if image.integer() not in images:
        raise image.error(f"there is no image {image.raw}")
    if category.raw not in categories or _is_crowd(value, categories):
        return None
    name, keypoints = categories[category.raw]
    points = _points(coco_entry(value, "keypoints"), keypoints)
    path, size = images[image.raw]
    place, entries = f"{value.file}: {value.key} ({path.name})", value.entries()
    attributes = {k: v.raw for k, v in _attributes(entries).items() if isinstance(v.raw, str)}
    return AnnotatedObject(path, name, place, points, size, attributes, _box(entries))


def _attributes(entries: Mapping[str, Value]) -> Mapping[str, Value]:
    told = entries.get("attributes")
    return told.entries() if told is not None and isinstance(told.raw, dict) else {}


def _box(entries: Mapping[str, Value]) -> Array | None:
    if "bbox" not in entries or entries["bbox"].raw in (None, []):
        return None
    x, y, width, height = entries["bbox"].vector(4)
    return np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]]) if width * height > 0 else None


def _points(value: Value, names: Sequence[str]) -> dict[str, Array]:
    """The labelled keypoints: visibility 1 (hidden) counts, 0 does not."""
    items = value.items()
    if len(items) != 3 * len(names):
        wanted = f"{3 * len(names)} numbers (x, y, visibility of each keypoint of its category)"
        raise value.error(f"needs {wanted}, has {len(items)}")
    points = {}
    for n, name in enumerate(names):
        x, y, visibility = items[3 * n : 3 * n + 3]
        if visibility.number() not in (0, 1, 2):
            raise visibility.error(f"the visibility {visibility.raw} of '{name}' must be 0, 1 or 2")
        if visibility.raw:
            points[name] = np.array([x.number(), y.number()])
    return points
