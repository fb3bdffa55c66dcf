"""Parameters as flat, typed, described names: derived from the dataclasses of core/base/config, once for all."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ...core.base.config import (
    PATHS,
    ClassConfig,
    DesignConfig,
    FloorConfig,
    ImageConfig,
    LearningConfig,
    NodeConfig,
    ObjectConfig,
    PlaneConfig,
    RecognizerConfig,
    SceneConfig,
    TrackingConfig,
    rooms_of,
)
from ..base.yaml_files import Value

EXPERT = "expert."
LIVE = ("image.", "recognizer.", "scene.", "tracking.", EXPERT, "marker_lifetime_s", "no_image_after_s")
"""What may be changed while the node runs: all parameters of a group, or one."""
_FIXED = ("image.classes",)  # it decides which other parameters there are

_MOST_INT = 2**31 - 1  # where nothing else is said: no count of pixels or objects is greater


@dataclass(frozen=True)
class Spec:
    """One parameter: a scalar, or a list of `type` where `is_list`; low and high bound each item, inclusively.

    :param length: how many items a list has; 0: any number.
    """

    name: str
    type: type
    is_list: bool
    default: Any
    description: str
    unit: str
    low: float | None
    high: float | None
    choices: tuple[str, ...]
    paths: tuple[str, ...] = PATHS
    calibrated: bool = False
    origin: str = ""
    length: int = 0

    @property
    def is_expert(self) -> bool:
        """Whether it is a room's own: declared and written only where it is given."""
        return self.name.startswith(EXPERT)

    @property
    def is_live(self) -> bool:
        """Whether it may be changed while the node runs."""
        return self.name.startswith(LIVE) and self.name not in _FIXED

    def read(self, value: Value) -> Any:
        """The value in this parameter's type, a tuple for lists; `ConfigError` where it does not fit."""
        if not self.is_list:
            return self._item(value)
        items = tuple(self._item(v) for v in value.items())
        if self.default and not items:
            raise value.error(f"the list is empty; leave it out for its default {list(self.default)}")
        if self.length and len(items) != self.length:
            raise value.error(f"{len(items)} numbers are given; it has {self.length}, such as {list(self.default)}")
        return items

    def _item(self, value: Value) -> Any:
        if self.type is bool:
            return value.boolean()
        if self.type is int:
            return value.integer(self.low, _MOST_INT if self.high is None else self.high)
        if self.type is float:
            return value.number(self.low, self.high)
        return value.text(self.choices) if self.choices or value.raw != "" else ""


def specs_of(config: type, prefix: str = "") -> list[Spec]:
    """The parameters of a dataclass whose fields are made by `param`; other fields are no parameters."""
    hints, specs = typing.get_type_hints(config), []
    for f in dataclasses.fields(config):
        if "description" not in f.metadata:
            continue
        is_list = typing.get_origin(hints[f.name]) is tuple
        kind = typing.get_args(hints[f.name])[0] if is_list else hints[f.name]
        specs.append(Spec(name=prefix + f.name, type=kind, is_list=is_list, default=f.default, **f.metadata))
    return specs


def expert_rooms() -> dict[str, type]:
    """The configs of rooms by their names in files, in the order of the configs that hold them."""
    holders = (RecognizerConfig, ImageConfig, TrackingConfig)
    return {name: room for config in holders for name, room in rooms_of(config).items()}


def offline_rooms() -> dict[str, type]:
    """The configs of rooms that no parameter file reaches."""
    return {"learning": LearningConfig, "design": DesignConfig}


def all_specs(objects: Iterable[str], classes: Iterable[str]) -> dict[str, Spec]:
    """Every parameter of a set-up with these objects and pixel classes, by its full name."""
    specs = [
        _names("objects", "the objects to look for; each has parameters NAME.object_file, ..."),
        *(s for name in objects for s in specs_of(ObjectConfig, f"{name}.")),
        *specs_of(ImageConfig, "image."),
        _names("image.classes", "palette, colour: the pixel classes; each has parameters image.NAME.label, ..."),
        *(s for name in classes for s in specs_of(ClassConfig, f"image.{name}.")),
        *specs_of(RecognizerConfig, "recognizer."),
        *specs_of(SceneConfig, "scene."),
        *specs_of(PlaneConfig, "scene.plane."),
        *specs_of(FloorConfig, "scene.floor."),
        *specs_of(TrackingConfig, "tracking."),
        *specs_of(NodeConfig),
        *(s for name, room in expert_rooms().items() for s in specs_of(room, f"{EXPERT}{name}.")),
    ]
    return {s.name: s for s in specs}


def moved(key: str, specs: Iterable[str]) -> str | None:
    """The expert parameter that an unknown one has become, by its own name or with its room's before it."""
    last, specs = key.rpartition(".")[2], list(specs)
    if any(name.rpartition(".")[2] == last and not name.startswith(EXPERT) for name in specs):
        return None  # its group is misspelt
    for name in specs:  # the first of one name: profile paper's, which were told apart by `paper_`, come last
        if name.startswith(EXPERT):
            _, room, own = name.split(".")
            if last in (own, f"{room}_{own}"):
                return name
    return None


def _names(name: str, description: str) -> Spec:
    return Spec(name, str, True, (), description, "", None, None, ())
