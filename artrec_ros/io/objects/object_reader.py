"""Object files: markers, components, joints and bodies from YAML (docs/object_file.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.base.config import GREATEST_LABEL
from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array, Pose
from ...core.model.bodies import beneath_markers
from ...core.model.identities import identities_of
from ...core.model.marker import Marker
from ...core.model.names import check_name
from ...core.model.objects import Box, Component, Identity, Joint, ObjectModel
from ..base.yaml_files import Value, load_yaml, nearest
from .outlines import crossing_edges, default_axis, disc_outline, folded_corner, silhouette_outline
from .places import MOST_M, SOLIDS, read_box, read_direction, read_pose
from .solids import rectangle
from .urdf import link_body

FORMAT = "artrec_object/1"


def load_object(path: str | Path, class_labels: Mapping[str, int] | None = None) -> ObjectModel:
    """An object from its file, its bodies cut back to the markers that lie a little within them.

    :param class_labels: class name -> label, which go before the file's own `classes`. None: labels do not
        matter to the caller (training), so a class name that the file does not declare stays without a number.
    """
    top = load_yaml(path, FORMAT).fields(
        required=("name", "components"), optional=("markers", "classes", "identities", "unique")
    )
    classes = top["classes"].entries() if "classes" in top else {}
    own = {name: value.integer(1, GREATEST_LABEL) for name, value in classes.items()}
    labels = _Labels({**own, **(class_labels or {})}, strict=class_labels is not None)
    shapes = _read_markers(top["markers"]) if "markers" in top else {}
    read = (_read_component(n, v, shapes, labels) for n, v in top["components"].entries().items())
    components = tuple(beneath_markers(component)[0] for component in read)
    given = list(top["components"].entries().values())
    if len(given) == 1 and "required" not in given[0].entries():  # there is no choice
        components = (replace(components[0], required=True),)
    identities = _read_identities(top["identities"]) if "identities" in top else ()
    unique = top["unique"].boolean() if "unique" in top else False
    name = _name(top["name"], "object")
    try:
        model = ObjectModel(name, components, identities, unique)
        identities_of(model)  # it has no more of them than can be told apart
        return model
    except ConfigError as error:
        raise top["components"].error(str(error)) from None  # names its object


def cut_back(path: str | Path) -> list[str]:
    """The markers, COMPONENT/MARKER, to which `load_object` cuts bodies back."""
    top, labels = load_yaml(path, FORMAT).entries(), _Labels({}, strict=False)
    shapes = _read_markers(top["markers"]) if "markers" in top else {}
    read = [_read_component(n, v, shapes, labels) for n, v in top["components"].entries().items()]
    return [f"{component.name}/{marker}" for component in read for marker in beneath_markers(component)[1]]


class _Labels:
    """Resolves labels that are given as a number or as the name of a class."""

    def __init__(self, numbers: Mapping[str, int], strict: bool) -> None:
        self._numbers, self._strict = numbers, strict

    def resolve(self, value: Value) -> int | None:
        if not isinstance(value.raw, str):
            return value.integer(1, GREATEST_LABEL)
        if value.raw not in self._numbers and self._strict:
            where = "classes have numbers in the object file's `classes` or the parameter file's image.classes"
            raise value.error(f"the class '{value.raw}' is not known{nearest(value.raw, self._numbers)}; {where}")
        return self._numbers.get(value.raw)


def _read_markers(value: Value) -> dict[str, Marker]:
    entries, shapes = value.entries(), {}
    for name, entry in entries.items():
        if isinstance(entry.raw, dict) and "mirror_of" in entry.raw:
            continue
        shapes[name] = _build(entry, name, *_read_shape(entry))
    for name, entry in entries.items():
        if name not in shapes:
            source = entry.fields(required=("mirror_of",))["mirror_of"]
            if source.text() not in shapes:
                raise source.error(f"'{source.raw}' is no marker with a shape{nearest(source.raw, shapes)}")
            try:
                shapes[name] = _mirrored(name, shapes[source.raw])
            except ConfigError as error:
                raise entry.error(str(error)) from None
    return {name: shapes[name] for name in entries}


def _build(entry: Value, name: str, outline: Array, tail: Array, head: Array, radius: float | None) -> Marker:
    try:
        return Marker(name, outline, tail, head, radius)
    except ConfigError as error:
        raise entry.error(str(error)) from None


def _mirrored(name: str, m: Marker) -> Marker:
    flip = np.array([-1.0, 1.0])
    return Marker(name, m.outline[::-1] * flip, m.tail * flip, m.head * flip, m.disc_radius)


def _read_shape(entry: Value) -> tuple[Array, Array, Array, float | None]:
    """Outline, tail, head and, of a disc, radius."""
    shapes = ("outline", "rectangle", "disc", "silhouette")
    given = entry.fields(optional=(*shapes, "mirror_of", "axis"))
    found = [s for s in shapes if s in given]
    if len(found) != 1:
        raise entry.error(f"needs exactly one of {', '.join(shapes)}, mirror_of; has {' and '.join(found) or 'none'}")
    shape, radius = given[found[0]], None
    if found[0] == "outline":
        outline = _read_polygon(shape)
        if "axis" not in given:
            raise entry.error("axis: this key is missing; a polygon needs its axis: [[x, y] tail, [x, y] head]")
    elif found[0] == "rectangle":
        size = shape.fields(required=("width", "height"))
        outline = rectangle(*(size[k].number(high=MOST_M, above=0) for k in ("width", "height")))
    elif found[0] == "disc":
        radius = shape.fields(required=("radius",))["radius"].number(high=MOST_M, above=0)
        outline = disc_outline(radius)
    else:
        outline = _read_silhouette(shape)
    tail, head = _read_axis(given["axis"]) if "axis" in given else default_axis(outline)
    return outline, tail, head, radius


def _read_axis(value: Value) -> tuple[Array, Array]:
    ends = value.points(2, MOST_M)
    if len(ends) != 2:
        raise value.error(f"needs two points [x, y], tail and head; has {len(ends)}")
    return ends[0], ends[1]


def _read_polygon(value: Value) -> Array:
    outline = value.points(3, MOST_M)
    if (corner := folded_corner(outline)) is not None:
        raise value.error(f"at point {corner} the polygon repeats a point or turns back on itself; remove that point")
    if (edges := crossing_edges(outline)) is not None:
        raise value.error(
            f"the polygon crosses itself: the edges from point {edges[0]} and from point {edges[1]} meet; "
            "list the corners in order around the shape"
        )
    return outline


def _read_silhouette(value: Value) -> Array:
    given = value.fields(required=("image", "width"))
    width = given["width"].number(high=MOST_M, above=0)
    try:
        return silhouette_outline(value.file.parent / given["image"].text(), width)
    except ConfigError as error:
        raise given["image"].error(str(error)) from None


def _read_component(name: str, value: Value, shapes: Mapping[str, Marker], labels: _Labels) -> Component:
    given = value.fields(optional=("markers", *SOLIDS, "required", "label", "classes", "joint", "body"))
    bodies, body_label = _read_body(given["body"], labels) if "body" in given else ((), None)
    if solid := [key for key in SOLIDS if key in given]:
        if also := [key for key in (*solid[1:], "markers", "body") if key in given]:
            raise given[also[0]].error(
                f"a component that is a {solid[0]} of one colour is nothing else beside that; what is fixed to it, a "
                f"rod say, is a component of its own, with its class and `joint: {{parent: {name}, type: fixed}}`"
            )
        markers, bodies = SOLIDS[solid[0]](given[solid[0]])
    elif "markers" in given:
        if not shapes and given["markers"].entries():
            raise given["markers"].error("the file's own `markers` are missing, whose shapes these have")
        markers = tuple(_read_place(n, v, shapes) for n, v in given["markers"].entries().items())
    else:
        raise value.error(
            "markers: this key is missing; a component has markers, or is a box, a cylinder or a ball of one colour"
        )
    if not markers:
        raise given["markers"].error("a component needs a marker or more that can show it")
    required = given["required"].boolean() if "required" in given else False
    label = labels.resolve(given["label"]) if "label" in given else None
    classes = _read_classes(given["classes"], labels) if "classes" in given else {}
    joint = _read_joint(given["joint"]) if "joint" in given else None
    try:
        return Component(name, markers, required, label, joint, bodies, body_label, classes)
    except ConfigError as error:
        raise value.error(str(error)) from None


def _read_classes(value: Value, labels: _Labels) -> dict[str, int | None]:
    """Alternatives: short name -> label, a number or a class' name; None: of a name that may stay open."""
    found = {name: labels.resolve(entry) for name, entry in value.entries().items()}
    if len(found) < 2:
        raise value.error("alternatives are two classes or more; a component of one class has a label")
    return found


