"""Fields of configuration dataclasses that know their unit, range and meaning."""

from __future__ import annotations

import dataclasses
from dataclasses import field
from typing import Any

from ..errors import ConfigError


def param(
    default: Any,
    description: str,
    *,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
) -> Any:
    """A dataclass field that knows its unit, inclusive range or choices, and what it means."""
    meta = {"description": description, "unit": unit, "low": low, "high": high, "choices": choices}
    if isinstance(default, (list, dict)):
        raise TypeError("use a tuple for defaults")
    return field(default=default, metadata=meta)


def validate(config: Any, prefix: str = "") -> None:
    """Raise `ConfigError` naming the first value of a `param` dataclass that is out of its range."""
    for f in dataclasses.fields(config):
        value, meta, name = getattr(config, f.name), f.metadata, prefix + f.name
        if meta.get("choices") and value not in meta["choices"]:
            raise ConfigError(f"{name}: '{value}' is none of {', '.join(meta['choices'])}")
        for v in value if isinstance(value, tuple) else (value,):
            if isinstance(v, (str, bool)):
                continue
            if meta.get("low") is not None and not v >= meta["low"]:
                raise ConfigError(f"{name}: {v} is below its least value {meta['low']} {meta['unit']}".rstrip())
            if meta.get("high") is not None and not v <= meta["high"]:
                raise ConfigError(f"{name}: {v} is above its greatest value {meta['high']} {meta['unit']}".rstrip())
