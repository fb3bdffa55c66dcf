"""Object files from models: what object_reader.py reads."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import yaml

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array, Pose
from ...core.model.objects import Component, Joint, Marker, ObjectModel
from .object_reader import FORMAT

_DECIMALS = 5  # metres: a hundredth of a millimetre


def object_yaml(model: ObjectModel, comments: tuple[str, ...] = ()) -> str:
    """The text of an object file; outlines and places rounded to a hundredth of a millimetre.

    :param comments: lines for the head of the file.
    """
    shapes = _shapes(model)
    lines = [*(f"# {c}" for c in comments), f"format: {FORMAT}", f"name: {_name(model.name)}", "", "markers:"]
    written: set[str] = set()
    for component in model.components:
        for marker in component.markers:
            name = shapes[component.name, marker.name]
            if name not in written:
                lines += _shape(name, marker)
                written.add(name)
    lines += ["", "components:"]
    for component in model.components:
        lines += _component(component, shapes)
    if model.identities:
        lines += ["", "identities:"]
    for identity in model.identities:
        shown = ", ".join(f"{_name(c)}: {_name(cls)}" for c, cls in identity.classes.items())
        lines.append(f"  {_name(identity.name)}: {{{shown}}}")
    if model.unique:
        lines += ["", "unique: true"]
    return "\n".join(lines) + "\n"


def save_object(path: Path, model: ObjectModel, comments: tuple[str, ...] = ()) -> None:
    """Writes an object file. :raises ConfigError: where that is not possible."""
    try:
        path.write_text(object_yaml(model, comments), encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {error.strerror}") from None


def _shapes(model: ObjectModel) -> dict[tuple[str, str], str]:
    """(component, marker) -> name of its shape; equal shapes share one, different ones of one name are told apart."""
    names: dict[bytes, str] = {}
    shapes = {}
    for c in model.components:
        for m in c.markers:
            points = np.vstack([m.outline, m.tail, m.head])
            key = np.round(points, _DECIMALS + 1).tobytes()
            if key not in names:
                names[key] = m.name if m.name not in names.values() else f"{c.name}_{m.name}"
            shapes[c.name, m.name] = names[key]
    return shapes


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


def _component(c: Component, shapes: dict[tuple[str, str], str]) -> list[str]:
    lines = [f"  {_name(c.name)}:"]
    if c.required:
        lines.append("    required: true")
    if c.label is not None:
        lines.append(f"    label: {c.label}")
    if c.classes:
        if None in c.classes.values():
            raise ConfigError(f"component '{c.name}': the labels of its classes are not known, and cannot be written")
        alternatives = ", ".join(f"{_name(name)}: {label}" for name, label in c.classes.items())
        lines.append(f"    classes: {{{alternatives}}}")
    lines.append("    markers:")
    for m in c.markers:
        given = [] if shapes[c.name, m.name] == m.name else [f"marker: {_name(shapes[c.name, m.name])}"]
        if m.T_component_marker is not None:
            given.append(f"pose: {{{_pose(m.T_component_marker)}}}")
        lines.append(f"      {_name(m.name)}: {{{', '.join(given)}}}")
    if c.joint is not None:
        lines.append(f"    joint: {_joint(c.joint)}")
    if c.bodies:
        lines += ["    body:"] + ([] if c.body_label is None else [f"      label: {c.body_label}"]) + ["      boxes:"]
        lines += [f"        - {{{_pose(b.T_component_box)}, size: {_vector(b.size)}}}" for b in c.bodies]
    return lines


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
