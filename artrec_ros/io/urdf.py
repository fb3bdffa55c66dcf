"""URDF files: a link's boxes as the body of a component. Kinematics are read in urdf_model.py."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

from ..core.base.errors import ConfigError
from ..core.geometry.transforms import Pose, readonly
from ..core.model.objects import Box
from .files import nearest, read_text


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


def link_boxes(path: Path, link: str) -> tuple[Box, ...]:
    """The boxes of a link's collision geometry, of its visual geometry where it has no collision one; link frame.

    Other shapes are refused: a body that is larger or smaller than the real one is worse than none.
    """
    robot = read_robot(path)
    links = {element.get("name", ""): element for element in robot.iter("link")}
    if link not in links:
        raise ConfigError(f"{path}: there is no link '{link}'{nearest(link, links)}")
    parts = links[link].findall("collision") or links[link].findall("visual")
    if not parts:
        raise ConfigError(f"{path}: link '{link}' has no geometry; list the body's boxes in the object file")
    return tuple(_box(part, f"{path}: link '{link}'") for part in parts)


def _box(part: ElementTree.Element, place: str) -> Box:
    box, origin = part.find("geometry/box"), part.find("origin")
    if box is None:
        raise ConfigError(f"{place}: its geometry must be boxes only; list the body's boxes in the object file")
    size = numbers(box.get("size", ""), 3, f"{place}: box size")
    if min(size) <= 0:
        raise ConfigError(f"{place}: box size: must be greater than 0")
    xyz, rpy = ("0 0 0", "0 0 0") if origin is None else (origin.get("xyz", "0 0 0"), origin.get("rpy", "0 0 0"))
    return Box(Pose.from_xyz_rpy(numbers(xyz, 3, f"{place}: xyz"), numbers(rpy, 3, f"{place}: rpy")), readonly(size))


def numbers(text: str, count: int, place: str) -> tuple[float, ...]:
    """So many finite numbers of an attribute; :param place: what the error names."""
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != count or not all(map(math.isfinite, values)):
        raise ConfigError(f"{place}: needs {count} number(s), not '{text}'")
    return values
