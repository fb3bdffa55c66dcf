"""JSON files, read as a whole: what is wrong with one is told by file, line and key."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, TypeVar

from ...core.base.errors import ConfigError
from .kinds import COCO, mistaken
from .typed import UnfitError, typed
from .yaml_files import Value, load_value, read_text

T = TypeVar("T")
_MOST_BYTES = 2**30  # COCO itself has a quarter of that


def typed_value(value: Value, hint: type[T]) -> T:
    """What a file holds, by a type hint. :raises ConfigError: naming file and key."""
    try:
        return typed(value.raw, hint)
    except UnfitError as error:
        raise value.error(str(error)) from None


def read_json(path: Path) -> Value:
    """A JSON file as a `Value`."""
    text = read_text(path, _MOST_BYTES)
    try:
        return Value(path, "", json.loads(text, object_pairs_hook=_unique))
    except json.JSONDecodeError as error:
        if path.suffix.lower() in (".yaml", ".yml") and (problem := mistaken(load_value(path).raw, COCO)):
            raise ConfigError(f"{path}: {problem}") from None
        raise ConfigError(f"{path}: line {error.lineno}: is no valid JSON: {error.msg}") from None
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None
    except RecursionError:
        raise ConfigError(f"{path}: is no JSON that can be read: it is nested too deeply") from None
    except ValueError:  # Python reads no number of thousands of digits
        raise ConfigError(f"{path}: is no JSON that can be read: a number in it is too long") from None


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    entries = dict(pairs)
    if len(entries) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ConfigError(f"the key '{twice}' is given twice in one object; keep one")
    return entries
