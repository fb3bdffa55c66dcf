"""What an articulated object is: components, with markers, joints and bodies. All of it is data.

Component frame: the object's frame, or, where a joint carries the component, the joint's frame turned by the joint
angle (URDF's link frame); metres.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..base.config import GREATEST_LABEL
from ..base.errors import ConfigError
from ..geometry.transforms import Array, Pose, readonly
from .marker import Marker
from .names import check_name

_FLAT = 0.999  # cosine: within 2.6 degrees


@dataclass(frozen=True)
class Box:
    """A body's box in its component's frame: centre pose and full size, metres."""

    T_component_box: Pose
    size: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", readonly(self.size))


@dataclass(frozen=True)
class Joint:
    """What carries a component: URDF's joint. Revolute about `axis` (unit, joint frame), limits in radians.

    :param kind: 'revolute', 'prismatic' (limits in metres) or 'fixed'. :param name: '': that of its component.
    """

    parent: str
    T_parent_joint: Pose
    axis: Array
    lower: float
    upper: float
    kind: str = "revolute"
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "axis", readonly(self.axis))

    @property
    def is_endless(self) -> bool:
        """Whether it turns without limit: it has a whole turn, which files tell with few digits."""
        return self.kind == "revolute" and self.upper - self.lower >= 2 * np.pi - 1e-4

    @property
    def span(self) -> tuple[float, float]:
        """Least and greatest value that is told: its limits; of several turns, which nobody can tell apart, the one in
        their middle."""
        if self.kind == "revolute" and self.upper - self.lower > 2 * np.pi:
            middle = (self.lower + self.upper) / 2
            return middle - np.pi, middle + np.pi
        return self.lower, self.upper

    @property
    def unit(self) -> str:
        """Of its value and limits."""
        return "m" if self.kind == "prismatic" else "rad"


@dataclass(frozen=True)
class Component:
    """A rigid part of an object.

    :param markers: the markers that can show it; each may be seen alone.
    :param label: class label of its markers; None: the object's own.
    :param classes: class name -> label, where its markers may be of one of several classes, which tell the object's
        identity; `label` is then None. A label is None where it is not known, and does not matter (training).
    :param bodies: boxes that hide what is behind them, coloured `body_label` (None: colour unknown).
    :param unborne: further classes by name, which no identity of its object shows.
    """

    name: str
    markers: tuple[Marker, ...]
    required: bool = False
    label: int | None = None
    joint: Joint | None = None
    bodies: tuple[Box, ...] = ()
    body_label: int | None = None
    classes: Mapping[str, int | None] = field(default_factory=dict)
    unborne: Mapping[str, int | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_name(self.name, "component")
        for name in self.classes:
            check_name(name, "class")
        if self.classes and self.label is not None:
            raise ConfigError(f"component '{self.name}': give it either one label or alternative classes")
        for label in (self.label, self.body_label, *self.classes.values()):
            if label is not None and not 1 <= label <= GREATEST_LABEL:
                raise ConfigError(f"component '{self.name}': the label {label} is not within 1 .. {GREATEST_LABEL}")

        known = [label for label in self.classes.values() if label is not None]
        if len(set(known)) < len(known):
            raise ConfigError(
                f"component '{self.name}': two of its classes have the same label; nothing tells them apart"
            )

    def marker(self, name: str) -> Marker:
        return next(m for m in self.markers if m.name == name)

    @property
    def ball(self) -> Marker | None:
        """What shows it where it is a ball, and nothing else does."""
        return next((m for m in self.markers if m.is_ball), None)

    @property
    def is_disc(self) -> bool:
        """Whether each of its markers is a disc: seen alone it tells no direction."""
        return all(m.disc_radius is not None for m in self.markers)

    @property
    def body_labels(self) -> tuple[int, ...]:
        """The class label of its bodies; none where their colour is not known."""
        return () if self.body_label is None else (self.body_label,)

    def labels(self, default: int) -> tuple[int, ...]:
        """Class labels that its markers may have. :param default: the object's own."""
        known = {label for label in self.classes.values() if label is not None}
        return tuple(sorted(known)) or (default if self.label is None else self.label,)


@dataclass(frozen=True)
class Identity:
    """Which one of several like objects it is: the class that each of its components with alternatives shows.

    :param classes: component -> class name.
    """

    name: str
    classes: Mapping[str, str]


