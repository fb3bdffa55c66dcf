"""An object from a URDF and the markers that sit on its links.

Read with the standard library: of a URDF only names, origins, axes, limits and boxes are wanted, for which yourdfpy
would bring 350 MB and urdf_parser_py 16 MB.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array, Pose
from ...core.model.marker import Marker
from ...core.model.names import is_name
from ...core.model.objects import Box, Component, Joint, ObjectModel
from ...core.model.solids import closed_components
from ..base.yaml_files import nearest
from .marker_shapes import safe_name
from .urdf import link_body, numbers, read_robot

_STANDS_OUT = 1.3  # cubes that stand for a ball have corners 28 % farther out than its sides, squares for a tube 11 %
_KINDS = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic", "fixed": "fixed"}


@dataclass(frozen=True)
class UrdfJoint:
    """A joint as the URDF has it; `kind` is one of `Joint`'s."""

    name: str
    kind: str
    parent: str
    child: str
    T_parent_joint: Pose
    axis: Array
    lower: float
    upper: float
    mimics: bool


@dataclass(frozen=True)
class UrdfObject:
    """The object, and one line for everything that the user should know of how it was made."""

    model: ObjectModel
    notes: tuple[str, ...]


def object_from_urdf(
    path: Path, stickers: ObjectModel, name: str | None = None, body_label: int | None = None
) -> UrdfObject:
    """Joins a URDF's kinematics and boxes with markers. The first link that bears one gives the object's frame.

    :param stickers: an object whose components are named after links; their joints and bodies are not looked at.
    :param name: of the object; None: the robot's. :param body_label: class label of all bodies, where they have one.
    :raises ConfigError: no URDF, an unknown link, a link that moves and bears no marker while one behind it does.
    """
    robot = read_robot(path)
    links = [e.get("name", "") for e in robot.findall("link")]
    joints = {j.child: j for j in (_joint(e, path) for e in robot.findall("joint"))}
    marked = {c.name: c for c in stickers.components}
    for component in marked:
        if component not in links:
            raise ConfigError(f"{path}: there is no link '{component}'{nearest(component, links)}")
    parts = _rigid_parts(_in_order(links, joints, path), joints, set(marked))
    notes: list[str] = []
    components: list[Component] = []
    for part in parts:
        if part.marked is None:
            continue
        joint = _carried_by(part, not components, path)
        own = marked[part.marked]
        boxes = _boxes(part, path, notes, own)
        markers = tuple(_moved(m, part.pose_of(part.marked)) for m in own.markers)
        components.append(replace(own, markers=markers, joint=joint, bodies=boxes, body_label=body_label))
        if part.joint is not None and part.joint.mimics:
            notes.append(f"joint '{part.joint.name}' mimics another; here it moves on its own")
    if bare := [link for p in parts if p.marked is None and p.joint is not None for link in p.links]:
        notes.append(f"links that move and bear no marker are left out: {', '.join(bare)}")
    return UrdfObject(
        ObjectModel(name or safe_name(robot.get("name", "") or path.stem), tuple(components)), tuple(notes)
    )


@dataclass
class _Part:
    """Links that are fixed to one another.

    :param links: link -> T_part_link. :param marked: the one that bears markers, which names the component.
    :param joint: what carries it, None: nothing does. :param T_parent_joint: where that is on `parent`.
    """

    links: dict[str, Pose]
    marked: str | None
    parent: _Part | None = None
    joint: UrdfJoint | None = None
    T_parent_joint: Pose = field(default_factory=Pose.identity)
    is_root: bool = False

    def pose_of(self, link: str) -> Pose:
        """T_component_link: a component's frame is its joint's; the first one's is that of its marked link."""
        T = self.links[link]
        return self.links[self.marked].inverse() @ T if self.is_root and self.marked else T


def _rigid_parts(order: Iterator[str], joints: dict[str, UrdfJoint], marked: set[str]) -> list[_Part]:
    """Every link in one part; a second marked link of a rigid part becomes a part of its own, fixed to the first."""
    parts: list[_Part] = []
    of: dict[str, _Part] = {}
    for link in order:
        joint = joints.get(link)
        if joint is None:
            of[link] = _Part({link: Pose.identity()}, link if link in marked else None)
            parts.append(of[link])
            continue
        parent = of[joint.parent]
        T = parent.links[joint.parent] @ joint.T_parent_joint
        if joint.kind == "fixed" and (link not in marked or parent.marked is None):
            parent.links[link] = T
            parent.marked = link if link in marked else parent.marked
            of[link] = parent
        else:
            of[link] = _Part({link: Pose.identity()}, link if link in marked else None, parent, joint, T)
            parts.append(of[link])
    return parts


