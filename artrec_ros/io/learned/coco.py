"""COCO files: their tables, row by row."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ...core.base.errors import ConfigError
from ..base.json_files import read_json
from ..base.kinds import COCO, mistaken
from ..base.yaml_files import Value


def read_coco(path: Path) -> dict[str, Value]:
    """The top level of a COCO file, in which its three tables are."""
    value = read_json(path)
    if problem := mistaken(value.raw, COCO):
        raise value.error(problem)
    top = value.entries()
    for key in ("images", "annotations", "categories"):
        if key not in top:
            raise ConfigError(f"{path}: {key}: this key is missing; a COCO file is wanted")
    return top


def coco_entry(value: Value, key: str) -> Value:
    """COCO files have keys of other tools too: they are passed over."""
    entries = value.entries()
    if key not in entries:
        raise value.error(f"{key}: this key is missing")
    return entries[key]


def rows_of(table: Value) -> Iterator[Value]:
    """The rows of a table. :raises ConfigError: two have one id."""
    seen: set[int] = set()
    for row in table.items():
        number = coco_entry(row, "id")
        if number.integer() in seen:
            raise number.error(f"the id {number.raw} is there twice")
        seen.add(number.integer())
        yield row


def coco_image(value: Value, folder: Path) -> tuple[int, tuple[Path, tuple[int, int] | None]]:
    """An image's id, its file, and its (width, height) where the file tells it."""
    entries, size = value.entries(), None
    if "width" in entries and "height" in entries:
        size = (int(entries["width"].number(1)), int(entries["height"].number(1)))
    return coco_entry(value, "id").integer(), (folder / coco_entry(value, "file_name").text(), size)
