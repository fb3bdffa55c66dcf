"""summary.json of a replay."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

from ..base.json_files import read_json, typed_value
from ..base.kinds import SUMMARY, mistaken


@dataclass(frozen=True)
class LookedFor:
    """An object that a replay looked for: its class label and the name of its required component."""

    label: int
    required: str


class Times(TypedDict):
    """Of the frames, milliseconds."""

    median: float
    max: float


class _Summary(TypedDict):
    sources: tuple[str, ...]
    looked_for: dict[str, LookedFor]
    frames: int
    frames_with_error: int
    objects: dict[str, int]
    total_ms: Times | None
    problems: tuple[str, ...]
    interrupted: bool


class SummaryContent(_Summary, total=False):
    versions: dict[str, str]


def read_summary(path: Path) -> SummaryContent:
    """:raises ConfigError: naming file and key."""
    value = read_json(path)
    if problem := mistaken(value.raw, SUMMARY):
        raise value.error(problem)
    return typed_value(value, SummaryContent)
