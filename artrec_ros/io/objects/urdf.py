"""URDF files: a link's geometry as the body of a component. Kinematics are read in urdf_model.py."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array, Pose, readonly
from ...core.model.objects import Box
from ..base.yaml_files import nearest, read_text
from .meshes import stl_bounds

_CYLINDER = 0.764  # half a side over the radius: two squares at 45 degrees are as wide as the circle from every side
_SPHERE = 0.62  # the same for three cubes, each turned about another axis
_THINNEST_M = 1e-4  # a flat mesh is a thin box


def read_robot(path: Path) -> ElementTree.Element:
    """The `robot` element of a URDF. :raises ConfigError: no file, no XML, a xacro file, another root."""
    try:
        robot = ElementTree.fromstring(read_text(path))
    except ElementTree.ParseError as error:
        raise ConfigError(f"{path}: is no valid URDF (XML): {error}") from None
    if robot.tag != "robot":
        raise ConfigError(f"{path}: is no URDF: its root is '{robot.tag}', not 'robot'")
    if any("xacro" in element.tag for element in robot.iter()):
        raise ConfigError(f"{path}: is a xacro file; make a URDF of it first: xacro {path.name} > robot.urdf")
    return robot


@dataclass(frozen=True)
class LinkBody:
    """A link's geometry as boxes, in the link's frame. :param notes: a line for what is not exactly so."""

    boxes: tuple[Box, ...]
    notes: tuple[str, ...]


def link_body(path: Path, link: str) -> LinkBody:
    """A link's collision geometry, or its visual geometry where it has no collision one, as boxes.

    Cylinders and spheres become two and three boxes turned against each other, which stand out and fall short by less
    than an eighth of the radius. Of a mesh the bounding box is taken.

    :raises ConfigError: no such link, no geometry, a mesh that is not there or is no STL.
    """
    robot = read_robot(path)
    links = {element.get("name", ""): element for element in robot.iter("link")}
    if link not in links:
        raise ConfigError(f"{path}: there is no link '{link}'{nearest(link, links)}")
    parts = links[link].findall("collision") or links[link].findall("visual")
    if not parts:
        raise ConfigError(f"{path}: link '{link}' has no geometry; list the body's boxes in the object file")
    boxes: list[Box] = []
    notes: list[str] = []
    for part in parts:
        place = f"{path}: link '{link}'"
        T, shape = _origin(part, place), next(iter(part.find("geometry") or ()), None)
        found = _as_boxes(shape, place)
        boxes += [Box(T @ b.T_component_box, b.size) for b in found]
        if shape is not None and shape.tag != "box":
            how = "by its bounding box" if shape.tag == "mesh" else f"by {len(found)} boxes"
            notes.append(f"{place}: its {shape.tag} is approximated {how}")
    return LinkBody(tuple(boxes), tuple(notes))


def _origin(part: ElementTree.Element, place: str) -> Pose:
    origin = part.find("origin")
    if origin is None:
        return Pose.identity()
    xyz, rpy = (numbers(origin.get(key, "0 0 0"), 3, f"{place}: {key}") for key in ("xyz", "rpy"))
    return Pose.from_xyz_rpy(xyz, rpy)


def _as_boxes(shape: ElementTree.Element | None, place: str) -> list[Box]:
    """In the shape's own frame."""
    if shape is None or shape.tag not in ("box", "cylinder", "sphere", "mesh"):
        kind = "no geometry" if shape is None else f"'{shape.tag}'"
        raise ConfigError(f"{place}: {kind} is no body; list the body's boxes in the object file")
    if shape.tag == "mesh":
        return [_mesh_box(shape, place)]
    if shape.tag == "box":
        return [Box(Pose.identity(), _sizes(shape, place, size=3))]
    if shape.tag == "sphere":
        (radius,) = _sizes(shape, place, radius=1)
        turns = np.eye(3) * math.pi / 4
        return [Box(Pose.from_xyz_rpy((0, 0, 0), turn), readonly([2 * _SPHERE * radius] * 3)) for turn in turns]
    radius, length = _sizes(shape, place, radius=1, length=1)
    size = readonly([2 * _CYLINDER * radius, 2 * _CYLINDER * radius, length])
    return [Box(Pose.from_xyz_rpy((0, 0, 0), (0, 0, turn)), size) for turn in (0.0, math.pi / 4)]


def _sizes(shape: ElementTree.Element, place: str, **wanted: int) -> Array:
    """The numbers of some attributes, one after the other; all above 0."""
    values: list[float] = []
    for key, count in wanted.items():
        own = numbers(shape.get(key, ""), count, f"{place}: {shape.tag} {key}")
        if min(own) <= 0:
            raise ConfigError(f"{place}: {shape.tag} {key}: must be greater than 0")
        values += own
    return readonly(values)


def _mesh_box(mesh: ElementTree.Element, place: str) -> Box:
    name = mesh.get("filename", "")
    path = _mesh_file(name, Path(place.partition(": link ")[0]))
    way_out = "list the body's boxes in the object file"
    if path is None:
        raise ConfigError(f"{place}: mesh '{name}' is not found; {way_out}")
    if path.suffix.lower() != ".stl":
        raise ConfigError(f"{place}: mesh '{name}' is no STL, the only kind that is read; {way_out}")
    scale = np.array(numbers(mesh.get("scale", "1 1 1"), 3, f"{place}: mesh scale"))
    low, high = stl_bounds(path)
    low, high = np.minimum(low * scale, high * scale), np.maximum(low * scale, high * scale)
    size = np.maximum(high - low, _THINNEST_M)
    return Box(Pose(np.eye(3), (low + high) / 2), readonly(size))


def _mesh_file(name: str, urdf: Path) -> Path | None:
    """The file that a URDF names: a path, a file:// URL, or package://NAME/... of a package in which the URDF lies or
    that lies beside it; None: there is none."""
    if name.startswith("package://"):
        package, _, rest = name.removeprefix("package://").partition("/")
        folders = urdf.resolve().parents
        found = [f / rest for f in folders if f.name == package] + [f / package / rest for f in folders]
    else:
        found = [urdf.parent / name.removeprefix("file://")]
    return next((path for path in found if path.is_file()), None)


def numbers(text: str, count: int, place: str) -> tuple[float, ...]:
    """So many finite numbers of an attribute; :param place: what the error names."""
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if "${" in text:
        raise ConfigError(f"{place}: '{text}' is xacro's; make a URDF first: xacro ROBOT.xacro > robot.urdf")
    if len(values) != count or not all(map(math.isfinite, values)):
        raise ConfigError(f"{place}: needs {count} number(s), not '{text}'")
    return values
