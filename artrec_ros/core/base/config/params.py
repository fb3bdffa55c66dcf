"""Fields of configuration dataclasses that know their unit, range, meaning and origin."""

from __future__ import annotations

import dataclasses
import typing
from dataclasses import field
from functools import cache
from typing import Any

from ..errors import ConfigError

PATHS = ("plane", "space", "facing", "paper")
"""Ways of recognition: the default profile in the image plane and in space, and profile `paper`."""


def param(
    default: Any,
    description: str,
    *,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    length: int = 0,
    choices: tuple[str, ...] = (),
    paths: tuple[str, ...] = PATHS,
    calibrated: bool = False,
    origin: str = "",
) -> Any:
    """A dataclass field that knows its unit, inclusive range or choices, and what it means.

    :param length: how many numbers a list has; 0: any number.
    :param paths: the ways of recognition that read it, of `PATHS`.
    :param calibrated: whether it acts on calibrated images alone.
    :param origin: where the default comes from: a reason, a fit or a measured sensitivity.
    """
    if isinstance(default, (list, dict)):
        raise TypeError("use a tuple for defaults")
    if not set(paths) <= set(PATHS):
        raise TypeError(f"paths: {paths} are not all of {PATHS}")
    meta = {"description": description, "unit": unit, "low": low, "high": high, "length": length, "choices": choices}
    return field(default=default, metadata={**meta, "paths": paths, "calibrated": calibrated, "origin": origin})


def room(config: type) -> Any:
    """A field that holds a room's own config: what only experts change. In files it is `expert.FIELD`."""
    return field(default_factory=config)


@cache
def rooms_of(config: type) -> dict[str, type]:
    """The configs that a config holds in fields made by `room`, by the fields' names."""
    hints = typing.get_type_hints(config)
    kinds = {f.name: hints[f.name] for f in dataclasses.fields(config)}
    return {name: kind for name, kind in kinds.items() if isinstance(kind, type) and issubclass(kind, Room)}


def validate(config: Any, prefix: str = "") -> None:
    """Raise `ConfigError` naming the first value of a `param` dataclass that is out of its range."""
    for f in dataclasses.fields(config):
        value, meta, name = getattr(config, f.name), f.metadata, prefix + f.name
        if meta.get("choices") and value not in meta["choices"]:
            raise ConfigError(f"{name}: '{value}' is none of {', '.join(meta['choices'])}")
        if meta.get("length") and len(value) != meta["length"]:
            raise ConfigError(f"{name}: {len(value)} numbers are given; it has {meta['length']}")
        for v in value if isinstance(value, tuple) else (value,):
            if isinstance(v, (str, bool)):
                continue
            if meta.get("low") is not None and not v >= meta["low"]:
                raise ConfigError(f"{name}: {v} is below its least value {meta['low']} {meta['unit']}".rstrip())
            if meta.get("high") is not None and not v <= meta["high"]:
                raise ConfigError(f"{name}: {v} is above its greatest value {meta['high']} {meta['unit']}".rstrip())


class Room:
    """Base of a room's config: its values are checked, and named as in files."""

    def __post_init__(self) -> None:
        validate(self, f"expert.{room_name(type(self))}.")


def room_name(config: type) -> str:
    """What a room's config is called in files: its class's name without `Config`, in small letters."""
    return config.__name__.removesuffix("Config").lower()
