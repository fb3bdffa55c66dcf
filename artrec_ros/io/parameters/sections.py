"""The sections of ROS parameter files: which parameters they give to which node."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ...core.base.errors import ConfigError
from ..base.kinds import PARAMETERS, holds_parameters, mistaken
from ..base.shared_files import SCHEME, resolve_path
from ..base.yaml_files import Value, check_size, load_value

SECTION = "ros__parameters"
FILES = ("object_file", "constraint_file")  # parameters of an object that name files
MOST_BYTES = 2**18
"""Of a parameter file: ROS' own reader takes time by the square of it, here some 4 s, and hears no Ctrl-C."""


class Given(NamedTuple):
    """What parameter files say. :param flat: values by their flat names. :param folder: where relative file names
    start. :param source: the files, as errors name them."""

    flat: dict[str, Any]
    folder: Path
    source: str


def read_files(*paths: str | Path) -> Given:
    """As in ROS the later ones go before. Relative file names start at the folder of the file that gives them, or at
    `config_dir`."""
    first, *others = (Path(path).absolute().parent for path in paths)
    each, source = [read_flat(path) for path in paths], ", ".join(map(str, paths))
    flat = {key: value for given in each for key, value in given.items()}
    config_dir = flat.get("config_dir")
    if isinstance(config_dir, str):
        return Given(flat, resolve_path(config_dir, first), source)
    flat = dict(each[0])
    for given, folder in zip(each[1:], others, strict=True):
        flat |= {key: _beside(folder, value) if names_file(key) else value for key, value in given.items()}
    return Given(flat, first, source)


def names_file(parameter: str) -> bool:
    """Whether a parameter's value, by its flat name, is the name of a file."""
    return parameter.rpartition(".")[2] in FILES


def _beside(folder: Path, name: Any) -> Any:
    """A relative name of a file as one that starts at a folder; others, and what is none, as they are."""
    return str(resolve_path(name, folder)) if isinstance(name, str) and name and not name.startswith(SCHEME) else name


def _load_parameter_file(path: str | Path) -> Value:
    """All that it holds."""
    check_size(path, MOST_BYTES)
    return load_value(path)


def read_flat(path: str | Path) -> dict[str, Any]:
    """The parameters of a ROS parameter file by their flat names; a node's own section goes before the wildcard's."""
    value = _load_parameter_file(path)
    if problem := mistaken(value.raw, PARAMETERS):
        raise value.error(f"{problem}, which names the object's file (docs/parameters.md)")
    sections = _sections(value) if not isinstance(value.raw, dict) or holds_parameters(value.raw) else {}
    if not sections:
        raise ConfigError(f"{path}: no parameters found; they stand under '/**:' and '{SECTION}:'")
    named = [name for name in sections if name.rpartition("/")[2] not in ("**", "*")]
    ours = [name for name in named if name.rpartition("/")[2].startswith("artrec")]
    ours = ours or [name for name in named if "objects" in sections[name].entries()]
    if len(ours) > 1:
        raise ConfigError(f"{path}: parameters of {len(ours)} nodes ({', '.join(ours)}); keep one, or use '/**:'")
    flat: dict[str, Value] = {}
    for name in [*(n for n in sections if n not in named), *ours]:
        flat.update(_flatten(sections[name]))
    return {key: value.raw for key, value in flat.items()}


def check_sections(paths: Sequence[Path], node: str) -> None:
    """:param node: with its namespace. :raises ConfigError: no section of the files is this node's."""
    names = [name for path in paths for name in _sections(_load_parameter_file(path))]
    if names and not any(_matches(name, node) for name in names):
        files = ", ".join(map(str, paths))
        raise ConfigError(
            f"{files}: no section matches the node {node} (there: {', '.join(names)}); use '/**:', which matches all"
        )


def check_own(path: Path, node: str) -> None:
    """What the node is given is what files say offline: ROS' own reader takes the last of keys that are given twice, in
    whichever spelling, without a word.

    :param node: with its namespace. :raises ConfigError: a key of its sections is given twice.
    """
    for name, section in _sections(_load_parameter_file(path)).items():
        if _matches(name, node):
            _flatten(section)


def _matches(name: str, node: str) -> bool:
    """As ROS reads the wildcards of sections: `*` is one part of a name, `**` any number of them."""
    pattern = re.escape(f"/{name.strip('/')}").replace(r"/\*\*", "(/[^/]+)*").replace(r"\*", "[^/]+")
    return re.fullmatch(pattern, node) is not None


def _sections(value: Value, name: str = "") -> dict[str, Value]:
    """The `ros__parameters` of each node that a parameter file names."""
    found: dict[str, Value] = {}
    for key, child in value.entries().items():
        if key == SECTION:
            if not name:
                raise child.error("stands under a node's name, such as '/**:'")
            found[name] = Value(value.file, "", child.raw)
        else:
            found.update(_sections(child, f"{name}/{key.strip('/')}" if name else key))
    return found


def _flatten(section: Value) -> dict[str, Value]:
    """Nested keys joined by dots; the section itself is not part of the names."""
    flat: dict[str, Value] = {}
    for key, child in section.entries().items():
        for full, value in (_flatten(child) if isinstance(child.raw, dict) else {child.key: child}).items():
            if full in flat:
                raise value.error(f"is given twice, once of them as '{key}'; keep one")
            _check_readable(value)
            flat[full] = value
    return flat


def _check_readable(value: Value) -> None:
    """Whether the node would read a value, too: ROS knows no empty ones, and all of its lists have items of one kind.

    :raises ConfigError: it would not start.
    """
    if value.raw is None:
        raise value.error(
            "has no value, as a section of which all lines are comments; ROS starts no node by that, or takes it for "
            "text; leave it out"
        )
    kinds = {type(item) for item in value.raw} if isinstance(value.raw, list) else set()
    if kinds == {int, float}:
        whole = next(item for item in value.raw if isinstance(item, int))
        raise value.error(f"ROS reads no list in which some numbers have a point and some have none; write {whole}.0")
    if len(kinds) > 1:
        raise value.error("ROS reads no list of items of several kinds; quotes make text of an item")
