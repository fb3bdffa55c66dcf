"""The node's parameter file, read without ROS: the same file gives the same recogniser on the robot and offline."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from ...core.base.config import (
    ClassConfig,
    FloorConfig,
    ImageConfig,
    NodeConfig,
    ObjectConfig,
    PlaneConfig,
    RecognizerConfig,
    SceneConfig,
    TrackingConfig,
    rooms_of,
)
from ...core.base.errors import ConfigError
from ...core.geometry.scene import Scene
from ...core.image.segmentation import Segmenter
from ...core.model.target import Target
from ...core.recognizer import Recognizer
from ...core.warm_up import Told
from ..base.yaml_files import Value, nearest
from .sections import SECTION, read_files
from .specs import EXPERT, Spec, all_specs, moved, specs_of
from .targets import colourless, lacking, load_target, same_labels, unclassed, with_absolute_paths

_ROS_OWN = ("use_sim_time", "start_type_description_service")  # every ROS node has these
_ROS_OWN_PREFIX = "qos_overrides."
_RESERVED = ("objects", "image", "recognizer", "scene", "tracking", "expert", "qos_overrides")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


NO_FILE = "parameters"
"""What errors name in place of a file where values come from none."""


@dataclass(frozen=True)
class Setup:
    """All that a recogniser is made of.

    :param objects: what `targets` were read from, file names absolute.
    :param resolved: every parameter by its flat name, defaults included, file names absolute; of those for experts
        only what was given. Empty lists are left out: ROS cannot tell their type, and each is its parameter's default.
    """

    targets: tuple[Target, ...]
    objects: dict[str, ObjectConfig]
    image: ImageConfig
    recognizer: RecognizerConfig
    tracking: TrackingConfig
    node: NodeConfig
    resolved: dict[str, Any]

    def build(self, *, calibrated: bool = True, told: Told = lambda share: None) -> Recognizer:
        """The recogniser with these parameters, ready for images with or without calibration."""
        return Recognizer(self.targets, self.recognizer, Segmenter(self.image), calibrated=calibrated, told=told)

    def lacks(self, calibrated: bool = True) -> list[str]:
        """A line for each object that cannot be found with what the files tell, and for classes without a colour;
        `calibrated`: the images are."""
        return [
            *colourless(self.image),
            *unclassed(self.targets, self.image),
            *lacking(self.targets, self.recognizer, calibrated),
        ]

    @property
    def specs(self) -> dict[str, Spec]:
        """Every parameter that it could be given, by its full name."""
        return all_specs(self.objects, self.image.classes)

    def value(self, name: str) -> Any:
        """A parameter's value, also where it was not given; lists as such."""
        if name in self.resolved:
            return self.resolved[name]
        default = self.specs[name].default
        return list(default) if isinstance(default, tuple) else default

    def changed(self, changes: Mapping[str, Any]) -> Setup:
        """The set-up with some values changed. Files are read again only for objects that the changes concern.

        :raises ConfigError: the values as a whole are not valid.
        """
        return setup_from_flat({**self.resolved, **changes}, Path(), previous=self)

    def to_yaml(self) -> str:
        """A parameter file that gives this set-up again, from wherever it lies."""
        return yaml.safe_dump({"/**": {SECTION: _nested(self.resolved)}}, sort_keys=False, default_flow_style=None)


def load_parameters(path: str | Path, *more: str | Path) -> Setup:
    """A set-up from a ROS parameter file, or several, as `read_files` reads them."""
    return setup_from_flat(*read_files(path, *more))


def setup_from_flat(
    flat: Mapping[str, Any],
    base_dir: Path,
    source: str | Path = NO_FILE,
    *,
    warn: Callable[[str], None] | None = None,
    previous: Setup | None = None,
) -> Setup:
    """A set-up from flat parameter values, as a ROS node holds them.

    :param base_dir: where relative file names start.
    :param source: what errors name as the values' file.
    :param warn: called with a line for each unknown parameter; without it an unknown one is an error.
    :param previous: its targets are taken over where nothing changed that they are read from.
    :raises ConfigError: a value, or a file that it names, is not valid.
    """
    values = _values(flat, source)
    objects = _read_names(values, "objects", _RESERVED)
    if not objects:
        what = "the list is empty" if "objects" in values else "this key is missing"
        raise ConfigError(f"{source}: objects: {what}; it lists the objects to look for, such as [red]")
    classes = _read_names(values, "image.classes", [f.name for f in dataclasses.fields(ImageConfig)])
    specs = all_specs(objects, classes)
    values = _known(values, specs, warn)
    image = _read_image(values, classes, str(source))
    recognizer = _read_config(
        RecognizerConfig, "recognizer.", values, str(source), scene=_read_scene(values, str(source))
    )
    tracking = _read_config(TrackingConfig, "tracking.", values, str(source))
    node = _read_config(NodeConfig, "", values, str(source))
    configs = {name: _read_object(name, values, base_dir, str(source)) for name in objects}
    kept = {}
    if previous is not None and same_labels(previous.image, image):
        kept = {t.name: t for t in previous.targets if configs.get(t.name) == previous.objects[t.name]}
    targets = tuple(kept.get(name) or load_target(name, config, image, values) for name, config in configs.items())
    resolved = _resolve(specs, values, {f"{n}.{k}": v for n, c in configs.items() for k, v in vars(c).items()})
    return Setup(targets, configs, image, recognizer, tracking, node, resolved)


def image_from_flat(flat: Mapping[str, Any], source: str | Path) -> ImageConfig:
    """What values of the section `image` say, of files that name no objects. As `setup_from_flat`."""
    values = _values(flat, source)
    classes = _read_names(values, "image.classes", [f.name for f in dataclasses.fields(ImageConfig)])
    return _read_image(_known(values, all_specs([], classes), None), classes, str(source))


