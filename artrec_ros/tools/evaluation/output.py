"""Writes what evaluation makes: each file whole or not at all: a full disk leaves earlier ones as they are."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...core.base.errors import SourceError
from ...io.base import whole_files


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    write_whole(path, json.dumps(content, indent=2, ensure_ascii=False) + "\n")


def write_whole(path: Path, text: str) -> None:
    """:raises SourceError: the file cannot be written; what was there before still is."""
    try:
        whole_files.write_whole(path, text)
    except OSError as error:
        raise SourceError(f"{path}: cannot be written: {error.strerror}; an earlier one is as it was") from error
