"""Lines of JSON: what is wrong with one, in words."""

from __future__ import annotations

import json
from typing import Any, NoReturn


def strict_json(line: str) -> Any:
    """A line's content. :raises ValueError: it is no JSON, or holds NaN or an infinity, as Python writes them."""
    return json.loads(line.rstrip("\r\n"), parse_constant=_refuse)  # in a line that is cut off its end is no mistake


def fault(error: Exception) -> str:
    """Why a line could not be read."""
    if isinstance(error, json.JSONDecodeError):
        return f"no valid JSON at column {error.colno}: {error.msg}"
    if isinstance(error, KeyError):
        return f"the key {error} is missing"
    return str(error)


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no number")
