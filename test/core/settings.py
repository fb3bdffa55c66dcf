"""A recogniser's configuration by the bare names of its values, whichever room they are in."""

from __future__ import annotations

import dataclasses
from typing import Any

from artrec_ros.core.base.config import RecognizerConfig, rooms_of, with_values

DEFAULTS = RecognizerConfig()


def settings(**values: Any) -> RecognizerConfig:
    """`paper_NAME` is a value of profile paper."""
    own = {f.name for f in dataclasses.fields(RecognizerConfig)}
    return with_values(RecognizerConfig(), {n if n in own else _in_room(n): v for n, v in values.items()})


def _in_room(name: str) -> str:
    for room, config in rooms_of(RecognizerConfig).items():
        for field in dataclasses.fields(config):
            if name in (field.name, f"{room}_{field.name}"):
                return f"{room}.{field.name}"
    raise TypeError(f"no room of the recogniser has a value {name}")