def _read_identities(value: Value) -> tuple[Identity, ...]:
    return tuple(
        Identity(name, {c: cls.text() for c, cls in entry.entries().items()}) for name, entry in value.entries().items()
    )


def _read_place(name: str, value: Value, shapes: Mapping[str, Marker]) -> Marker:
    """A marker's shape at its place on a component."""
    given = value.fields(optional=("marker", "pose"))
    shape = given["marker"].text() if "marker" in given else name
    if shape not in shapes:
        raise given.get("marker", value).error(f"'{shape}' is no marker of this file{nearest(shape, shapes)}")
    m = shapes[shape]
    pose = read_pose(given["pose"]) if "pose" in given else None
    try:
        return Marker(name, m.outline, m.tail, m.head, m.disc_radius, pose)
    except ConfigError as error:
        raise value.error(str(error)) from None


def _read_joint(value: Value) -> Joint:
    given = value.fields(required=("parent",), optional=("origin", "axis", "limits", "type", "name"))
    kind = given["type"].text(("revolute", "prismatic", "fixed")) if "type" in given else "revolute"
    origin = read_pose(given["origin"]) if "origin" in given else Pose.identity()
    if kind == "fixed":
        return Joint(given["parent"].text(), origin, np.array([0.0, 0.0, 1.0]), 0.0, 0.0, kind)
    for key in ("axis", "limits"):
        if key not in given:
            raise value.error(f"{key}: this key is missing; a {kind} joint needs axis and limits")
    lower, upper = given["limits"].vector(2, MOST_M)
    if not lower < upper:
        raise given["limits"].error(f"the lower limit {lower:g} must be below the upper {upper:g}")
    name = _name(given["name"], "joint") if "name" in given else ""
    return Joint(given["parent"].text(), origin, read_direction(given["axis"]), float(lower), float(upper), kind, name)


def _name(value: Value, what: str) -> str:
    text = value.text()
    try:
        check_name(text, what)
    except ConfigError as error:
        raise value.error(str(error)) from None
    return text


def _read_body(value: Value, labels: _Labels) -> tuple[tuple[Box, ...], int | None]:
    given = value.fields(optional=("label", "boxes", "urdf"))
    if ("boxes" in given) == ("urdf" in given):
        raise value.error("needs either boxes or urdf")
    label = labels.resolve(given["label"]) if "label" in given else None
    if "urdf" in given:
        return _read_urdf(given["urdf"]), label
    return tuple(read_box(v) for v in given["boxes"].items()), label


def _read_urdf(value: Value) -> tuple[Box, ...]:
    given = value.fields(required=("file", "link"))
    try:
        return link_body(value.file.parent / given["file"].text(), given["link"].text()).boxes
    except ConfigError as error:
        raise value.error(str(error)) from None
