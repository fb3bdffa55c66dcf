"""Object files from models: what object_reader.py reads."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

import numpy as np
import yaml

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array, Pose
from ...core.model.marker import Marker
from ...core.model.objects import GREATEST_LABEL, Component, Joint, ObjectModel
from ..base.whole_files import save_file
from ..base.yaml_files import load_yaml
from .object_reader import FORMAT

_DECIMALS = 5  # metres: a hundredth of a millimetre


@dataclass(frozen=True)
class Labels:
    """What an object file calls classes of pixels: numbers, or names that it or a parameter file declares.

    :param declared: name -> number. :param label, body: component -> what stands there, if anything.
    :param classes: component -> short name -> what stands there.
    """

    declared: Mapping[str, int] = field(default_factory=dict)
    label: Mapping[str, int | str | None] = field(default_factory=dict)
    body: Mapping[str, int | str | None] = field(default_factory=dict)
    classes: Mapping[str, Mapping[str, int | str]] = field(default_factory=dict)

    @classmethod
    def of(cls, model: ObjectModel) -> Labels:
        """:raises ConfigError: a component's alternative classes have names whose numbers are not known."""
        for c in model.components:
            if None in c.classes.values():
                raise ConfigError(
                    f"component '{c.name}': the labels of its classes are not known, so not to be written"
                )
        known = {c.name: {k: label for k, label in c.classes.items() if label is not None} for c in model.components}
        return cls(
            {}, {c.name: c.label for c in model.components}, {c.name: c.body_label for c in model.components}, known
        )

    @classmethod
    def as_in(cls, path: Path) -> Labels:
        """As they stand in an object file that can be read."""
        top = load_yaml(path, FORMAT).entries()
        parts = {name: value.entries() for name, value in top["components"].entries().items()}
        bodies = {name: part["body"].entries() for name, part in parts.items() if "body" in part}
        return cls(
            top["classes"].raw if "classes" in top else {},
            {name: part["label"].raw for name, part in parts.items() if "label" in part},
            {name: body["label"].raw for name, body in bodies.items() if "label" in body},
            {name: part["classes"].raw for name, part in parts.items() if "classes" in part},
        )

    def numbered(self) -> Mapping[str, int]:
        """A number for each name that is not declared, whichever: for who must only know which classes are the same."""
        several = (label for of in self.classes.values() for label in of.values())
        known = {*self.label.values(), *self.body.values(), *several}
        names = sorted({label for label in known if isinstance(label, str)} - self.declared.keys())
        taken = known | set(self.declared.values())
        return dict(zip(names, (n for n in range(GREATEST_LABEL, 0, -1) if n not in taken), strict=False))

    def names(self) -> Mapping[int, str]:
        """By number what a class is called, declared or numbered."""
        return {number: name for name, number in {**self.numbered(), **self.declared}.items()}


def object_yaml(model: ObjectModel, comments: tuple[str, ...] = (), labels: Labels | None = None) -> str:
    """The text of an object file; outlines and places rounded to a hundredth of a millimetre.

    :param comments: lines for the head of the file. :param labels: what stands there for classes; None: their numbers.
    """
    shapes, labels = _shapes(model), labels or Labels.of(model)
    lines = [*(f"# {c}" for c in comments), f"format: {FORMAT}", f"name: {_name(model.name)}"]
    lines += [f"classes: {_mapping(labels.declared)}"] if labels.declared else []
    of = {name: marker for key, marker in model.markers.items() if (name := shapes.get(key)) is not None}
    lines += ["", "markers:"] if of else []
    for name, marker in of.items():
        lines += _shape(name, marker)
    lines += ["", "components:"]
    for component in model.components:
        lines += _component(component, shapes, labels)
    if model.identities:
        lines += ["", "identities:"]
    for identity in model.identities:
        lines.append(f"  {_name(identity.name)}: {_mapping(identity.classes)}")
    if model.unique:
        lines += ["", "unique: true"]
    return "\n".join(lines) + "\n"


def save_object(path: Path, model: ObjectModel, comments: tuple[str, ...] = (), labels: Labels | None = None) -> None:
    """Writes an object file as `object_yaml` has it. :raises ConfigError: where that is not possible."""
    save_file(path, object_yaml(model, comments, labels))


def _shapes(model: ObjectModel) -> dict[tuple[str, str], str]:
    """(component, marker) -> name of its shape; equal shapes share one, different ones of one name are told apart."""
    names: dict[bytes, str] = {}
    shapes = {}
    for marker, m in model.markers.items():
        if m.is_ball:
            continue
        points = np.vstack([m.outline, m.tail, m.head])
        key = np.round(points, _DECIMALS + 1).tobytes()
        if key not in names:
            names[key] = next(n for n in _names_for(*marker) if n not in names.values())
        shapes[marker] = names[key]
    return shapes