@dataclass(frozen=True)
class ObjectModel:
    """An articulated object. Components are ordered parents first where joints are declared.

    :param identities: those that exist, of an object whose components have alternative classes; else none.
    :param unique: whether each identity occurs once at most; of an object without identities, whether it does.
    """

    name: str
    components: tuple[Component, ...]
    identities: tuple[Identity, ...] = ()
    unique: bool = False

    def __post_init__(self) -> None:
        check_name(self.name, "object")
        names = [c.name for c in self.components]
        if len(set(names)) != len(names):
            raise ConfigError(f"object '{self.name}': two components have the same name")
        if sum(c.required for c in self.components) != 1:
            raise ConfigError(
                f"object '{self.name}': exactly one component must be required: give one "
                "'required: true', which is seen best"
            )
        seen: set[str] = set()
        for c in self.components:
            if c.joint is not None and c.joint.parent not in seen:
                raise ConfigError(
                    f"object '{self.name}': component '{c.name}' hangs on '{c.joint.parent}', which is no "
                    f"component listed before it ({', '.join(n for n in names if n in seen) or 'none'})"
                )
            seen.add(c.name)
        for name in (n for n in self.joint_names if self.joint_names.count(n) > 1):
            raise ConfigError(f"object '{self.name}': two joints have the same name '{name}'")
        self._check_identities()
        object.__setattr__(self, "components", tuple(map(self._narrowed, self.components)))

    def _narrowed(self, component: Component) -> Component:
        """With those classes that some identity bears, where identities are declared: others are something else's, and
        would make a blob of theirs an object that does not exist."""
        borne = {identity.classes[component.name] for identity in self.identities if component.classes}
        if not borne or borne >= component.classes.keys():
            return component
        split = [{k: v for k, v in component.classes.items() if (k in borne) == which} for which in (True, False)]
        return replace(component, classes=split[0], unborne=split[1])

    def _check_identities(self) -> None:
        own = {c.name: c.classes for c in self.components if c.classes}
        seen: dict[tuple[str, ...], str] = {}
        for identity in self.identities:
            check_name(identity.name, "identity")
            if set(identity.classes) != set(own):
                raise ConfigError(
                    f"object '{self.name}': identity '{identity.name}' must say the class of each component that has "
                    f"alternatives: {', '.join(own) or 'none has'}"
                )
            for name, cls in identity.classes.items():
                if cls not in own[name]:
                    raise ConfigError(
                        f"object '{self.name}': identity '{identity.name}': component '{name}' has no class '{cls}'; "
                        f"it has {', '.join(own[name])}"
                    )
            shown = tuple(identity.classes[name] for name in own)
            if shown in seen or identity.name in seen.values():
                other = seen.get(shown, identity.name)
                raise ConfigError(f"object '{self.name}': identities '{other}' and '{identity.name}' are the same")
            seen[shown] = identity.name

    @property
    def required(self) -> Component:
        """The component from which groups grow (the paper's torso)."""
        return next(c for c in self.components if c.required)

    def component(self, name: str) -> Component:
        return next(c for c in self.components if c.name == name)

    @cached_property
    def markers(self) -> dict[tuple[str, str], Marker]:
        """All markers, by the names of their components and their own, in order."""
        return {(c.name, m.name): m for c in self.components for m in c.markers}

    @cached_property
    def joint_components(self) -> tuple[Component, ...]:
        """Components that a moving joint carries, in order: the joint vector's order."""
        return tuple(c for c in self.components if c.joint is not None and c.joint.kind != "fixed")

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """What these joints are called in results and messages: by their own names, else by their components'."""
        return tuple((c.joint and c.joint.name) or c.name for c in self.joint_components)

    @cached_property
    def joints(self) -> dict[str, Joint]:
        """These joints by these names, in the same order."""
        joints = zip(self.joint_names, self.joint_components, strict=True)
        return {name: c.joint for name, c in joints if c.joint is not None}

    @cached_property
    def is_spatial(self) -> bool:
        """Whether every marker has a place in space and every component a fixed or jointed frame."""
        return all(m.T_component_marker is not None for m in self.markers.values())

    @cached_property
    def needs_another(self) -> bool:
        """Whether the required component alone tells no direction, seen from its front: it is a disc, and others are
        there."""
        return [m.disc_radius is not None for m in self.required.markers] == [True] and len(self.components) > 1

    @cached_property
    def is_flat(self) -> bool:
        """Whether all markers lie face up in planes that nothing turns out of each other: seen from their front, the
        object is a figure in the image plane."""
        if not self.is_spatial or any(c.ball for c in self.components):
            return False
        up: dict[str, Array] = {}
        for c in self.components:
            R = np.eye(3)
            if c.joint is not None:
                R = up[c.joint.parent] @ c.joint.T_parent_joint.rotation
            up[c.name] = R
        normals = np.array([up[c.name] @ m.T_component_marker.rotation[:, 2] for c in self.components for m in c.markers
                            if m.T_component_marker is not None])  # fmt: skip
        axes = [(c.joint.kind, up[c.name] @ c.joint.axis) for c in self.joint_components if c.joint is not None]
        across = np.sqrt(1 - _FLAT**2)
        stays = [
            abs(float(axis @ normals[0])) > _FLAT if kind == "revolute" else abs(float(axis @ normals[0])) < across
            for kind, axis in axes
        ]
        return bool((normals @ normals[0] > _FLAT).all() and all(stays))
