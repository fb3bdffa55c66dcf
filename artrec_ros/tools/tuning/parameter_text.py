"""A parameter file with some values changed: what a person wrote in it, comments included, stays."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from ...core.base.errors import ArtrecError
from ...io.base.shared_files import SCHEME
from ...io.parameters.parameter_file import Setup, load_parameters
from ...io.parameters.sections import SECTION, read_flat
from ...io.parameters.specs import Spec


def tuned_text(paths: Sequence[Path], setup: Setup, changes: Mapping[str, Any], target: Path, note: str) -> str:
    """The text for `target`, so that it gives `setup`.

    :param paths: the parameter files; of several, or one of an unusual form, only the values are kept.
    :param changes: flat parameters that differ from the files'. :param note: comes first, as a comment.
    """
    head = "".join(f"# {line}\n" for line in note.splitlines())
    if len(paths) == 1:
        text = _edited(paths[0], setup, changes, target)
        if text is not None and _gives(head + text, setup, target):
            return head + text
    return head + setup.to_yaml()


def _gives(text: str, setup: Setup, target: Path) -> bool:
    part = target.with_name(target.name + ".part")
    part.write_text(text, encoding="utf-8")
    try:
        return _comparable(load_parameters(part)) == _comparable(setup)
    except ArtrecError:
        return False
    finally:
        part.unlink()


def _comparable(setup: Setup) -> dict[str, Any]:
    files = _file_keys(setup)
    return {key: os.path.normpath(value) if key in files else value for key, value in setup.resolved.items()}


def _file_keys(setup: Setup) -> list[str]:
    keys = [f"{t.name}.{kind}" for t in setup.targets for kind in ("object_file", "constraint_file")]
    return [key for key in keys if setup.resolved.get(key)]


@dataclass(frozen=True)
class _Edit:
    """Text from `start` to `end` becomes `text`."""

    start: int
    end: int
    text: str


def _edited(path: Path, setup: Setup, changes: Mapping[str, Any], target: Path) -> str | None:
    """The file's text with these values; None where its form is not understood."""
    text = path.read_text(encoding="utf-8")
    sections = _sections(yaml.compose(text, yaml.SafeLoader))
    if len(sections) != 1 or not sections[0].value:
        return None
    wanted = {**_moved_files(path, setup, target), **changes}
    specs = setup.specs
    for key, value in wanted.items():  # each edit moves what is behind it
        (section,) = _sections(yaml.compose(text, yaml.SafeLoader))
        edit = _edit(text, section, key.split("."), value, specs[key])
        if edit is None:
            return None
        text = text[: edit.start] + edit.text + text[edit.end :]
    return text


def _sections(node: Any) -> list[yaml.MappingNode]:
    if not isinstance(node, yaml.MappingNode):
        return []
    found = []
    for key, value in node.value:
        if key.value == SECTION and isinstance(value, yaml.MappingNode):
            found.append(value)
        else:
            found += _sections(value)
    return found


def _moved_files(path: Path, setup: Setup, target: Path) -> dict[str, str]:
    """Names of files that are relative to the parameter file's folder, as they are from the target's."""
    given = read_flat(path)
    folder = target.absolute().parent
    return {
        key: os.path.relpath(setup.resolved[key], folder)
        for key in _file_keys(setup)
        if key in given
        and "config_dir" not in given
        and not (given[key].startswith(SCHEME) or Path(given[key]).is_absolute())
    }


def _edit(text: str, node: yaml.MappingNode, path: list[str], value: Any, spec: Spec) -> _Edit | None:
    for key, child in node.value:
        names = key.value.split(".")
        if names == path:
            return _Edit(child.start_mark.index, child.end_mark.index, _shown(value))
        if names == path[: len(names)] and isinstance(child, yaml.MappingNode) and child.value:
            return _edit(text, child, path[len(names) :], value, spec)
    if node.flow_style:
        end = node.end_mark.index - 1
        return _Edit(end, end, f", {'.'.join(path)}: {_shown(value)}")
    return _added(node, path, value, spec)


def _added(node: yaml.MappingNode, path: list[str], value: Any, spec: Spec) -> _Edit:
    """A line, or some, below the first line of a block."""
    first = node.value[0][0].start_mark
    lines, indent = [], first.column
    for group in path[:-1]:
        lines.append(" " * indent + group + ":")
        indent += 2
    meaning = f"{spec.unit}: {spec.description}" if spec.unit else spec.description
    lines.append(" " * indent + f"{path[-1]}: {_shown(value)}  # {meaning}")
    start = first.index - first.column
    return _Edit(start, start, "\n".join(lines) + "\n")


def _shown(value: Any) -> str:
    """As YAML and ROS read it: floats keep their point."""
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)
