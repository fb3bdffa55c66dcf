"""Room `pose`: how a frame is searched for whole objects."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room


@dataclass(frozen=True)
class SearchConfig(Room):
    """Room `pose`: how a frame is searched for whole objects."""
