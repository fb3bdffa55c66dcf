"""A recogniser's configuration by the bare names of its values, whichever room they are in."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from artrec_ros.core.base.config import RecognizerConfig, rooms_of

DEFAULTS = RecognizerConfig()


def settings(**values: Any) -> RecognizerConfig:
    """`paper_NAME` is a value of profile paper."""
    own = {f.name for f in dataclasses.fields(RecognizerConfig)}
    return _with_values(RecognizerConfig(), {n if n in own else _in_room(n): v for n, v in values.items()})


def _in_room(name: str) -> str:
    for room, config in rooms_of(RecognizerConfig).items():
        for field in dataclasses.fields(config):
            if name in (field.name, f"{room}_{field.name}"):
                return f"{room}.{field.name}"
    raise TypeError(f"no room of the recogniser has a value {name}")


def _with_values(config: Any, values: Mapping[str, Any]) -> Any:
    """The same config with other values, by their names; in a room `ROOM.NAME`."""
    own = {name: value for name, value in values.items() if "." not in name}
    for name in {name.partition(".")[0] for name in values if "." in name}:
        inner = {key.partition(".")[2]: value for key, value in values.items() if key.startswith(f"{name}.")}
        own[name] = _with_values(getattr(config, name), inner)
    return dataclasses.replace(config, **own)