def _carried_by(part: _Part, is_first: bool, path: Path) -> Joint | None:
    """What carries a marked part on the marked part before it; None for the first."""
    part.is_root = is_first
    if is_first:
        return None
    parent, joint = part.parent, part.joint
    if parent is None or joint is None or parent.marked is None:
        bare = next(iter(parent.links)) if parent else "?"
        raise ConfigError(
            f"{path}: link '{part.marked}' hangs on '{bare}', which bears no marker, and two joints in a row cannot be "
            f"told apart; put a marker on '{bare}', or make one of the two joints fixed (docs/object_file.md)"
        )
    T = parent.links[parent.marked].inverse() @ part.T_parent_joint if parent.is_root else part.T_parent_joint
    if joint.kind == "fixed":
        return Joint(parent.marked, T, np.array([0.0, 0.0, 1.0]), 0.0, 0.0, "fixed")
    name = joint.name if is_name(joint.name) else safe_name(joint.name)  # a URDF's may have slashes
    name = "" if name == part.marked else name
    return Joint(parent.marked, T, joint.axis, joint.lower, joint.upper, joint.kind, name)


def _boxes(part: _Part, path: Path, notes: list[str], own: Component) -> tuple[Box, ...]:
    """The bodies of all links of a part, in its component's frame; what cannot be read is left out, and noted.

    :param own: what bears markers. Of a box, cylinder or ball of one colour the body is its own: boxes that stand for
        the same are a little larger here and there, and would hide its sides. A ball has no other: its frame is turned
        to the camera.
    """
    solid = own.name in closed_components(ObjectModel(own.name, (replace(own, required=True, joint=None),)))
    boxes = [Box(part.pose_of(own.name) @ b.T_component_box, b.size) for b in own.bodies] if solid else []
    sides = [_moved(m, part.pose_of(own.name)) for m in own.markers]
    for link in part.links:
        try:
            found = link_body(path, link)
        except ConfigError as error:
            if "no geometry" not in str(error):
                notes.append(str(error).replace("; list the body's boxes in the object file", "") + ": it gets no body")
            continue
        placed = [Box(part.pose_of(link) @ b.T_component_box, b.size) for b in found.boxes]
        beside = [b for b in placed if not (solid and _is_within(b, sides))]
        if beside and own.ball is not None:
            notes.append(f"{path}: link '{link}': what is beside the ball '{own.name}' hides nothing")
            continue
        notes += found.notes if beside else ()
        boxes += beside
    return tuple(boxes)


def _is_within(box: Box, sides: Sequence[Marker]) -> bool:
    """Whether a box lies, but for what its corners stand out, in a ball, or in what markers close in."""
    known = [m.T_component_marker for m in sides if m.T_component_marker is not None]
    at, normals = np.array([T.position for T in known]), np.array([T.rotation[:, 2] for T in known])
    middle, ends = at.mean(axis=0), np.array(list(product((-0.5, 0.5), repeat=3)))
    off = box.T_component_box.apply(ends * box.size) - middle
    if sides[0].is_ball:
        return bool((np.linalg.norm(off, axis=1) <= _STANDS_OUT * sides[0].radius).all())
    above = off @ normals.T
    return bool((above <= _STANDS_OUT * ((at - middle) * normals).sum(axis=1)).all())


def _moved(marker: Marker, T: Pose) -> Marker:
    place = marker.T_component_marker
    return marker if place is None else replace(marker, T_component_marker=T @ place)


def _joint(element: ElementTree.Element, path: Path) -> UrdfJoint:
    name = element.get("name", "")
    place = f"{path}: joint '{name}'"
    ends = [element.find(end) for end in ("parent", "child")]
    parent, child = ("" if e is None else e.get("link", "") for e in ends)
    if not parent or not child:
        raise ConfigError(f"{place}: names no parent or no child link")
    kind = element.get("type", "")
    if kind not in _KINDS:
        raise ConfigError(f"{place}: type '{kind}' is not supported (supported: {', '.join(_KINDS)})")
    origin, axis, limit = (element.find(tag) for tag in ("origin", "axis", "limit"))
    T = Pose.identity()
    if origin is not None:
        xyz, rpy = (numbers(origin.get(key, "0 0 0"), 3, f"{place}: {key}") for key in ("xyz", "rpy"))
        T = Pose.from_xyz_rpy(xyz, rpy)
    direction = np.array(numbers("1 0 0" if axis is None else axis.get("xyz", "1 0 0"), 3, f"{place}: axis"))
    length = float(np.linalg.norm(direction))
    if length < 1e-9:
        raise ConfigError(f"{place}: axis: its length is zero")
    lower, upper = -math.pi, math.pi
    if kind in ("revolute", "prismatic"):
        if limit is None:
            raise ConfigError(f"{place}: limit: this element is missing; a {kind} joint needs lower and upper")
        lower, upper = (numbers(limit.get(key, "0"), 1, f"{place}: {key}")[0] for key in ("lower", "upper"))
        if not lower < upper:
            raise ConfigError(f"{place}: the lower limit {lower:g} must be below the upper {upper:g}")
    mimics = element.find("mimic") is not None
    return UrdfJoint(name, _KINDS[kind], parent, child, T, direction / length, lower, upper, mimics)


def _in_order(links: list[str], joints: dict[str, UrdfJoint], path: Path) -> Iterator[str]:
    """Links, parents before children."""
    done: set[str] = set()
    waiting = list(links)
    while waiting:
        ready = [link for link in waiting if link not in joints or joints[link].parent in done]
        if not ready:
            raise ConfigError(f"{path}: joints form a ring, or hang on a link that is not there: {', '.join(waiting)}")
        yield from ready
        done |= set(ready)
        waiting = [link for link in waiting if link not in done]