def _names_for(component: str, marker: str) -> Iterator[str]:
    """Of a shape: its own, with its component's, and with numbers after that."""
    yield marker
    yield f"{component}_{marker}"
    yield from (f"{component}_{marker}_{n}" for n in count(2))


def _shape(name: str, m: Marker) -> list[str]:
    axis = f"axis: [{_vector(m.tail)}, {_vector(m.head)}]"
    if m.disc_radius is not None:
        return [f"  {_name(name)}: {{disc: {{radius: {_number(m.disc_radius)}}}, {axis}}}"]
    points = [_vector(p) for p in m.outline]
    rows = [", ".join(points[i : i + 6]) for i in range(0, len(points), 6)]
    if len(rows) == 1:
        return [f"  {_name(name)}:", f"    outline: [{rows[0]}]", f"    {axis}"]
    body = [f"      {row}," for row in rows[:-1]] + [f"      {rows[-1]}]"]
    return [f"  {_name(name)}:", "    outline: [", *body, f"    {axis}"]


def _component(c: Component, shapes: dict[tuple[str, str], str], labels: Labels) -> list[str]:
    lines = [f"  {_name(c.name)}:"]
    label, body, classes = labels.label.get(c.name), labels.body.get(c.name), labels.classes.get(c.name)
    if c.required:
        lines.append("    required: true")
    if label is not None:
        lines.append(f"    label: {_word(label)}")
    if classes:
        lines.append(f"    classes: {_mapping(classes)}")
    if c.ball is None:
        lines += _markers(c, shapes)
    else:
        lines.append(f"    ball: {{radius: {_number(c.ball.radius)}, xyz: {_vector(c.ball.centre)}}}")
    if c.joint is not None:
        lines.append(f"    joint: {_joint(c.joint)}")
    if c.bodies and c.ball is None:
        lines += ["    body:"] + ([] if body is None else [f"      label: {_word(body)}"]) + ["      boxes:"]
        lines += [f"        - {{{_pose(b.T_component_box)}, size: {_vector(b.size)}}}" for b in c.bodies]
    return lines


def _markers(c: Component, shapes: dict[tuple[str, str], str]) -> Iterator[str]:
    yield "    markers:"
    for m in c.markers:
        given = [] if shapes[c.name, m.name] == m.name else [f"marker: {_name(shapes[c.name, m.name])}"]
        if m.T_component_marker is not None:
            given.append(f"pose: {{{_pose(m.T_component_marker)}}}")
        yield f"      {_name(m.name)}: {{{', '.join(given)}}}"


def _joint(j: Joint) -> str:
    parts = [f"name: {_name(j.name)}"] if j.name and j.kind != "fixed" else []
    parts += [f"parent: {_name(j.parent)}", f"origin: {{{_pose(j.T_parent_joint)}}}"]
    if j.kind == "fixed":
        parts.append("type: fixed")
    else:
        parts += [f"axis: {_vector(j.axis)}", f"limits: {_vector(np.array([j.lower, j.upper]))}"]
        parts += [] if j.kind == "revolute" else [f"type: {j.kind}"]
    return f"{{{', '.join(parts)}}}"


def _pose(T: Pose) -> str:
    xyz = f"xyz: {_vector(T.position)}"
    if np.allclose(T.rotation, np.eye(3), atol=1e-9):
        return xyz
    x, y = T.rotation[:, 0], T.rotation[:, 1]
    return f"{xyz}, x_axis: {_vector(x, 9)}, y_axis: {_vector(y, 9)}"


def _mapping(entries: Mapping[str, int | str]) -> str:
    return f"{{{', '.join(f'{_name(name)}: {_word(value)}' for name, value in entries.items())}}}"


def _word(value: int | str) -> str:
    return _name(value) if isinstance(value, str) else str(value)


def _name(name: str) -> str:
    """In quotes where YAML would read something else, such as a number."""
    plain = re.fullmatch(r"\w+", name) and yaml.safe_load(name) == name
    return name if plain else str(yaml.safe_dump(name, default_style="'")).strip()


def _vector(v: Array, decimals: int = _DECIMALS) -> str:
    return f"[{', '.join(_number(x, decimals) for x in v)}]"


def _number(x: float, decimals: int = _DECIMALS) -> str:
    text = f"{round(float(x), decimals):.{decimals}f}".rstrip("0")
    text = text + "0" if text.endswith(".") else text
    return "0.0" if text == "-0.0" else text
