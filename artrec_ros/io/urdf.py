"""A link's boxes from a URDF file, as the body of a component."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

from ..core.errors import ConfigError
from ..core.objects import Box
from ..core.transforms import Pose, readonly
from .files import nearest, read_text


def link_boxes(path: Path, link: str) -> tuple[Box, ...]:
    """The boxes of a link's collision geometry, of its visual geometry where it has no collision one; link frame.

    Other shapes are refused: a body that is larger or smaller than the real one is worse than none.
    """
    try:
        robot = ElementTree.fromstring(read_text(path))
    except ElementTree.ParseError as error:
        raise ConfigError(f"{path}: is no valid URDF (XML): {error}") from None
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
    size = _numbers(box.get("size", ""), f"{place}: box size")
    if min(size) <= 0:
        raise ConfigError(f"{place}: box size: must be greater than 0")
    xyz, rpy = ("0 0 0", "0 0 0") if origin is None else (origin.get("xyz", "0 0 0"), origin.get("rpy", "0 0 0"))
    return Box(Pose.from_xyz_rpy(_numbers(xyz, f"{place}: xyz"), _numbers(rpy, f"{place}: rpy")), readonly(size))


def _numbers(text: str, place: str) -> tuple[float, ...]:
    try:
        values = tuple(float(word) for word in text.split())
    except ValueError:
        values = ()
    if len(values) != 3 or not all(map(math.isfinite, values)):
        raise ConfigError(f"{place}: needs three numbers, not '{text}'")
    return values