def _values(flat: Mapping[str, Any], source: str | Path) -> dict[str, Value]:
    return {key: Value(Path(source), key, _plain(raw)) for key, raw in flat.items()}


def _known(
    values: Mapping[str, Value], specs: Mapping[str, Spec], warn: Callable[[str], None] | None
) -> dict[str, Value]:
    """The values of parameters that there are; each other one is told to `warn`, or raised.

    One that has another name now is always raised: it was ours, and would be dropped.
    """
    known = {}
    for key, value in values.items():
        if key in specs or key in _ROS_OWN or key.startswith(_ROS_OWN_PREFIX):
            known[key] = value
            continue
        new_name = moved(key, specs)
        if new_name is not None:
            raise value.error(f"this parameter is one for experts now: give it as {new_name}")
        if warn is None:
            raise value.error(f"unknown parameter{hint(key, specs)}")
        warn(str(value.error(f"unknown parameter, ignored{hint(key, specs)}")))
    return known


def _plain(raw: Any) -> Any:
    """Arrays of ROS' Python client as lists."""
    return raw if isinstance(raw, (str, bytes, dict)) or not hasattr(raw, "__iter__") else list(raw)


def hint(key: str, specs: Mapping[str, Spec]) -> str:
    """For an unknown parameter: the nearest known name, and the names beside it rather than all of them."""
    group, _, name = key.rpartition(".")
    if group.startswith("image.") and name in {f.name for f in dataclasses.fields(ClassConfig)}:
        known = {n.split(".")[1] for n in specs if n.startswith("image.") and n.endswith(f".{name}")}
        if not known:
            return ": image.classes lists no class"
        return f": '{group[6:]}' is not in image.classes of the last file that lists them{nearest(group[6:], known)}"
    if group not in _RESERVED and name in {f.name for f in dataclasses.fields(ObjectConfig)}:
        known = {n.removesuffix(".object_file") for n in specs if n.endswith(".object_file")}
        return f": '{group}' is not in objects{nearest(group, known)}"
    beside = [name for name in specs if name.rpartition(".")[0] == group]
    return nearest(key, beside or specs)


def _read_names(values: Mapping[str, Value], key: str, reserved: Iterable[str]) -> list[str]:
    names = []
    for item in values[key].items() if key in values else []:
        name = item.text()
        if not _NAME.fullmatch(name):
            raise item.error(f"'{name}' is no name; letters, digits and _, beginning with a letter")
        if name in reserved:
            raise item.error(f"'{name}' is the name of parameters; choose another")
        if name in names:
            raise item.error(f"'{name}' is listed twice")
        names.append(name)
    return names


def _read_config(config: type, prefix: str, values: Mapping[str, Value], source: str, **extra: Any) -> Any:
    """A dataclass, and the rooms' in it, from the values that are given; the others keep their defaults."""
    rooms = {n: _read_config(room, f"{EXPERT}{n}.", values, source) for n, room in rooms_of(config).items()}
    names = {s.name[len(prefix) :]: s for s in specs_of(config, prefix)}
    given = {name: spec.read(values[spec.name]) for name, spec in names.items() if spec.name in values}
    try:
        return config(**given, **rooms, **extra)
    except ConfigError as error:
        raise ConfigError(f"{source}: {error}") from None


def _read_image(values: Mapping[str, Value], classes: Iterable[str], source: str) -> ImageConfig:
    read = {}
    for name in classes:
        _require(ClassConfig, f"image.{name}.", ("label",), values, source)
        read[name] = _read_config(ClassConfig, f"image.{name}.", values, source)
    image: ImageConfig = _read_config(ImageConfig, "image.", values, source, classes=read)
    return image


def _read_scene(values: Mapping[str, Value], source: str) -> SceneConfig:
    plane = _read_config(PlaneConfig, "scene.plane.", values, source)
    floor = _read_config(FloorConfig, "scene.floor.", values, source)
    scene: SceneConfig = _read_config(SceneConfig, "scene.", values, source, plane=plane, floor=floor)
    try:
        Scene.of(scene)  # whether its points can be what they are said to be
    except ConfigError as error:
        raise ConfigError(f"{source}: {error}") from None
    return scene


def _require(config: type, prefix: str, keys: Iterable[str], values: Mapping[str, Value], source: str) -> None:
    """:raises ConfigError: one of a dataclass' parameters is not given; the message says what it is."""
    specs = {s.name: s for s in specs_of(config, prefix)}
    for name in (prefix + key for key in keys):
        if name not in values:
            raise ConfigError(f"{source}: {name}: this key is missing: {specs[name].description}")


def _read_object(name: str, values: Mapping[str, Value], base_dir: Path, source: str) -> ObjectConfig:
    _require(ObjectConfig, f"{name}.", ("object_file", "label"), values, source)
    config: ObjectConfig = _read_config(ObjectConfig, f"{name}.", values, source)
    return with_absolute_paths(config, name, values, base_dir)


def _resolve(specs: Mapping[str, Spec], values: Mapping[str, Value], paths: Mapping[str, Any]) -> dict[str, Any]:
    resolved = {
        key: spec.read(values[key]) if key in values else spec.default
        for key, spec in specs.items()
        if key in values or not spec.is_expert
    }
    resolved.update(paths)
    resolved.update({key: value.raw for key, value in values.items() if key not in specs})
    plain = {key: list(v) if isinstance(v, tuple) else v for key, v in resolved.items()}
    return {key: v for key, v in plain.items() if v != []}


def _nested(flat: Mapping[str, Any]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for key, value in flat.items():
        *groups, name = key.split(".")
        branch = tree
        for group in groups:
            branch = branch.setdefault(group, {})
        branch[name] = value
    return tree
